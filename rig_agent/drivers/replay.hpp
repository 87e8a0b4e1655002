#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <vector>

#include "rig_agent/drivers/driver.hpp"

namespace tonus::drivers {

/// One recorded row: raw values, and the displacement command if the recording has it (m in S).
struct RecordedRow {
  RawSample raw;
  std::array<double, 2> command{};
};

/// One trial's share of a recording: rows [first, last], perturbed from `onset` on. Indices into
/// Recording::rows.
struct RecordedSegment {
  std::size_t first = 0;
  std::size_t onset = 0;
  std::size_t last = 0;
};

/// A recording in memory: whoever read the file has put it into rows. Values that a recording misses are NaN.
struct Recording {
  RigGeometry geometry;
  double rate = 200.0;  ///< Hz.
  std::vector<RecordedRow> rows;
  std::vector<RecordedSegment> segments;
  std::vector<AuxiliaryChannel> auxiliary_channels;
  /// Row by row what the channels gave with it, as the loop would have it (AuxiliaryChannel).
  std::vector<float> auxiliary;
};

/// Plays a recording, one row a period, one segment a trial: TrialNotice::segment chooses it. Between
/// segments there is no data. Two axes or one: the geometry says. It does not actuate. Stamps keep the
/// recording's distances within a segment; a segment begins one period after the one before, so that they
/// always increase.
class Replay final : public Driver {
 public:
  explicit Replay(Recording recording);

  /// Refuses an empty recording, segments outside the rows or out of order inside, stamps that do not
  /// increase within a segment, a geometry that cannot be converted with, and a period that is not that of
  /// the recording.
  Result<void> configure(double period) override;
  Result<void> activate() override;
  void deactivate() noexcept override;
  [[nodiscard]] Capabilities capabilities() const noexcept override {
    return {.actuates = false, .has_own_clock = true, .moves_nothing_real = true};
  }
  [[nodiscard]] const RigGeometry& geometry() const noexcept override { return recording_.geometry; }
  [[nodiscard]] std::span<const AuxiliaryChannel> auxiliary_channels() const noexcept override {
    return recording_.auxiliary_channels;
  }
  void read_auxiliary(std::span<const std::uint32_t> counts, std::span<float> values) noexcept override;
  DriverStatus read(Reading& reading) noexcept override;
  DriverStatus write(const Eigen::Vector2d& torque) noexcept override;
  /// A segment that the recording has not leaves nothing to play.
  void begin_trial(const TrialNotice& notice) noexcept override;

 private:
  const Recording recording_;
  std::int64_t period_ns_ = 0;
  bool is_configured_ = false;
  bool is_active_ = false;
  bool is_playing_ = false;
  RecordedSegment segment_;
  std::size_t next_ = 0;
  std::int64_t shift_ns_ = 0;  // From recorded stamps to those given out.
  std::int64_t last_ns_ = 0;
};

}  // namespace tonus::drivers
