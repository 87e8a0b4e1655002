#pragma once

#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "services/core/result.hpp"
#include "tests/fuzz/damage.hpp"

namespace tonus::fuzz {

/// One reader of bytes from outside, as libFuzzer and the tests call it.
struct Decoder {
  std::string_view name;
  std::string_view reads;  ///< What, for a person.
  void (*run)(
      std::span<const std::byte> input);  ///< Any input. A broken promise ends the process: require().
  std::vector<Bytes> (*seeds)();          ///< Good inputs of the present formats.
};

/// Every one. Also silences the log, which damaged input would fill.
[[nodiscard]] std::span<const Decoder> decoders();

/// Null: there is none of this name.
[[nodiscard]] const Decoder* find_decoder(std::string_view name);

/// Ends the process with `promise` on standard error unless it is kept.
void require(bool is_kept, std::string_view promise);

/// A refusal is one line that says something.
void require_message(const Error& error);
template <typename T>
void require_message(const Result<T>& result) {
  if (!result) require_message(result.error());
}

/// An input taken apart: numbers and parts with their length before them, then the rest.
class Parts {
 public:
  explicit Parts(std::span<const std::byte> input) : rest_(input) {}

  [[nodiscard]] bool is_empty() const { return rest_.empty(); }
  [[nodiscard]] std::uint8_t byte() { return rest_.empty() ? 0 : static_cast<std::uint8_t>(take(1)[0]); }
  /// Two bytes of length, little endian, and so many bytes or what there is.
  [[nodiscard]] std::span<const std::byte> part() {
    const std::size_t low = byte();
    return take(low | static_cast<std::size_t>(byte()) << 8U);
  }
  [[nodiscard]] std::span<const std::byte> rest() { return take(rest_.size()); }

 private:
  std::span<const std::byte> take(std::size_t count) {
    const auto taken = rest_.first(std::min(count, rest_.size()));
    rest_ = rest_.subspan(taken.size());
    return taken;
  }
  std::span<const std::byte> rest_;
};

/// The inverse of Parts::part(), for seeds.
void put_part(Bytes& input, std::span<const std::byte> part);

[[nodiscard]] inline std::string_view text_of(std::span<const std::byte> bytes) {
  return {reinterpret_cast<const char*>(bytes.data()), bytes.size()};
}
[[nodiscard]] inline Bytes bytes_of(std::string_view text) {
  const auto bytes = std::as_bytes(std::span(text));
  return {bytes.begin(), bytes.end()};
}

/// A file of the source tree, "deploy/protocols/study.toml".
[[nodiscard]] Bytes source_bytes(const std::string& path);

/// Where decoders of files put them: a folder of this process, which goes with it.
[[nodiscard]] const std::string& scratch_folder();

// The readers, one function for each decoder, by file.
void read_cdr(std::span<const std::byte> input);
std::vector<Bytes> cdr_seeds();
void read_block(std::span<const std::byte> input);
std::vector<Bytes> block_seeds();
void read_rtps(std::span<const std::byte> input);
std::vector<Bytes> rtps_seeds();
void read_protocol(std::span<const std::byte> input);
std::vector<Bytes> protocol_seeds();
void read_profile(std::span<const std::byte> input);
std::vector<Bytes> profile_seeds();
void read_rig(std::span<const std::byte> input);
std::vector<Bytes> rig_seeds();
void read_settings(std::span<const std::byte> input);
std::vector<Bytes> settings_seeds();
void read_bids(std::span<const std::byte> input);
std::vector<Bytes> bids_seeds();
void read_json(std::span<const std::byte> input);
std::vector<Bytes> json_seeds();
void read_spool(std::span<const std::byte> input);
void read_trial_log(std::span<const std::byte> input);
void read_hold(std::span<const std::byte> input);
std::vector<Bytes> spool_seeds();
std::vector<Bytes> trial_log_seeds();
std::vector<Bytes> hold_seeds();
void read_journal(std::span<const std::byte> input);
std::vector<Bytes> journal_seeds();
void read_websocket(std::span<const std::byte> input);
std::vector<Bytes> websocket_seeds();
void read_request(std::span<const std::byte> input);
std::vector<Bytes> request_seeds();
void read_http(std::span<const std::byte> input);
std::vector<Bytes> http_seeds();
void read_sqlite_pages(std::span<const std::byte> input);
std::vector<Bytes> sqlite_pages_seeds();

}  // namespace tonus::fuzz
