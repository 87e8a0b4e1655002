#include "services/core/clock.hpp"
#include "services/scheduler/journal.hpp"
#include "services/scheduler/session_machine.hpp"
#include "tests/fuzz/decoders/decoder.hpp"

namespace tonus::fuzz {
namespace {

constexpr std::string_view kContract = "contract";

/// A journal's file in memory.
class Octets final : public scheduler::JournalStorage {
 public:
  explicit Octets(std::string octets) : octets_(std::move(octets)) {}
  Result<std::string> read_all() override { return octets_; }
  Result<void> append(std::string_view octets) override {
    octets_ += octets;
    return {};
  }
  Result<void> sync() override { return {}; }
  Result<void> truncate(std::size_t size) override {
    require(size <= octets_.size(), "a journal is cut within its length");
    octets_.resize(size);
    return {};
  }

 private:
  std::string octets_;
};

void put(std::string& out, std::uint32_t value) {
  for (unsigned shift = 0; shift < 32; shift += 8) out.push_back(static_cast<char>(value >> shift & 0xffU));
}

std::string frame(std::uint32_t number, std::string_view content) {
  std::string numbered;
  put(numbered, number);
  std::string out = "TNSJ";
  put(out, static_cast<std::uint32_t>(content.size()));
  out += numbered;
  put(out, scheduler::crc32(content, scheduler::crc32(numbered)));
  out += content;
  return out;
}

/// An odd first byte: a journal as it is. Even: good frames of the parts.
std::string journal_of(std::span<const std::byte> input) {
  Parts parts(input);
  if (parts.byte() % 2 == 1) return std::string(text_of(parts.rest()));
  std::string octets = frame(0, kContract);
  for (std::uint32_t number = 1; !parts.is_empty(); ++number) octets += frame(number, text_of(parts.part()));
  return octets;
}

}  // namespace

void read_journal(std::span<const std::byte> input) {
  auto opened = scheduler::Journal::open(std::make_unique<Octets>(journal_of(input)), kContract);
  require_message(opened);
  if (!opened) return;
  if (const auto written = scheduler::encode_records(opened->records)) {
    const auto again = scheduler::decode_records(*written);
    require(again && scheduler::encode_records(*again).value() == *written,
            "records are the same after they are written and read");
  }
  const ManualClock clock;
  scheduler::SessionMachine machine(clock, "fuzz");
  require_message(machine.restore(opened->records));
}

std::vector<Bytes> journal_seeds() {
  scheduler::record::Started started;
  started.session_id = id_of("session");
  started.protocol_toml = std::string(text_of(source_bytes("deploy/protocols/unloaded.toml")));
  started.subject = "s01";
  started.started_at = "2026-03-01T10:00:00Z";
  scheduler::record::Bound bound;
  bound.rig_id = id_of("rig/fuzz");
  bound.home = {0.0, 0.45};
  scheduler::record::Commanded commanded;
  commanded.program.session_id(started.session_id);
  commanded.program.attempt(1);
  const auto first = scheduler::encode_records({started, bound});
  const auto second = scheduler::encode_records({commanded, scheduler::record::Counted{1, 3.0}});
  const auto third = scheduler::encode_records(
      {scheduler::record::Requested{id_of("request"), v1::SESSION_ABORT}, scheduler::record::Ended{}});
  Bytes framed{std::byte{0}};
  Bytes raw{std::byte{1}};
  std::string octets = frame(0, kContract);
  std::uint32_t number = 0;
  for (const auto* records : {&first, &second, &third}) {
    put_part(framed, bytes_of(records->value()));
    octets += frame(++number, records->value());
  }
  const Bytes all = bytes_of(octets);
  raw.insert(raw.end(), all.begin(), all.end());
  return {framed, raw};
}

}  // namespace tonus::fuzz
