#include "services/recording/recording.hpp"

#include <algorithm>
#include <cmath>
#include <limits>
#include <spdlog/fmt/fmt.h>

namespace tonus::recording {
namespace {

constexpr double kRestBefore = 1.0;  // s, more than the conversion to a trial uses

}  // namespace

RigGeometry converted_rig(RigKind kind) {
  RigGeometry rig;
  rig.kind = kind;
  rig.counts_per_unit = {1.0, 1.0};
  rig.force_calibration = Eigen::Matrix2d::Identity();
  rig.force_saturation_V = std::numeric_limits<double>::infinity();
  return rig;
}

Result<void> state_force_sign(Recording& recording, int sign) {
  if (sign != 1 && sign != -1) {
    return fail(ErrorCode::kInvalidArgument,
                fmt::format("force sign {} is not allowed; expected +1 or -1", sign));
  }
  if (recording.is_raw || recording.rig.kind != RigKind::kOneAxis) {
    return fail(
        ErrorCode::kInvalidArgument,
        fmt::format("force sign {:+d} is not allowed for {}: it is for converted one-axis channels, here the "
                    "force's sign is stated by {}",
                    sign, describe(recording), recording.is_raw ? "the calibration" : "the format"));
  }
  recording.rig.force_calibration(0, 0) = sign;
  recording.is_force_sign_stated = true;
  return {};
}

std::int64_t row_time_ns(const Recording& recording, std::size_t row) {
  return std::llround(static_cast<double>(row) * 1e9 / recording.sampling_frequency);
}

Stretch stretch_of(const Recording& recording, const PerturbationEvent& event) {
  const std::size_t last = recording.rows.size() - 1;
  const auto row_at = [&](double time) {
    const double row = std::round(std::max(time, 0.0) * recording.sampling_frequency);
    return std::min(static_cast<std::size_t>(row), last);
  };
  if (event.is_continuous()) {
    const std::size_t first = row_at(event.onset_s);
    const double end = std::round((event.onset_s + event.duration_s) * recording.sampling_frequency);
    return {first, first, std::clamp(static_cast<std::size_t>(std::max(end, 1.0)) - 1, first, last)};
  }
  return {row_at(event.onset_s - kRestBefore), row_at(event.onset_s),
          row_at(event.onset_s + event.duration_s)};
}

std::string describe(const Recording& recording) {
  std::string text = recording.participant.id;
  if (!recording.session.empty()) text += " " + recording.session;
  text += fmt::format(" run {}", recording.run);
  if (!recording.posture.empty()) text += " (" + recording.posture + ")";
  return text;
}

}  // namespace tonus::recording
