#include "tests/fault/simulator/witness.hpp"

#include <algorithm>
#include <spdlog/fmt/fmt.h>

#include "idl/topics.hpp"
#include "services/contract/names.hpp"
#include "services/store/session_reader.hpp"
#include "services/verification/verification.hpp"

namespace tonus::simulator {
namespace {

constexpr std::chrono::seconds kLease{
    5};  // more than the profile's command time-out, and what the network adds
constexpr std::uint64_t kPrime = 0x100000001b3ULL;

template <typename Value>
std::uint64_t mixed(std::uint64_t hash, const Value& value) {
  for (const std::byte byte : std::as_bytes(std::span(&value, 1)))
    hash = (hash ^ static_cast<std::uint64_t>(byte)) * kPrime;
  return hash;
}

/// Of what was measured and commanded.
std::uint64_t hash_of(const v1::RigSample& sample) {
  std::uint64_t hash = mixed(0xcbf29ce484222325ULL, sample.acquisition_ns());
  for (const double value : sample.encoder_count()) hash = mixed(hash, value);
  for (const double value : sample.force_V()) hash = mixed(hash, value);
  for (const double value : sample.commanded_m()) hash = mixed(hash, value);
  return mixed(hash, sample.phase());
}

std::string at(Time now) {
  return fmt::format("{:.3f} s: ", 1e-9 * static_cast<double>(now.time_since_epoch().count()));
}

}  // namespace

std::string Witness::broken() const {
  std::string text;
  for (const auto& line : broken_) text += line + '\n';
  return text;
}

void Witness::note(Time now, const std::string& what) {
  if (broken_.size() < 20) broken_.push_back(at(now) + what);
}

void Witness::add_to_hash(std::span<const std::byte> bytes) {
  for (const std::byte byte : bytes) hash_ = (hash_ ^ static_cast<std::uint64_t>(byte)) * kPrime;
}

void Witness::written(Time now, const std::string& program, const std::string& topic,
                      std::span<const std::byte> payload) {
  hash_ = mixed(hash_, now.time_since_epoch().count());
  add_to_hash(std::as_bytes(std::span(program)));
  add_to_hash(std::as_bytes(std::span(topic)));
  // What services say of themselves names process and host.
  if (!topic.starts_with("service/")) add_to_hash(payload);
  if (topic == topics::kRigSamples.spec.name) return saw_block(now, payload);
  if (topic == topics::kArchiveReceipt.spec.name) return saw_receipt(now, payload);
  if (topic == topics::kSessionState.spec.name) return saw_state(payload);
  if (topic == topics::kTrialCommand.spec.name) commanded_at_ = now;
}

void Witness::saw_block(Time now, std::span<const std::byte> payload) {
  const auto block = bus::decode<v1::SampleBlock>(payload);
  if (!block || block->is_resent()) return;
  rig_ = block->rig_id();
  auto& known = samples_[block->epoch()];
  std::uint64_t number = block->first_sequence();
  has_unkept_ = has_unkept_ || is_rig_disk_full_;
  for (const auto& sample : block->samples())
    known.insert_or_assign(number++, Published{now, hash_of(sample), !is_rig_disk_full_});
}

void Witness::saw_state(std::span<const std::byte> payload) {
  const auto state = bus::decode<v1::SessionState>(payload);
  if (state && v1::is_over(state->phase())) ended_.insert(state->session_id());
}

bool Witness::holds(const store::StreamKey& stream, store::SequenceRange range) {
  store::Coverage found;
  const auto visited =
      store_.visit_blocks({stream, range}, [&found](const store::Block& block) -> Result<void> {
        found.add(block.range());
        return {};
      });
  return visited && found.covers(range);
}

void Witness::saw_receipt(Time now, std::span<const std::byte> payload) {
  const auto receipt = bus::decode<v1::ArchiveReceipt>(payload);
  if (!receipt || receipt->kind() != v1::RECEIPT_TRIAL || receipt->missing_samples() > 0) return;
  const auto trial = store_.find_trial(receipt->subject_id());
  if (!trial || !*trial) return note(now, "a receipt for a trial that the archive does not have");
  if (!holds((*trial)->stream, (*trial)->range()))
    note(now, fmt::format("a receipt for trial {} whose samples are not there", (*trial)->attempt));
}

void Witness::saw_loop(Time now, const control::LoopState& loop, bool is_held) {
  if (loop.trial == trial_) return;
  trial_ = loop.trial;
  if (trial_ == 0) return;
  has_seen_trial_ = true;
  if (is_held) note(now, "a trial began while the rig was held");
  if (!taken_back_because_.empty() && !was_told_before_the_schedulers_end(now))
    note(now, "a trial began without an operator's resume after: " + taken_back_because_);
}

void Witness::scheduler_ended(Time now) {
  if (!taken_back_because_.empty()) return;
  taken_back_because_ = "an end of the scheduler";
  scheduler_ended_at_ = now;
}

bool Witness::was_told_before_the_schedulers_end(Time now) const {
  return scheduler_ended_at_ && commanded_at_ <= *scheduler_ended_at_ && now - *scheduler_ended_at_ < kLease;
}

void Witness::rig_began(Time now, bool is_held) {
  trial_ = 0;
  if (must_be_held_ && !is_held) note(now, "the rig's hold was forgotten");
  must_be_held_ = false;
}

void Witness::check_end(const Id& session, bool has_completed, Time since) {
  check_samples(since);
  check_counts(session, has_completed);
  check_verification(session);
}

void Witness::check_samples(Time since) {
  for (const auto& [epoch, known] : samples_) {
    auto left = known;
    std::erase_if(left, [since](const auto& each) { return each.second.at > since || !each.second.is_kept; });
    std::size_t other = 0;
    const store::StreamKey stream{rig_, epoch};
    const store::BlockQuery query{stream, {known.begin()->first, known.rbegin()->first + 1}};
    const auto visited = store_.visit_blocks(query, [&](const store::Block& stored) -> Result<void> {
      TONUS_TRY_ASSIGN(const auto block, bus::decode<v1::SampleBlock>(*stored.payload));
      std::uint64_t number = block.first_sequence();
      for (const auto& sample : block.samples()) {
        const auto sent = known.find(number++);
        if (sent == known.end()) continue;
        if (sent->second.hash != hash_of(sample)) ++other;
        left.erase(sent->first);
      }
      return {};
    });
    if (!visited) broken_.push_back("samples: " + visited.error().message);
    if (other > 0) broken_.push_back(fmt::format("samples: {} are not as the rig sent them", other));
    if (!left.empty()) {
      broken_.push_back(fmt::format("samples: {} of {} of epoch {} are not in the archive, from {} to {}",
                                    left.size(), known.size(), epoch, left.begin()->first,
                                    left.rbegin()->first));
    }
  }
}

void Witness::check_counts(const Id& id, bool has_completed) {
  const auto session = store::read_session(store_, id);
  if (!session) return broken_.push_back("archive: " + session.error().message);
  std::map<std::uint32_t, int> counted;
  for (const auto& trial : session->trials) {
    if (trial.verdict && trial.verdict->value.is_valid() && trial.outcome &&
        trial.outcome->value.end() == v1::TRIAL_COMPLETED)
      ++counted[trial.verdict->value.planned_index()];
  }
  counted_ = static_cast<unsigned>(counted.size());
  if (has_completed && counted.size() != session->record.planned_trials)
    broken_.push_back(
        fmt::format("{} of {} planned trials are counted", counted.size(), session->record.planned_trials));
  for (const auto& [index, times] : counted)
    if (times != 1) broken_.push_back(fmt::format("planned trial {} is counted {} times", index + 1, times));
}

void Witness::check_verification(const Id& session) {
  const auto sessions = store_.sessions();
  if (!sessions) return broken_.push_back("archive: " + sessions.error().message);
  for (const auto& record : *sessions) {
    if (record.session != session) continue;
    const auto verified = verification::verify_session(store_, record);
    if (!verified) return broken_.push_back("verify: " + verified.error().message);
    for (const auto& problem : verified->problems) {
      const bool is_loss = problem.find("missing") != std::string::npos ||
                           problem.find("certificate has") != std::string::npos;
      if (!is_loss || !has_unkept_) broken_.push_back("verify: " + problem);
    }
  }
}

}  // namespace tonus::simulator
