#pragma once

#include <Eigen/Core>

#include "services/mechanics/two_link.hpp"
#include "services/simulation/misconduct.hpp"

namespace tonus::simulation {

/// Stiffness (N m/rad) or damping (N m s/rad) of the three muscle groups; as a matrix on shoulder and elbow
/// angle
/// [[s + d, d], [d, e + d]], equation (21).
struct JointImpedance {
  double shoulder = 0.0;
  double elbow = 0.0;
  double two_joint = 0.0;

  [[nodiscard]] Eigen::Matrix2d matrix() const {
    Eigen::Matrix2d m;
    m << shoulder + two_joint, two_joint, two_joint, elbow + two_joint;
    return m;
  }
};

/// Stretch reflex: torque -(stiffness (t - t_eq) + damping t') of `delay` ago.
struct ReflexEffect {
  bool is_on = false;
  double delay = 0.04;  ///< s, at most 0.25.
  JointImpedance stiffness{3.0, 3.0, 1.0};
  JointImpedance damping{0.1, 0.1, 0.03};
};

/// Narrow-band random force on the hand, both axes independent.
struct TremorEffect {
  bool is_on = false;
  double force = 0.1;      ///< N rms, each axis.
  double frequency = 9.0;  ///< Hz, centre.
  double bandwidth = 1.5;  ///< Hz, half width at half power.
};

/// Slow voluntary force on the hand: first-order Gauss-Markov, both axes independent.
struct DriftEffect {
  bool is_on = false;
  double force = 0.2;          ///< N rms, each axis.
  double time_constant = 2.0;  ///< s.
};

/// The subject pushes the hand back before the perturbation is over, against the rule: at `latency` after the
/// hand has moved by `threshold`, a force rises within `rise` s against the displacement, and ends with it.
struct ReactionEffect {
  bool is_on = false;
  double probability = 1.0;  ///< That a given perturbation is answered.
  double latency = 0.25;     ///< s.
  double rise = 0.15;        ///< s.
  double force = 3.0;        ///< N.
  double threshold = 0.003;  ///< m.
};

/// Stiffness and damping sink: factor 1 - depth (1 - exp(-t / time_constant)) from the start of the
/// simulation.
struct FatigueEffect {
  bool is_on = false;
  double depth = 0.3;            ///< Share that is lost in the end.
  double time_constant = 600.0;  ///< s.
};

/// The hand opens at `at` seconds from the start of the simulation, and holds again `duration` later.
struct LettingGoEffect {
  bool is_on = false;
  double at = 10.0;       ///< s.
  double duration = 5.0;  ///< s.
};

/// The subject slowly moves the spring centre so that the hand stays at the posture against a steady force,
/// and stops doing so while the hand is in quick motion and for `pause` after: how a bias force is held.
struct RecentringEffect {
  bool is_on = false;
  double time_constant = 1.0;  ///< s.
  double speed = 0.01;         ///< m/s, above which the subject waits.
  double pause = 2.0;          ///< s.
};

/// The subject stiffens against the force that he holds: stiffness and damping of all muscles are multiplied
/// by 1 + gain |f|, f the steady force of the hand (N), which follows with the time constant and rests, as in
/// recentring, while the hand is in quick motion.
struct ModulationEffect {
  bool is_on = false;
  double gain = 0.4;           ///< 1/N.
  double time_constant = 0.5;  ///< s.
};

/// The subject does with his muscles what a protocol's instruction says (instruction.hpp).
struct InstructionEffect {
  bool is_on = true;
  double relaxed = 0.7;    ///< Share of stiffness and damping that "relax" leaves.
  double stiffened = 2.0;  ///< Times the stiffness, of "stiffen".
};

/// How active the six muscles are (muscles.hpp), and what their EMG looks like.
struct MuscleProfile {
  double rest = 0.02;          ///< Activation of a muscle of which nothing is asked.
  double per_stiffness = 0.2;  ///< Activation of a pair, for each time that its stiffness grows.
  JointImpedance strength{60.0, 50.0, 25.0};  ///< N m at full activation.
  double reflex = 0.3;                        ///< Activation at a stretch of 1 rad/s, where the reflex is on.
  double reflex_threshold = 0.003;            ///< rad/s, of the stretch.
  double contraction_latency = 0.15;          ///< s, from the onset of a contraction to the muscles.
  double contraction_rise = 0.15;             ///< s.
  double emg = 1e-3;                          ///< V rms at full activation.
  double noise = 4e-6;                        ///< V rms, of the electrodes.
};

/// A subject's right arm: two uniform cylinders, linear joint stiffness and damping about the posture, and
/// the effects of a living arm, all off by default but that he
/// follows instructions, of which most protocols have none.
struct SubjectProfile {
  TwoLink links{0.31, 0.34};
  Eigen::Vector2d link_masses{2.0, 1.5};      ///< kg.
  Eigen::Vector2d link_radii{0.045, 0.036};   ///< m.
  JointImpedance stiffness{22.0, 17.0, 8.0};  ///< N m/rad.
  JointImpedance damping{1.3, 0.75, 0.28};    ///< N m s/rad.
  Eigen::Vector2d posture{0.0, 0.38};         ///< m in S, at the start of the simulation.

  ReflexEffect reflex;
  TremorEffect tremor;
  DriftEffect drift;
  ReactionEffect reaction;
  FatigueEffect fatigue;
  LettingGoEffect letting_go;
  RecentringEffect recentring;
  ModulationEffect modulation;
  MisconductEffect misconduct;
  InstructionEffect instruction;
  MuscleProfile muscles;
};

}  // namespace tonus::simulation
