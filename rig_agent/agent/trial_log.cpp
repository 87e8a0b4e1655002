#include "rig_agent/agent/trial_log.hpp"

#include <cstring>
#include <spdlog/spdlog.h>
#include <utility>

#include "idl/bounds.hpp"
#include "services/bus/typed.hpp"

namespace tonus::rig {
namespace {

enum class Kind : std::uint64_t { kBegun = 1, kEnded = 2, kReceived = 3 };

/// What every record begins with; a message's CDR payload may follow.
struct Head {
  Kind kind;
  std::uint64_t epoch;
  std::uint64_t sequence;
};

std::vector<std::byte> record_of(const Head& head, std::span<const std::byte> payload = {}) {
  std::vector<std::byte> record(sizeof head + payload.size());
  std::memcpy(record.data(), &head, sizeof head);
  if (!payload.empty()) std::memcpy(record.data() + sizeof head, payload.data(), payload.size());
  return record;
}

Result<void> as_void(const Result<std::uint64_t>& appended) {
  if (!appended) return appended.error();
  return {};
}

}  // namespace

Result<TrialLog> TrialLog::open(const std::filesystem::path& path) {
  std::vector<std::vector<std::byte>> records;
  auto file = RecordFile::open(path, [&records](std::uint64_t, std::span<const std::byte> content) {
    records.emplace_back(content.begin(), content.end());
  });
  if (!file) return file.error();
  if (const std::string lost = file->damage_text(); !lost.empty()) {
    // The log is written anew below: what is damaged stays beside it for whoever can read it.
    auto kept = path;
    kept += ".damaged";
    std::error_code ignored;
    std::filesystem::copy_file(path, kept, std::filesystem::copy_options::overwrite_existing, ignored);
    spdlog::error("trial log: {}; the file is kept as {}", lost, kept.string());
  }
  TrialLog log(std::move(*file));
  for (const auto& record : records) log.restore(record);
  if (auto rewritten = log.rewrite(); !rewritten) return rewritten.error();
  return log;
}

void TrialLog::restore(std::span<const std::byte> content) {
  Head head{};
  if (content.size() < sizeof head) return;
  std::memcpy(&head, content.data(), sizeof head);
  const auto payload = content.subspan(sizeof head);
  if (head.kind == Kind::kBegun) {
    auto command = bus::decode<v1::TrialCommand>(payload);
    if (!command) return;
    forget_other_sessions(command->program().session_id());
    broken_ = BrokenTrial{std::move(*command), head.epoch, head.sequence};
  } else if (head.kind == Kind::kEnded) {
    auto outcome = bus::decode<v1::TrialOutcome>(payload);
    if (!outcome) return;
    if (broken_ && broken_->command.trial_id() == outcome->trial_id()) broken_.reset();
    outcomes_[outcome->trial_id()] = std::move(*outcome);
  } else if (head.kind == Kind::kReceived) {
    received_[head.epoch] = head.sequence;
  }
}

void TrialLog::forget_other_sessions(const Id& session) {
  std::erase_if(outcomes_,
                [&session](const auto& entry) { return entry.second.program().session_id() != session; });
}

Result<void> TrialLog::rewrite() {
  const auto path = file_.path();
  auto fresh_path = path;
  fresh_path += ".new";
  std::error_code error;
  std::filesystem::remove(fresh_path, error);
  auto fresh = RecordFile::open(fresh_path, {});
  if (!fresh) return fresh.error();
  RecordFile former = std::exchange(file_, std::move(*fresh));
  auto replaced = write_all();
  if (replaced) replaced = file_.rename_to(path);
  if (!replaced) file_ = std::move(former);
  return replaced;
}

Result<void> TrialLog::write_all() {
  for (const auto& [epoch, through] : received_) {
    if (auto kept = received(epoch, through); !kept) return kept;
  }
  for (const auto& [id, outcome] : outcomes_) {
    if (auto kept =
            as_void(file_.append(record_of({Kind::kEnded, outcome.epoch(), 0}, *bus::encode(outcome))));
        !kept) {
      return kept;
    }
  }
  if (broken_) {
    const auto broken = *broken_;
    if (auto kept = begun(broken.command, broken.epoch, broken.first_sequence); !kept) return kept;
  }
  return file_.sync();
}

Result<void> TrialLog::begun(const v1::TrialCommand& command, std::uint64_t epoch,
                             std::uint64_t first_sequence) {
  auto payload = bus::encode(command);
  if (!payload) return payload.error();
  forget_other_sessions(command.program().session_id());
  broken_ = BrokenTrial{command, epoch, first_sequence};
  return as_void(file_.append(record_of({Kind::kBegun, epoch, first_sequence}, *payload)));
}

Result<void> TrialLog::ended(const v1::TrialOutcome& outcome) {
  auto payload = bus::encode(outcome);
  if (!payload) return payload.error();
  if (broken_ && broken_->command.trial_id() == outcome.trial_id()) broken_.reset();
  outcomes_[outcome.trial_id()] = outcome;
  return as_void(file_.append(record_of({Kind::kEnded, outcome.epoch(), 0}, *payload)));
}

Result<void> TrialLog::received(std::uint64_t epoch, std::uint64_t through) {
  received_[epoch] = through;
  return as_void(file_.append(record_of({Kind::kReceived, epoch, through})));
}

const v1::TrialOutcome* TrialLog::find(const Id& trial) const {
  const auto found = outcomes_.find(trial);
  return found == outcomes_.end() ? nullptr : &found->second;
}

}  // namespace tonus::rig
