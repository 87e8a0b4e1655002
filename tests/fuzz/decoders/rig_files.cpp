// What the rig agent finds on its own disk.

#include <filesystem>
#include <spdlog/fmt/fmt.h>

#include "rig_agent/agent/hold_latch.hpp"
#include "rig_agent/agent/spool.hpp"
#include "rig_agent/agent/trial_log.hpp"
#include "services/core/record_file.hpp"
#include "tests/fuzz/decoders/decoder.hpp"

namespace tonus::fuzz {
namespace {

namespace fs = std::filesystem;

/// A file of the input's making. An odd first byte: the bytes as they are. Even: good records of the parts,
/// so that what is in them is read and not only refused by its checksum; then the rest of the bytes.
void write_records(const fs::path& path, std::span<const std::byte> input) {
  std::error_code ignored;
  fs::remove(path, ignored);
  Parts parts(input);
  if (parts.byte() % 2 == 1) {
    const auto raw = parts.rest();
    write_bytes(path.string(), Bytes(raw.begin(), raw.end()));
    return;
  }
  auto file = RecordFile::open(path, [](auto, auto) {});
  require(file.has_value(), "a file can be made");
  while (!parts.is_empty()) require(file->append(parts.part()).has_value(), "a record can be written");
}

Bytes records_of(const fs::path& path) {
  Bytes input{std::byte{0}};
  auto file =
      RecordFile::open(path, [&](auto, std::span<const std::byte> content) { put_part(input, content); });
  require(file.has_value(), "what was just written can be read");
  return input;
}

Bytes raw_of(const fs::path& path) {
  Bytes input = read_bytes(path.string());
  input.insert(input.begin(), std::byte{1});
  return input;
}

fs::path empty_folder(const char* name) {
  const fs::path folder = fs::path(scratch_folder()) / name;
  fs::remove_all(folder);
  fs::create_directories(folder);
  return folder;
}

}  // namespace

void read_spool(std::span<const std::byte> input) {
  const fs::path folder = empty_folder("spool");
  write_records(folder / fmt::format("{:020}-{:020}.spool", 7, 0), input);
  rig::SpoolOptions options;
  options.folder = folder;
  options.max_bytes = 1U << 20U;
  auto spool = rig::Spool::open(options);
  require_message(spool);
  if (!spool) return;
  for (const auto& range : spool->left_behind(8)) {
    require(range.first_sequence <= range.last_sequence, "a run of samples has a beginning before its end");
    require_message(spool->read(range.epoch, range.first_sequence, range.last_sequence, [](auto) {}));
  }
  static_cast<void>(spool->received(7, 0, spool->last_sequence(7).value_or(0)));
  require_message(spool->append(9, 0, 1, {input.first(std::min<std::size_t>(input.size(), 64)), {}}));
  require_message(spool->sync());
}

std::vector<Bytes> spool_seeds() {
  const fs::path folder = empty_folder("spool");
  rig::SpoolOptions options;
  options.folder = folder;
  {
    auto spool = rig::Spool::open(options);
    require(spool.has_value(), "a spool can be made");
    const Bytes payload = bytes_of("a block of samples");
    for (std::uint64_t first = 0; first < 300; first += 100)
      static_cast<void>(spool->append(7, first, 100, {payload, payload}));
  }
  const fs::path file = fs::directory_iterator(folder)->path();
  return {raw_of(file), records_of(file)};
}

void read_trial_log(std::span<const std::byte> input) {
  const fs::path path = empty_folder("trials") / "trials.log";
  write_records(path, input);
  auto log = rig::TrialLog::open(path);
  require_message(log);
  if (!log) return;
  const std::size_t outcomes = log->outcomes().size();
  require_message(log->rewrite());
  const auto again = rig::TrialLog::open(path);
  require(again && again->outcomes().size() == outcomes, "a log that was written anew says the same");
}

std::vector<Bytes> trial_log_seeds() {
  const fs::path path = empty_folder("trials") / "trials.log";
  {
    auto log = rig::TrialLog::open(path);
    require(log.has_value(), "a log can be made");
    v1::TrialCommand command;
    v1::TrialOutcome outcome;
    outcome.trial_id(trial_id(id_of("session"), 1));
    static_cast<void>(log->begun(command, 7, 100));
    static_cast<void>(log->ended(outcome));
    static_cast<void>(log->received(7, 200));
    static_cast<void>(log->begun(command, 7, 300));
  }
  return {raw_of(path), records_of(path)};
}

void read_hold(std::span<const std::byte> input) {
  const fs::path path = empty_folder("hold") / "hold";
  write_bytes(path.string(), Bytes(input.begin(), input.end()));
  auto latch = rig::HoldLatch::open(path);
  require_message(latch);
  if (!latch) return;
  require_message(latch->hold("a reason"));
  require(latch->number() != 0, "a rig that is held has a hold with a number");
  require_message(latch->clear(latch->number()));
}

std::vector<Bytes> hold_seeds() {
  const fs::path path = empty_folder("hold") / "hold";
  {
    auto latch = rig::HoldLatch::open(path);
    require(latch.has_value(), "a latch can be made");
    static_cast<void>(latch->hold("the handle was stopped"));
    static_cast<void>(latch->set_powered(true));
  }
  return {read_bytes(path.string())};
}

}  // namespace tonus::fuzz
