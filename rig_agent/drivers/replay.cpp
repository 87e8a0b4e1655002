#include "rig_agent/drivers/replay.hpp"

#include <algorithm>
#include <cmath>
#include <spdlog/fmt/fmt.h>
#include <utility>

namespace tonus::drivers {
namespace {

Error refuse(const std::string& what) { return fail(ErrorCode::kInvalidArgument, "recording: " + what); }

Result<void> validate(const Recording& recording, std::size_t index) {
  const RecordedSegment& s = recording.segments[index];
  const std::size_t rows = recording.rows.size();
  if (!(s.first <= s.onset && s.onset < s.last && s.last < rows)) {
    return refuse(
        fmt::format("segment {}: rows {}, {}, {} (first, onset, last) are not allowed; expected first <= "
                    "onset < last < {}",
                    index, s.first, s.onset, s.last, rows));
  }
  for (std::size_t i = s.first + 1; i <= s.last; ++i) {
    const std::int64_t before = recording.rows[i - 1].raw.acquisition_ns;
    const std::int64_t here = recording.rows[i].raw.acquisition_ns;
    if (here <= before) {
      return refuse(
          fmt::format("acquisition_ns of row {}: {} is not allowed; expected more than {} of the row before",
                      i, here, before));
    }
  }
  return {};
}

}  // namespace

Replay::Replay(Recording recording) : recording_(std::move(recording)) {}

Result<void> Replay::configure(double period) {
  if (is_active_)
    return fail(ErrorCode::kUnavailable,
                "recording: configure() while active is not allowed; expected an inactive driver");
  is_configured_ = false;
  if (recording_.rows.empty()) return refuse("rows: 0 is not allowed; expected 1 or more");
  if (recording_.segments.empty()) return refuse("segments: 0 is not allowed; expected 1 or more");
  if (!(recording_.rate > 0.0 && recording_.rate <= 1e5)) {
    return refuse(
        fmt::format("rate: {} Hz is not allowed; expected more than 0 up to 100000 Hz", recording_.rate));
  }
  if (!(std::abs(period * recording_.rate - 1.0) < 1e-6)) {
    return refuse(fmt::format("the loop's period: {} s is not allowed; expected the recording's {} s", period,
                              1.0 / recording_.rate));
  }
  TONUS_TRY(tonus::validate(recording_.auxiliary_channels, recording_.rate));
  const std::size_t values =
      recording_.rows.size() * values_per_sample(recording_.auxiliary_channels, recording_.rate);
  if (recording_.auxiliary.size() != values) {
    return refuse(fmt::format("auxiliary values: {} are not allowed; expected {} for these rows and channels",
                              recording_.auxiliary.size(), values));
  }
  for (std::size_t i = 0; i < recording_.segments.size(); ++i) {
    if (auto valid = validate(recording_, i); !valid) return valid;
  }
  if (auto valid = tonus::validate(recording_.geometry); !valid) return valid;
  period_ns_ = std::llround(1e9 * period);
  is_configured_ = true;
  return {};
}

Result<void> Replay::activate() {
  if (!is_configured_) return fail(ErrorCode::kUnavailable, "recording: activate() before configure()");
  is_active_ = true;
  return {};
}

void Replay::deactivate() noexcept {
  is_active_ = false;
  is_playing_ = false;
}

DriverStatus Replay::read(Reading& reading) noexcept {
  if (!is_active_) return DriverStatus::kFailed;
  if (!is_playing_) return DriverStatus::kNoData;
  const RecordedRow& row = recording_.rows[next_];
  reading = Reading{};
  reading.raw = row.raw;
  reading.raw.acquisition_ns = row.raw.acquisition_ns + shift_ns_;
  reading.recorded_command = row.command;
  if (next_ == segment_.onset) reading.mark = RowMark::kOnset;
  if (next_ == segment_.last) {
    reading.mark = RowMark::kLast;
    is_playing_ = false;
  }
  last_ns_ = reading.raw.acquisition_ns;
  ++next_;
  return DriverStatus::kOk;
}

// Of the row that the last read() gave; a recording has one row a cycle, so that all its values are due.
void Replay::read_auxiliary(std::span<const std::uint32_t> /*counts*/, std::span<float> values) noexcept {
  if (!is_active_ || next_ == 0) return;
  const std::size_t first = (next_ - 1) * values.size();
  std::copy_n(recording_.auxiliary.begin() + static_cast<std::ptrdiff_t>(first), values.size(),
              values.begin());
}

DriverStatus Replay::write(const Eigen::Vector2d& torque) noexcept {
  return is_active_ && torque.allFinite() ? DriverStatus::kOk : DriverStatus::kFailed;
}

void Replay::begin_trial(const TrialNotice& notice) noexcept {
  is_playing_ = is_active_ && notice.segment < recording_.segments.size();
  if (!is_playing_) return;
  segment_ = recording_.segments[notice.segment];
  next_ = segment_.first;
  shift_ns_ = last_ns_ + period_ns_ - recording_.rows[next_].raw.acquisition_ns;
}

}  // namespace tonus::drivers
