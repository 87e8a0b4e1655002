#pragma once

#include <cstdint>
#include <optional>
#include <span>
#include <string>

namespace tonus::protocol {

/// Looks in a row that must be narrow enough. A look is narrow also by luck, and to stop at the first lucky
/// one would leave intervals that hold less than they state (`precision-campaign` measures it).
inline constexpr std::size_t kLooksInARow = 2;

/// When a condition of a precision-led protocol ends, and what may change while it runs (`[stop_when]`).
/// Half-widths are those of 95 % intervals, the largest of a matrix over its largest element.
struct StopWhen {
  double stiffness = 0.05;     ///< Goal, share.
  std::optional<double> mass;  ///< Further goals; none: not asked for.
  std::optional<double> damping;
  std::string method = "refined";  ///< Whose estimate is looked at.
  int trials_least = 8;            ///< Of a condition, before the first look.
  int trials_most = 16;
  double amplitude_most =
      0.0;                  ///< m, up to which the amplitude may be raised; that of the protocol: it is not.
  double rise_least = 0.0;  ///< s, down to which the rise may be shortened; that of the protocol: it is not.
  std::size_t looks_in_a_row = kLooksInARow;
  double entropy = 1.0;  ///< bits that the subject cannot foresee of each direction; at least.
};

/// What an estimate of a condition says, as far as the rule asks. Not a number: not known.
struct Look {
  std::size_t trials = 0;  ///< Behind it.
  double stiffness = 0.0;  ///< Half-width, share.
  double mass = 0.0;
  double damping = 0.0;
  bool is_ok = false;      ///< Every check of the estimate passed.
  bool is_linear = false;  ///< No check found a force that M, B and K do not describe.
};

enum class LookEnd : std::uint8_t {
  kGoesOn,
  kReached,      ///< Every goal, by two looks in a row.
  kOutOfTrials,  ///< The most that are allowed have been run.
};

/// What the rule says to a condition's looks, the newest last.
struct Ruling {
  LookEnd end = LookEnd::kGoesOn;
  /// Trials that the goals take, by the newest look: half-widths fall with the root of the trials. Not a
  /// number: not known.
  double needed = 0.0;
  /// A line for a person: why the condition ends, or that and why the goals are out of reach; else empty.
  std::string because;
};

[[nodiscard]] bool is_narrow(const StopWhen& rule, const Look& look);
[[nodiscard]] Ruling ruling_on(const StopWhen& rule, std::span<const Look> looks);

/// How the next trials are run.
struct Drive {
  double amplitude = 0.0;  ///< m
  double rise_time = 0.0;  ///< s
};

/// Largest steps by which a drive is raised.
inline constexpr double kAmplitudeStep = 1.25;
inline constexpr double kRiseStep = 0.6;

/// Within a condition the amplitude alone is raised: the estimator wants commands of one shape. `trials`: run
/// at this amplitude. Once a look was not linear, the condition keeps to the protocol's own.
[[nodiscard]] Drive next_drive(const StopWhen& rule, const Drive& own, const Drive& now, std::size_t trials,
                               std::span<const Look> looks);

/// How the next condition begins after one with these looks whose drive was `now`.
[[nodiscard]] Drive drive_after(const StopWhen& rule, const Drive& own, const Drive& now,
                                std::span<const Look> looks);

}  // namespace tonus::protocol
