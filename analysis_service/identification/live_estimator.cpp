#include "analysis_service/identification/live_estimator.hpp"

#include <utility>

#include "analysis_service/identification/trial_section.hpp"

namespace tonus::identification {

void LiveEstimator::start(const TrialPlan& plan, const RigGeometry& rig, double sample_rate,
                          std::uint64_t epoch, std::uint64_t first_sequence) {
  followed_.reset();
  if (plan.kind != TrialKind::kPerturbation) return;
  const auto stream = stream_of(plan, rig, sample_rate);
  if (!stream) return;  // not a method that runs sample by sample
  (*stream)->identifier.begin_trial(plan.attempt);
  Followed followed;
  followed.plan = plan;
  followed.rig = rig;
  followed.epoch = epoch;
  followed.first = followed.next = first_sequence;
  followed_ = std::move(followed);
}

std::optional<LiveEstimator::Position> LiveEstimator::next() const {
  if (!followed_) return std::nullopt;
  return Position{followed_->plan.rig, followed_->epoch, followed_->next};
}

void LiveEstimator::push(std::span<const Row> rows) {
  if (!followed_) return;
  const auto stream = streams_.find(condition_of(followed_->plan));
  if (stream != streams_.end()) push(stream->second, *followed_, rows);
}

void LiveEstimator::push(Stream& stream, Followed& followed, std::span<const Row> rows) const {
  for (const Row& row : rows) {
    const std::uint64_t sequence = followed.next++;
    if (followed.is_over) continue;
    const bool is_rest = row.phase == Phase::kWaiting || row.phase == Phase::kBiasHold;
    const bool is_perturbed = row.phase == Phase::kPerturbing;
    if (followed.onset && !is_perturbed) {
      followed.is_over = true;
    } else if (is_rest) {
      stream.identifier.push_rest(tonus::convert(followed.rig, followed.plan.shoulder, row.raw));
      followed.has_rest = true;
    } else if (is_perturbed) {
      if (!followed.onset) {
        followed.onset = sequence;
        stream.identifier.mark_onset();
      }
      stream.identifier.push(tonus::convert(followed.rig, followed.plan.shoulder, row.raw));
    } else if (followed.has_rest) {  // a bias ramp: what came before it is not the rest before the onset
      stream.identifier.begin_trial(followed.plan.attempt);
      followed.has_rest = false;
    }
  }
}

Result<void> LiveEstimator::settle(const MeasuredTrial& trial, bool is_valid, const RigGeometry& rig) {
  const TrialReport& report = trial.report;
  if (report.plan.kind != TrialKind::kPerturbation) return {};
  if (!follows(report.plan.trial)) return is_valid ? add_whole(trial, rig) : Result<void>();

  Followed followed = *std::exchange(followed_, std::nullopt);
  const auto found = streams_.find(condition_of(report.plan));
  if (found == streams_.end()) return is_valid ? add_whole(trial, rig) : Result<void>();
  Stream& stream = found->second;
  if (!is_valid) {
    stream.identifier.discard_trial();
    return {};
  }
  if (report.range.contains(followed.next)) {
    push(stream, followed, std::span(trial.rows).subspan(followed.next - report.range.first));
  }
  if (followed.first > report.range.first || followed.onset != report.onset) return add_whole(trial, rig);
  if (auto ended = stream.identifier.end_trial(); !ended) return ended;
  stream.sources.push_back(source_of(report));
  return {};
}

Result<void> LiveEstimator::add_whole(const MeasuredTrial& trial, const RigGeometry& rig) {
  const TrialReport& report = trial.report;
  if (!(report.sample_rate > 0.0)) return {};
  auto stream = stream_of(report.plan, rig, report.sample_rate);
  if (!stream) return {};  // as in start()
  if (followed_ && !(condition_of(followed_->plan) < condition_of(report.plan)) &&
      !(condition_of(report.plan) < condition_of(followed_->plan))) {
    followed_.reset();  // its stream is needed; it is added whole when its own verdict comes
  }
  (*stream)->identifier.begin_trial(report.plan.attempt);
  const std::size_t onset = report.onset - report.range.first;
  const Section rest = rest_before(trial.rows, onset, rows_of(TrialFrame{}.rest, report.sample_rate));
  const Section perturbation = perturbation_from(trial.rows, onset);
  for (std::size_t i = rest.first; i < perturbation.end; ++i) {
    if (i == onset) (*stream)->identifier.mark_onset();
    const EndpointSample sample = tonus::convert(rig, report.plan.shoulder, trial.rows[i].raw);
    i < onset ? (*stream)->identifier.push_rest(sample) : (*stream)->identifier.push(sample);
  }
  if (auto ended = (*stream)->identifier.end_trial(); !ended) return ended;
  (*stream)->sources.push_back(source_of(report));
  return {};
}

void LiveEstimator::withdraw(const Id& session, std::uint32_t attempt) {
  for (auto& [condition, stream] : streams_) {
    if (condition.session != session || !stream.identifier.remove_trial(attempt)) continue;
    std::erase_if(stream.sources, [&](const TrialSource& source) { return source.attempt == attempt; });
  }
}

std::optional<ConditionEstimate> LiveEstimator::estimate() const {
  if (!followed_ || !followed_->onset) return std::nullopt;
  const auto stream = streams_.find(condition_of(followed_->plan));
  if (stream == streams_.end()) return std::nullopt;
  ConditionEstimate live;
  live.condition = stream->first;
  live.options = options_;
  live.estimate = stream->second.identifier.estimate();
  live.trials = stream->second.sources;
  live.trials.push_back(
      {followed_->plan.attempt, followed_->epoch, {followed_->first, followed_->next}, *followed_->onset});
  return live;
}

Result<LiveEstimator::Stream*> LiveEstimator::stream_of(const TrialPlan& plan, const RigGeometry& rig,
                                                        double sample_rate) {
  const Condition condition = condition_of(plan);
  if (const auto found = streams_.find(condition); found != streams_.end()) return &found->second;
  TrialFrame frame;
  frame.tare = tare_of(plan);
  frame.sample_rate = sample_rate;
  auto identifier = impedance::StreamingIdentifier::create(options_, preparation_of(frame, rig));
  if (!identifier) return identifier.error();
  return &streams_.emplace(condition, Stream{std::move(*identifier), {}}).first->second;
}

void LiveEstimator::keep_only(const Id& session) {
  std::erase_if(streams_, [&](const auto& stream) { return stream.first.session != session; });
  if (followed_ && followed_->plan.session != session) followed_.reset();
}

}  // namespace tonus::identification
