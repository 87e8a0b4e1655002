#pragma once

#include <Eigen/Core>
#include <array>
#include <complex>
#include <cstddef>
#include <vector>

#include "services/simulation/instruction.hpp"
#include "services/simulation/muscles.hpp"
#include "services/simulation/noise.hpp"
#include "services/simulation/subject_profile.hpp"

namespace tonus::simulation {

/// What the subject does within one period of the loop.
struct SubjectDrive {
  Eigen::Vector2d equilibrium = Eigen::Vector2d::Zero();  ///< Joint angles of the spring centre, rad.
  double scale = 1.0;                                     ///< Of stiffness and damping (fatigue, modulation).
  Eigen::Vector2d torque = Eigen::Vector2d::Zero();       ///< N m at the joints (reflex).
  Eigen::Vector2d force = Eigen::Vector2d::Zero();        ///< N at the hand, in S (tremor, drift, reaction).
  bool is_holding = true;                                 ///< The hand holds the handle.
  AddedImpedance added;  ///< To the joints' stiffness and damping, before the scale.
};

/// How the hand is at the start of a period: joint angles and rates, position and velocity in S. SI.
struct ArmMotion {
  Eigen::Vector2d angles;
  Eigen::Vector2d rates;
  Eigen::Vector2d hand;
  Eigen::Vector2d hand_velocity;
};

/// Decides, period by period, what the subject's muscles do beyond the passive arm: the effects of the
/// profile. With all effects off, the drive is constant. begin_period() is REALTIME.
class Subject {
 public:
  Subject(const SubjectProfile& profile, double period, std::uint64_t seed);

  /// A new posture (m in S): spring centre and rest are there.
  void take_posture(const Eigen::Vector2d& posture) noexcept;
  /// A trial begins, of which the subject has been told this. REALTIME.
  void begin_trial(const Instruction& instruction = {}, bool is_contraction = false) noexcept {
    misconduct_.begin_trial();
    is_contraction_ = is_contraction;
    drive_.added = added_impedance(profile_, instruction, profile_.links.angles_at(posture_));
  }

  /// What he sees of the trial's onset: in a contraction, when to contract. REALTIME.
  void show_onset(bool is_on) noexcept {
    contracts_ = is_on && is_contraction_;
    shown_at_ = time_;
  }

  /// How active his muscles are in the period that began last. The truth; costs nothing until it is asked
  /// for.
  [[nodiscard]] Activations activation() const noexcept;

  const SubjectDrive& begin_period(const ArmMotion& arm) noexcept;
  [[nodiscard]] const SubjectDrive& drive() const noexcept { return drive_; }

 private:
  [[nodiscard]] Eigen::Vector2d reflex_torque(const ArmMotion& arm) noexcept;
  [[nodiscard]] Eigen::Vector2d tremor_force() noexcept;
  [[nodiscard]] Eigen::Vector2d drift_force() noexcept;
  [[nodiscard]] Eigen::Vector2d reaction_force(const ArmMotion& arm) noexcept;
  void recentre(const ArmMotion& arm) noexcept;
  void modulate(const ArmMotion& arm) noexcept;
  void misbehave(const ArmMotion& arm) noexcept;
  void contract() noexcept;
  void hold_load(const ArmMotion& arm) noexcept;
  [[nodiscard]] Eigen::Vector2d muscle_torque(const ArmMotion& arm) const noexcept;

  const SubjectProfile profile_;
  const double period_;
  NoiseSource tremor_noise_;
  NoiseSource drift_noise_;
  NoiseSource reaction_noise_;
  double time_ = 0.0;  // s since the start of the simulation.
  Eigen::Vector2d posture_ = Eigen::Vector2d::Zero();
  SubjectDrive drive_;

  struct Past {
    Eigen::Vector2d deviation = Eigen::Vector2d::Zero();
    Eigen::Vector2d rates = Eigen::Vector2d::Zero();
  };
  std::vector<Past> past_;  // Ring of the reflex's delay; reserved once.
  std::size_t past_next_ = 0;

  std::array<std::complex<double>, 2> tremor_{};
  Eigen::Vector2d drift_ = Eigen::Vector2d::Zero();

  bool is_provoked_ = false;
  bool answers_ = false;
  double provoked_at_ = 0.0;
  double calm_since_ = 0.0;
  Eigen::Vector2d rest_ = Eigen::Vector2d::Zero();
  Eigen::Vector2d reaction_direction_ = Eigen::Vector2d::Zero();

  double quick_until_ = 0.0;
  double held_force_ = 0.0;  // N, steady force of the hand.

  Misconduct misconduct_;
  double tension_ = 0.0;      // Activation of all muscles that nobody asked for.
  double contraction_ = 0.0;  // Share of the hardest one.
  bool is_contraction_ = false;
  bool contracts_ = false;
  double shown_at_ = 0.0;  // s, when the onset was shown or hidden.
  // What activation() takes.
  double effort_ = 1.0;                                     // The scale without fatigue.
  Eigen::Vector2d angles_ = Eigen::Vector2d::Zero();        // rad.
  Eigen::Vector2d load_ = Eigen::Vector2d::Zero();          // N m, of the steady muscles.
  Eigen::Vector2d felt_rates_ = Eigen::Vector2d::Zero();    // rad/s, of the reflex's delay ago.
  Eigen::Vector2d tremor_force_ = Eigen::Vector2d::Zero();  // N at the hand, in S; part of the drive's.
  Eigen::Vector2d offset_ = Eigen::Vector2d::Zero();  // m, of the wanted place of the hand from the posture.
};

}  // namespace tonus::simulation
