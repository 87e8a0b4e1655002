#pragma once

#include <Eigen/Core>
#include <cstdint>
#include <vector>

namespace tonus::simulation {

/// What the subject does against the rules in trials that are chosen beforehand; the first trial that the rig
/// begins is 1. Every act starts `after` the beginning of its trial and ends with it.
struct MisconductEffect {
  bool is_on = false;
  std::vector<std::uint64_t> pushes_early;  ///< Trials with pushes to and fro, in expectation of the onset.
  std::vector<std::uint64_t> drifts_off;    ///< Trials in which the spring centre wanders off the target.
  std::vector<std::uint64_t> lets_go;       ///< Trials in which the hand opens once it has been moved.
  std::vector<std::uint64_t> tenses;        ///< Trials in which all muscles are active: he is not relaxed.
  double after = 2.5;                       ///< s, from the beginning of the trial.
  double push = 3.0;                        ///< N, amplitude.
  double push_period = 0.6;                 ///< s.
  double drift = 0.009;                     ///< m, along y of S.
  double drift_time = 1.5;                  ///< s.
  double tension = 0.15;                    ///< Activation of all muscles, 1: as hard as he can.
  double grip_speed = 0.045;                ///< m/s, above which the hand notices that it is moved.
  double grip_latency = 0.3;                ///< s, from then until the hand opens.
};

/// Decides what a misbehaving hand does. begin_trial() and begin_period() are REALTIME.
class Misconduct {
 public:
  struct Act {
    Eigen::Vector2d force = Eigen::Vector2d::Zero();   ///< N at the hand, in S.
    Eigen::Vector2d offset = Eigen::Vector2d::Zero();  ///< m, of the wanted place of the hand.
    double tension = 0.0;                              ///< Activation beside what the trial asks for.
    bool is_holding = true;
  };

  Misconduct(const MisconductEffect& effect, double period) : effect_(effect), period_(period) {}

  void begin_trial() noexcept;
  /// `hand_speed` in m/s.
  [[nodiscard]] Act begin_period(double hand_speed) noexcept;

 private:
  [[nodiscard]] bool is_chosen(const std::vector<std::uint64_t>& trials) const noexcept;

  const MisconductEffect effect_;
  const double period_;
  std::uint64_t trial_ = 0;
  double time_ = 0.0;       // s, of the trial.
  double moved_at_ = -1.0;  // s; negative: not yet.
  bool pushes_ = false;
  bool drifts_ = false;
  bool lets_go_ = false;
  bool tenses_ = false;
};

}  // namespace tonus::simulation
