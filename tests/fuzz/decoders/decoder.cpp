#include "tests/fuzz/decoders/decoder.hpp"

#include <algorithm>
#include <array>
#include <cstdio>
#include <cstdlib>
#include <spdlog/spdlog.h>
#include <unistd.h>

#include "tests/support/process.hpp"
#include "tests/support/temporary_folder.hpp"

namespace tonus::fuzz {

std::span<const Decoder> decoders() {
  static const std::array kAll{
      Decoder{"cdr", "messages of every topic", read_cdr, cdr_seeds},
      Decoder{"blocks", "blocks of samples on their way into an archive", read_block, block_seeds},
      Decoder{"rtps", "datagrams before Fast DDS has them", read_rtps, rtps_seeds},
      Decoder{"protocol", "protocol files", read_protocol, protocol_seeds},
      Decoder{"profile", "profiles and cohorts of simulated rigs", read_profile, profile_seeds},
      Decoder{"rig", "a rig's calibration", read_rig, rig_seeds},
      Decoder{"settings", "tonus.toml", read_settings, settings_seeds},
      Decoder{"bids", "BIDS datasets, one file of one damaged", read_bids, bids_seeds},
      Decoder{"json", "side files of datasets", read_json, json_seeds},
      Decoder{"spool", "the rig's spool", read_spool, spool_seeds},
      Decoder{"trials", "the rig's log of trials", read_trial_log, trial_log_seeds},
      Decoder{"hold", "the rig's hold", read_hold, hold_seeds},
      Decoder{"journal", "the scheduler's journal", read_journal, journal_seeds},
      Decoder{"websocket", "frames of a page's WebSocket", read_websocket, websocket_seeds},
      Decoder{"requests", "an operator's requests", read_request, request_seeds},
      Decoder{"http", "targets, queries and cookies of HTTP requests", read_http, http_seeds},
      Decoder{"pages", "pages of a damaged SQLite file", read_sqlite_pages, sqlite_pages_seeds}};
  static const bool kIsSilent = [] {
    spdlog::set_level(spdlog::level::off);
    return true;
  }();
  static_cast<void>(kIsSilent);
  return kAll;
}

const Decoder* find_decoder(std::string_view name) {
  const auto all = decoders();
  const auto found =
      std::find_if(all.begin(), all.end(), [&](const auto& each) { return each.name == name; });
  return found == all.end() ? nullptr : &*found;
}

void require(bool is_kept, std::string_view promise) {
  if (is_kept) return;
  std::fprintf(stderr, "broken promise: %.*s\n", static_cast<int>(promise.size()), promise.data());
  std::abort();
}

void require_message(const Error& error) {
  if (!error.message.empty() && error.message.find('\n') == std::string::npos) return;
  std::fprintf(stderr, "'%s'\n", error.message.c_str());
  require(false, "a refusal is one line that is not empty");
}

void put_part(Bytes& input, std::span<const std::byte> part) {
  input.push_back(static_cast<std::byte>(part.size() & 0xffU));
  input.push_back(static_cast<std::byte>(part.size() >> 8U & 0xffU));
  input.insert(input.end(), part.begin(), part.end());
}

Bytes source_bytes(const std::string& path) { return read_bytes(testing::source_file(path).string()); }

const std::string& scratch_folder() {
  // In memory, where there is such a folder and nobody said otherwise: these files are written all the time.
  static const bool kIsSet = ::access("/dev/shm", W_OK) != 0 || ::setenv("TMPDIR", "/dev/shm", 0) == 0;
  static_cast<void>(kIsSet);
  static const testing::TemporaryFolder kFolder;
  static const std::string kPath = kFolder.path().string();
  return kPath;
}

}  // namespace tonus::fuzz
