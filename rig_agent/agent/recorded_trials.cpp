#include "rig_agent/agent/recorded_trials.hpp"

#include <limits>
#include <spdlog/fmt/fmt.h>
#include <utility>

#include "services/contract/rig.hpp"

namespace tonus::rig {
namespace {

bool same_rig(const RigGeometry& a, const RigGeometry& b) {
  return a.kind == b.kind && a.links.l1 == b.links.l1 && a.links.l2 == b.links.l2 &&
         a.encoder_zero == b.encoder_zero && a.encoder_sign == b.encoder_sign &&
         a.counts_per_unit == b.counts_per_unit && a.force_calibration == b.force_calibration &&
         a.force_offset_V == b.force_offset_V && a.force_sensor_angle == b.force_sensor_angle &&
         a.handle_mass == b.handle_mass;
}

std::vector<AuxiliaryChannel> channels_of(const recording::Recording& record) {
  std::vector<AuxiliaryChannel> channels;
  for (const AuxiliarySeries& series : record.auxiliary) channels.push_back(series.channel);
  return channels;
}

}  // namespace

Result<RecordedTrials> RecordedTrials::create(std::vector<recording::Recording> records) {
  if (records.empty())
    return fail(ErrorCode::kNotFound, "the dataset has no recordings, at least one is needed");
  const auto& first = records.front();
  const auto channels = channels_of(first);
  for (const auto& record : records) {
    if (same_rig(first.rig, record.rig) && first.sampling_frequency == record.sampling_frequency &&
        channels_of(record) == channels)
      continue;
    return fail(ErrorCode::kInvalidArgument,
                fmt::format("{} and {} are of different rigs, sampling rates or auxiliary channels; one "
                            "replay takes one rig",
                            describe(first), describe(record)));
  }
  RecordedTrials trials;
  trials.rate_ = first.sampling_frequency;
  trials.displacement_unit_ = first.displacement_unit;
  trials.force_unit_ = first.force_unit;
  trials.recording_.geometry = first.rig;
  trials.recording_.rate = first.sampling_frequency;
  trials.recording_.auxiliary_channels = channels;
  for (const auto& record : records) trials.add(record);
  if (first.rig.kind == RigKind::kTwoLink) {
    trials.home_ = first.rig.links.endpoint(joint_coordinates(first.rig, first.rows.front().raw));
  }
  return trials;
}

void RecordedTrials::add(const recording::Recording& source) {
  const std::size_t offset = recording_.rows.size();
  for (std::size_t i = 0; i < source.rows.size(); ++i) {
    drivers::RecordedRow row;
    row.raw = source.rows[i].raw;
    row.raw.acquisition_ns = recording::row_time_ns(source, i);
    if (source.rows[i].is_missing) {
      row.raw.encoder_count.fill(std::numeric_limits<double>::quiet_NaN());
      row.raw.force_V.fill(std::numeric_limits<double>::quiet_NaN());
    }
    row.command = source.commanded.empty() ? recording::kNoCommand : source.commanded[i];
    recording_.rows.push_back(row);
    for (const AuxiliarySeries& series : source.auxiliary) {
      const auto from = series.values.begin() + static_cast<std::ptrdiff_t>(i * series.values_per_sample);
      recording_.auxiliary.insert(recording_.auxiliary.end(), from, from + series.values_per_sample);
    }
  }
  const std::size_t last = recording_.rows.size() - 1;
  Record record;
  record.name = recording::describe(source);
  record.shoulder = source.shoulder;
  record.posture = source.posture_position.value_or(Eigen::Vector2d::Zero());
  record.whole_segment = static_cast<std::uint32_t>(recording_.segments.size());
  recording_.segments.push_back({offset, offset, last});
  for (const auto& event : source.events) {
    const recording::Stretch rows = recording::stretch_of(source, event);
    recording_.segments.push_back({offset + rows.first, offset + rows.onset, offset + rows.last});
    ++record.events;
  }
  records_.push_back(std::move(record));
}

Result<std::uint32_t> RecordedTrials::prepare(v1::TrialProgram& program) const {
  const auto index = program.recording_index();
  if (index < 0 || static_cast<std::size_t>(index) >= records_.size()) {
    return fail(ErrorCode::kNotFound, fmt::format("recording {} is not in the dataset, which has 0 to {}",
                                                  index, records_.size() - 1));
  }
  const Record& record = records_[static_cast<std::size_t>(index)];
  if (program.recording_event() >= static_cast<std::int64_t>(record.events)) {
    return fail(ErrorCode::kNotFound, fmt::format("{} has {} perturbations, number {} is not among them",
                                                  record.name, record.events, program.recording_event()));
  }
  program.posture_m({record.posture.x(), record.posture.y()});
  contract::put_shoulder(record.shoulder, program);
  return static_cast<std::uint32_t>(static_cast<std::int64_t>(record.whole_segment) + 1 +
                                    program.recording_event());
}

}  // namespace tonus::rig
