#include "tests/campaigns/record_kinds.hpp"

#include <Eigen/Eigenvalues>
#include <Eigen/Geometry>
#include <Eigen/LU>
#include <algorithm>
#include <cmath>
#include <complex>
#include <numbers>
#include <random>
#include <unsupported/Eigen/FFT>

namespace tonus::campaigns {
namespace {

using Complex = std::complex<double>;
constexpr double kTau = 2.0 * std::numbers::pi;

/// What a kind sets; the rest is drawn.
struct Recipe {
  int axes = 1;
  double resonance_low = 0.005, resonance_high = 0.08;  // of the rate
  double duration_low = 20.0, duration_high = 60.0;     // s at 1 kHz; scaled with the resonance
  double least_cycles = 60.0;                           // of the resonance in the record
  double noise_x = 0.01, noise_f = 0.01;                // of the signal's root mean square
  bool is_noise_pink = false;
  double most_lag = 0.0;      // s
  double drift = 0.0;         // of the force's root mean square
  double disturbance = 0.0;   // voluntary force, of the same
  double friction = 0.0;      // likewise
  double hardening = 0.0;     // x^3 term over the linear one at one standard deviation
  double drag = 0.0;          // likewise of v|v|
  double position = 0.0;      // change of stiffness over two standard deviations
  double wander = 0.0;        // slow relative change of stiffness in time
  double reflex = 0.0;        // stiffness with a delay of 30 to 60 ms, of K
  double second_mass = 0.0;   // of M, on a spring, resonating in the band
  double force_filter = 0.0;  // cutoff of a low-pass on the force, of the resonance
  int held = 1;               // samples that the force is held for
  bool is_joined = false;     // by straight lines in place of steps
  double clip = 0.0;          // of the force's root mean square
  double step_x = 0.0;        // encoder step, of the displacement's root mean square
  int gaps = 0;
  int events = 1;
  bool is_multisine = false;
  // What drives.
  double colour = 0.0;  // power falls with this exponent of frequency
  int tones = 0;        // only so many frequencies
  int sweeps = 0;       // of sines through the band, in place of noise
  int bursts = 0;       // the drive is on a third of the time, so many times
  double narrow = 0.0;  // the band is the resonance times and over this
  // The arm beyond the model.
  double maxwell = 0.0;         // stiffness that relaxes with a corner at half the resonance, of K
  double reaction = 0.0;        // stiffness with a delay of 120 to 200 ms, of K
  double stiffness_step = 0.0;  // relative change of stiffness at half of the record
  double stiffness_wave = 0.0;  // relative change of stiffness, 5 to 20 periods a record
  double backlash = 0.0;        // slack of the grip, of the displacement's root mean square
  // What recording does.
  double force_lowpass = 0.0;     // second-order Butterworth on the force, cutoff over the resonance
  double motion_lowpass = 0.0;    // on the displacement
  bool is_splined = false;        // held samples, joined by cubic splines
  bool is_hold_smoothed = false;  // held samples behind a low-pass at half of their rate
  double step_f = 0.0;            // of the force's converter, of its root mean square
  double hum = 0.0;               // of mains on both channels, of the root mean square
  double offset_steps = 0.0;      // of the force's zero, of its root mean square
  int dropped = 0;                // rows that are absent without a mark
  double jitter = 0.0;            // of the time of sampling, of a sample period, both channels alike
  double crosstalk = 0.0;         // of the force sensor's axes
  bool is_swapped = false;        // force axes
  double turned = 0.0;            // rad, force axes against motion's
  int slow_axis = 1;              // samples that the second axis is held for, force and motion
  double drift_x = 0.0;           // random walk of the displacement's zero, of its root mean square
};

struct Named {
  RecordKind kind;
  Recipe recipe;
};

const std::vector<Named>& all_kinds() {
  static const std::vector<Named> kinds = [] {
    std::vector<Named> list;
    const auto add = [&](const char* name, bool is_described, const auto& set) {
      Recipe recipe;
      set(recipe);
      list.push_back({{name, is_described}, recipe});
    };
    const auto resonance = [](double at) {
      return [at](Recipe& r) { r.resonance_low = r.resonance_high = at; };
    };
    add("resonance_0.002", true, resonance(0.002));
    add("resonance_0.01", true, resonance(0.01));
    add("resonance_0.05", true, resonance(0.05));
    add("resonance_0.11", true, resonance(0.11));
    add("resonance_0.2", true, resonance(0.2));
    add("multisine", true, [](Recipe& r) { r.is_multisine = true; });
    add("noisy_motion", true, [](Recipe& r) { r.noise_x = 0.2; });
    add("noisy_force", true, [](Recipe& r) { r.noise_f = 0.2; });
    add("pink_noise", true, [](Recipe& r) { r.is_noise_pink = true, r.noise_x = 0.03, r.noise_f = 0.1; });
    add("skew", true, [](Recipe& r) { r.most_lag = 0.010; });
    add("drift", true, [](Recipe& r) { r.drift = 1.0; });
    add("encoder_steps", true, [](Recipe& r) { r.step_x = 0.05; });
    add("gaps", true, [](Recipe& r) { r.gaps = 4; });
    add("events", true, [](Recipe& r) { r.events = 4; });
    add("short", true, [](Recipe& r) { r.duration_low = r.duration_high = 3.0, r.least_cycles = 25.0; });
    add("light_disturbance", true, [](Recipe& r) { r.disturbance = 0.03; });
    add("two_axes", true, [](Recipe& r) { r.axes = 2; });
    add("two_axes_skew", true, [](Recipe& r) { r.axes = 2, r.most_lag = 0.010; });
    add("two_axes_noise", true, [](Recipe& r) { r.axes = 2, r.noise_x = r.noise_f = 0.1; });
    add("friction", false, [](Recipe& r) { r.friction = 0.33; });
    add("light_friction", false, [](Recipe& r) { r.friction = 0.08; });
    add("hardening", false, [](Recipe& r) { r.hardening = 0.15; });
    add("short_hardening", false,
        [](Recipe& r) { r.hardening = 0.15, r.duration_low = r.duration_high = 3.0, r.least_cycles = 25.0; });
    add("drag", false, [](Recipe& r) { r.drag = 0.5; });
    add("position", false, [](Recipe& r) { r.position = 0.8; });
    add("wandering_stiffness", false, [](Recipe& r) { r.wander = 0.3; });
    add("reflex", false, [](Recipe& r) { r.reflex = 0.2, r.resonance_low = 0.004, r.resonance_high = 0.01; });
    add("second_mass", false, [](Recipe& r) { r.second_mass = 0.5; });
    add("filtered_force", false, [](Recipe& r) { r.force_filter = 0.7; });
    add("clipped_force", false, [](Recipe& r) { r.clip = 2.0; });
    add("held_force", false, [](Recipe& r) { r.held = 10, r.resonance_high = 0.02; });
    add("joined_force", false, [](Recipe& r) { r.held = 10, r.is_joined = true, r.resonance_high = 0.02; });
    add("strong_disturbance", false, [](Recipe& r) { r.disturbance = 0.5; });
    add("disturbance", false, [](Recipe& r) { r.disturbance = 0.15; });
    add("coloured_drive", true, [](Recipe& r) { r.colour = 2.0; });
    add("narrow_drive", true, [](Recipe& r) { r.narrow = 1.5; });
    add("two_tones", false, [](Recipe& r) { r.tones = 2; });
    add("twelve_tones", true, [](Recipe& r) { r.tones = 12; });
    add("two_tones_reflex", false,
        [](Recipe& r) { r.tones = 2, r.reflex = 0.2, r.resonance_low = 0.004, r.resonance_high = 0.01; });
    add("three_tones_reflex", false,
        [](Recipe& r) { r.tones = 3, r.reflex = 0.2, r.resonance_low = 0.004, r.resonance_high = 0.01; });
    add("sweep", true, [](Recipe& r) { r.sweeps = 1; });
    add("sweeps", true, [](Recipe& r) { r.sweeps = 8; });
    add("bursts", true, [](Recipe& r) { r.bursts = 6; });
    add("very_short", false, [](Recipe& r) { r.duration_low = r.duration_high = 0.8, r.least_cycles = 8.0; });
    add("strong_drift", true, [](Recipe& r) { r.drift = 30.0; });
    add("offset_steps", false, [](Recipe& r) { r.offset_steps = 3.0; });
    add("walking_zero", true, [](Recipe& r) { r.drift_x = 1.0; });
    add("coarse_encoder", false, [](Recipe& r) { r.step_x = 0.4, r.noise_x = 0.0; });
    add("coarse_force", false, [](Recipe& r) { r.step_f = 0.3, r.noise_f = 0.0; });
    add("integer_counts", true, [](Recipe& r) { r.step_f = 0.02, r.step_x = 0.02; });
    add("hum", false, [](Recipe& r) { r.hum = 0.1, r.resonance_high = 0.03; });
    add("strong_hum", false, [](Recipe& r) { r.hum = 0.5, r.resonance_high = 0.03; });
    add("softening", false, [](Recipe& r) { r.hardening = -0.06; });
    add("light_hardening", false, [](Recipe& r) { r.hardening = 0.03; });
    add("faint_friction", false, [](Recipe& r) { r.friction = 0.03; });
    add("light_drag", false, [](Recipe& r) { r.drag = 0.15; });
    add("maxwell", false, [](Recipe& r) { r.maxwell = 0.5; });
    add("light_maxwell", false, [](Recipe& r) { r.maxwell = 0.15; });
    add("reaction", false,
        [](Recipe& r) { r.reaction = 0.3, r.resonance_low = 0.002, r.resonance_high = 0.005; });
    add("light_reflex", false,
        [](Recipe& r) { r.reflex = 0.05, r.resonance_low = 0.004, r.resonance_high = 0.01; });
    add("light_second_mass", false, [](Recipe& r) { r.second_mass = 0.1; });
    add("stiffness_step", false, [](Recipe& r) { r.stiffness_step = 0.2; });
    add("stiffness_wave", false, [](Recipe& r) { r.stiffness_wave = 0.3; });
    add("backlash", false, [](Recipe& r) { r.backlash = 0.2; });
    add("lowpass_2_force", false, [](Recipe& r) { r.force_lowpass = 2.0; });
    add("lowpass_4_force", false, [](Recipe& r) { r.force_lowpass = 4.0; });
    add("lowpass_10_force", false, [](Recipe& r) { r.force_lowpass = 10.0, r.resonance_high = 0.03; });
    add("lowpass_2_motion", false, [](Recipe& r) { r.motion_lowpass = 2.0; });
    add("lowpass_4_motion", false, [](Recipe& r) { r.motion_lowpass = 4.0; });
    add("splined_force", false, [](Recipe& r) { r.held = 10, r.is_splined = true, r.resonance_high = 0.02; });
    add("smoothed_hold", false,
        [](Recipe& r) { r.held = 10, r.is_hold_smoothed = true, r.resonance_high = 0.02; });
    add("dropped_samples", false, [](Recipe& r) { r.dropped = 30; });
    add("few_dropped_samples", false, [](Recipe& r) { r.dropped = 3; });
    add("jitter", false, [](Recipe& r) { r.jitter = 0.3; });
    add("two_axes_crosstalk", false, [](Recipe& r) { r.axes = 2, r.crosstalk = 0.1; });
    add("two_axes_swapped", false, [](Recipe& r) { r.axes = 2, r.is_swapped = true; });
    add("two_axes_turned", false, [](Recipe& r) { r.axes = 2, r.turned = 0.3; });
    add("two_axes_two_rates", false, [](Recipe& r) { r.axes = 2, r.slow_axis = 4; });
    add("two_axes_hardening", false, [](Recipe& r) { r.axes = 2, r.hardening = 0.15; });
    add("two_axes_gaps", true, [](Recipe& r) { r.axes = 2, r.gaps = 4; });
    add("two_axes_sweep", true, [](Recipe& r) { r.axes = 2, r.sweeps = 4; });
    add("two_axes_lowpass", false, [](Recipe& r) { r.axes = 2, r.force_lowpass = 4.0; });
    add("two_axes_disturbance", false, [](Recipe& r) { r.axes = 2, r.disturbance = 0.15; });
    add("two_axes_friction", false, [](Recipe& r) { r.axes = 2, r.friction = 0.33; });
    add("two_axes_reflex", false,
        [](Recipe& r) { r.axes = 2, r.reflex = 0.2, r.resonance_low = 0.004, r.resonance_high = 0.01; });
    return list;
  }();
  return kinds;
}

const Recipe& recipe_of(const RecordKind& kind) {
  return std::ranges::find(all_kinds(), kind.name, [](const Named& n) { return n.kind.name; })->recipe;
}

class Draw {
 public:
  Draw(const Recipe& recipe, std::uint64_t seed) : r_(recipe), random_(seed) {}

  DrawnRecords records() {
    set_arm();
    DrawnRecords drawn;
    drawn.M = M_;
    drawn.B = B_;
    drawn.K = K_;
    drawn.lag = lag_;
    for (int event = 0; event < r_.events; ++event) add_record(drawn);
    drawn.K += stiffness_at_mean_ / r_.events;
    return drawn;
  }

 private:
  double uniform(double low, double high) {
    return std::uniform_real_distribution<double>(low, high)(random_);
  }
  double log_uniform(double low, double high) { return std::exp(uniform(std::log(low), std::log(high))); }
  double normal() { return std::normal_distribution<double>()(random_); }

  /// Symmetric, positive definite, eigenvalues within a factor of 3 for two axes.
  Eigen::MatrixXd spread_matrix(double size) {
    if (r_.axes == 1) return Eigen::MatrixXd::Constant(1, 1, size);
    const double angle = uniform(0.0, std::numbers::pi);
    Eigen::Matrix2d R;
    R << std::cos(angle), -std::sin(angle), std::sin(angle), std::cos(angle);
    return R * Eigen::Vector2d(size, size * uniform(0.35, 1.0)).asDiagonal() * R.transpose();
  }

  void set_arm() {
    rate_ = log_uniform(200.0, 5000.0);
    if (r_.reflex > 0.0 || r_.reaction > 0.0 || r_.held > 1 || r_.hum > 0.0) rate_ = 1000.0;
    const double resonance = rate_ * log_uniform(r_.resonance_low, r_.resonance_high);
    const double natural = kTau * resonance;
    const double mass = log_uniform(0.02, 20.0);
    const double zeta = uniform(0.12, 0.7);
    M_ = spread_matrix(mass);
    B_ = spread_matrix(2.0 * zeta * mass * natural);
    K_ = spread_matrix(mass * natural * natural);
    stiffness_at_mean_ = Eigen::MatrixXd::Zero(r_.axes, r_.axes);
    resonance_ = resonance;
    const double seconds =
        std::max(uniform(r_.duration_low, r_.duration_high) * std::min(1.0, 1000.0 / rate_),
                 r_.least_cycles / resonance);
    rows_ = static_cast<Eigen::Index>(seconds * rate_ / r_.events);
    // What drives is a force on the rig: its own light mass, damping and spring lie beside the arm.
    rig_mass_ = mass * uniform(0.05, 0.3);
    rig_stiffness_ = K_.norm() * uniform(0.05, 0.5);
    low_ = 0.1 * resonance;
    high_ = std::min(uniform(2.5, 4.0) * resonance, 0.42 * rate_);
    if (r_.narrow > 0.0) low_ = resonance / r_.narrow, high_ = std::min(resonance * r_.narrow, 0.42 * rate_);
    late_ = uniform(0.12, 0.2);
    lag_ = Eigen::VectorXd::Zero(r_.axes);
    for (double& lag : lag_) lag = uniform(-r_.most_lag, r_.most_lag);
    delay_ = uniform(0.03, 0.06);
    scale_ = log_uniform(1e-3, 1.0);
  }

  /// Response of force to motion, without the lag.
  Eigen::MatrixXcd response(double w) const {
    const Complex jw(0.0, w);
    Eigen::MatrixXcd Z = K_.cast<Complex>() + jw * B_ - w * w * M_;
    if (r_.reflex > 0.0) Z += r_.reflex * K_ * std::exp(-jw * delay_);
    if (r_.reaction > 0.0) Z += r_.reaction * K_ * std::exp(-jw * late_);
    if (r_.maxwell > 0.0) Z += r_.maxwell * K_ * (jw / (jw + 0.5 * kTau * resonance_));
    if (r_.second_mass > 0.0) {
      const double m = r_.second_mass * M_(0, 0);
      const double at = kTau * 1.4 * resonance_;
      const Complex spring = m * at * at + jw * (0.1 * m * at);
      Z += Eigen::MatrixXcd::Identity(r_.axes, r_.axes) * (spring * (-w * w * m) / (spring - w * w * m));
    }
    return Z;
  }

  /// Random spectrum within [low, high] Hz, one column an axis: of `power` law f^-exponent.
  Eigen::MatrixXcd spectrum(Eigen::Index length, double low, double high, double exponent,
                            bool is_multisine) {
    Eigen::MatrixXcd S = Eigen::MatrixXcd::Zero(length / 2, r_.axes);
    for (Eigen::Index k = 1; k < length / 2; ++k) {
      const double f = rate_ * static_cast<double>(k) / static_cast<double>(length);
      if (f < low || f > high) continue;
      const double size = std::pow(f / resonance_, -0.5 * exponent);
      for (int i = 0; i < r_.axes; ++i)
        S(k, i) = is_multisine ? std::polar(size, uniform(0.0, kTau)) : size * Complex(normal(), normal());
    }
    return S;
  }

  Eigen::MatrixXd in_time(const Eigen::MatrixXcd& S, Eigen::Index length) {
    Eigen::MatrixXd signals(length, S.cols());
    Eigen::FFT<double> transform;
    for (Eigen::Index i = 0; i < S.cols(); ++i) {
      std::vector<Complex> whole(static_cast<std::size_t>(length), 0.0);
      for (Eigen::Index k = 1; k < S.rows(); ++k) {
        whole[static_cast<std::size_t>(k)] = S(k, i);
        whole[static_cast<std::size_t>(length - k)] = std::conj(S(k, i));
      }
      std::vector<Complex> signal;
      transform.inv(signal, whole);
      for (Eigen::Index t = 0; t < length; ++t) signals(t, i) = signal[static_cast<std::size_t>(t)].real();
    }
    return signals;
  }

  static Eigen::MatrixXcd transformed(const Eigen::MatrixXd& signals) {
    Eigen::MatrixXcd S(signals.rows() / 2, signals.cols());
    Eigen::FFT<double> transform;
    for (Eigen::Index i = 0; i < signals.cols(); ++i) {
      std::vector<Complex> signal(signals.col(i).begin(), signals.col(i).end());
      std::vector<Complex> whole;
      transform.fwd(whole, signal);
      for (Eigen::Index k = 0; k < S.rows(); ++k) S(k, i) = whole[static_cast<std::size_t>(k)];
    }
    return S;
  }

  /// Spectrum of what drives the rig.
  Eigen::MatrixXcd drive(Eigen::Index period) {
    if (r_.sweeps > 0) return sweep(period);
    Eigen::MatrixXcd U = spectrum(period, low_, high_, r_.colour, r_.is_multisine);
    if (r_.tones > 0) keep_tones(U, period);
    if (r_.bursts == 0) return U;
    Eigen::MatrixXd u = in_time(U, period);
    const Eigen::Index each = rows_ / r_.bursts;
    for (Eigen::Index t = 0; t < period; ++t) {
      if (t % each > each / 3) u.row(t).setZero();
    }
    Eigen::MatrixXcd burst = transformed(u);
    for (Eigen::Index k = 0; k < burst.rows(); ++k) {
      if (rate_ * static_cast<double>(k) / static_cast<double>(period) > 0.45 * rate_) burst.row(k).setZero();
    }
    return burst;
  }

  Eigen::MatrixXcd sweep(Eigen::Index period) {
    Eigen::MatrixXd u = Eigen::MatrixXd::Zero(period, r_.axes);
    const Eigen::Index each = rows_ / r_.sweeps;
    for (int i = 0; i < r_.axes; ++i) {
      double phase = uniform(0.0, kTau);
      for (Eigen::Index t = 0; t < rows_; ++t) {
        // Two axes go through the band in opposite ways: at one time they are at different frequencies.
        const double share = static_cast<double>(t % each) / static_cast<double>(each);
        const double part = (t / each + i) % 2 == 0 ? share : 1.0 - share;
        phase += kTau / rate_ * low_ * std::pow(high_ / low_, part);
        u(t, i) = std::sin(phase);
      }
    }
    Eigen::MatrixXcd S = transformed(u);
    for (Eigen::Index k = 0; k < S.rows(); ++k) {
      if (static_cast<double>(k) > 0.45 * static_cast<double>(period)) S.row(k).setZero();
    }
    return S;
  }

  /// All of the power at a few frequencies between 0.4 and 2 times the resonance.
  void keep_tones(Eigen::MatrixXcd& U, Eigen::Index period) {
    Eigen::MatrixXcd kept = Eigen::MatrixXcd::Zero(U.rows(), U.cols());
    for (int n = 0; n < r_.tones; ++n) {
      const double part = (n + uniform(0.2, 0.8)) / r_.tones;
      const double f = resonance_ * 0.4 * std::pow(5.0, part);
      const auto k = static_cast<Eigen::Index>(std::llround(f / rate_ * static_cast<double>(period)));
      for (Eigen::Index i = 0; i < U.cols(); ++i) kept(k, i) = std::polar(1.0, uniform(0.0, kTau));
    }
    U = kept;
  }

  static Complex butterworth(double w, double cutoff) {
    const Complex s(0.0, w / cutoff);
    return 1.0 / (s * s + std::numbers::sqrt2 * s + 1.0);
  }

  static double rms(const Eigen::MatrixXd& signals, Eigen::Index axis) {
    return std::sqrt(signals.col(axis).squaredNorm() / static_cast<double>(signals.rows()));
  }

  /// White, or 1/f from a hundredth of the resonance on, of a root mean square.
  void add_noise(Eigen::MatrixXd& signals, double share) {
    const Eigen::Index rows = signals.rows();
    Eigen::MatrixXd noise(rows, r_.axes);
    if (r_.is_noise_pink) {
      const Eigen::Index length = spectral::fast_length(rows);
      noise = in_time(spectrum(length, 0.01 * resonance_, 0.5 * rate_, 1.0, false), length).topRows(rows);
    } else {
      for (Eigen::Index t = 0; t < rows; ++t) {
        for (int i = 0; i < r_.axes; ++i) noise(t, i) = normal();
      }
    }
    for (int i = 0; i < r_.axes; ++i)
      signals.col(i) += noise.col(i) * (share * rms(signals, i) / rms(noise, i));
  }

  void add_record(DrawnRecords& drawn) {
    const Eigen::Index period = spectral::fast_length(2 * rows_);
    Eigen::MatrixXcd U = drive(period);
    Eigen::MatrixXcd D = Eigen::MatrixXcd::Zero(period / 2, r_.axes);
    if (r_.disturbance > 0.0) D = spectrum(period, low_, high_, 1.0, false);
    Eigen::MatrixXcd X = Eigen::MatrixXcd::Zero(period / 2, r_.axes);
    Eigen::MatrixXcd V = X;
    Eigen::MatrixXcd F = X;
    if (r_.disturbance > 0.0) D *= r_.disturbance * U.norm() / D.norm();
    for (Eigen::Index k = 1; k < period / 2; ++k) {
      const double w = kTau * rate_ * static_cast<double>(k) / static_cast<double>(period);
      if (U.row(k).squaredNorm() == 0.0 && D.row(k).squaredNorm() == 0.0) continue;
      const Eigen::MatrixXcd Z = response(w);
      const Eigen::MatrixXcd rig =
          Eigen::MatrixXcd::Identity(r_.axes, r_.axes) *
          Complex(rig_stiffness_ - w * w * rig_mass_, w * std::sqrt(rig_stiffness_ * rig_mass_));
      const Eigen::VectorXcd u = U.row(k).transpose();
      const Eigen::VectorXcd d = D.row(k).transpose();
      const Eigen::VectorXcd x = (Z + rig).partialPivLu().solve(u + d);
      Eigen::VectorXcd f = Z * x - d;  // the arm pushes with d
      if (r_.force_filter > 0.0) f /= Complex(1.0, w / (kTau * r_.force_filter * resonance_));
      for (int i = 0; i < r_.axes; ++i) f[i] *= std::polar(1.0, -w * lag_[i]);
      if (r_.force_lowpass > 0.0) f *= butterworth(w, kTau * r_.force_lowpass * resonance_);
      const Complex seen =
          r_.motion_lowpass > 0.0 ? butterworth(w, kTau * r_.motion_lowpass * resonance_) : 1.0;
      X.row(k) = seen * x.transpose();
      V.row(k) = Complex(0.0, w) * x.transpose();
      F.row(k) = f.transpose();
    }
    const auto cut = [&](const Eigen::MatrixXcd& S) {
      return Eigen::MatrixXd(in_time(S, period).topRows(rows_));
    };
    Eigen::MatrixXd x = cut(X);
    Eigen::MatrixXd v = cut(V);
    Eigen::MatrixXd f = cut(F);
    const double to_scale = scale_ / rms(x, 0);
    x *= to_scale;
    v *= to_scale;
    f *= to_scale;
    const Eigen::MatrixXd command = cut(U) * to_scale;
    bend(x, v, f);
    add_noise(x, r_.noise_x);
    add_noise(f, r_.noise_f);
    spoil(x, f);
    mislead(x, f);
    spectral::Record record{1.0 / rate_, x, f, {}};
    for (int gap = 0; gap < r_.gaps; ++gap) {
      record.is_missing.resize(static_cast<std::size_t>(rows_), false);
      const auto first = static_cast<Eigen::Index>(uniform(0.05, 0.9) * static_cast<double>(rows_));
      const auto rows = static_cast<Eigen::Index>(uniform(1.0, 0.02 * static_cast<double>(rows_)));
      for (Eigen::Index t = first; t < std::min(first + rows, rows_); ++t) {
        record.is_missing[static_cast<std::size_t>(t)] = true;
        record.displacement.row(t).setConstant(std::nan(""));
        record.force.row(t).setConstant(std::nan(""));
      }
    }
    drawn.records.push_back(std::move(record));
    drawn.commanded.push_back(command);
  }

  /// What the model does not have.
  void bend(const Eigen::MatrixXd& x, const Eigen::MatrixXd& v, Eigen::MatrixXd& f) {
    for (int i = 0; i < r_.axes; ++i) {
      const double size = rms(f, i);
      const double sx = rms(x, i);
      const double sv = rms(v, i);
      const double phase = uniform(0.0, kTau);
      const double waves = r_.stiffness_wave > 0.0 ? std::round(uniform(5.0, 20.0)) : 0.0;
      if (r_.backlash > 0.0) slacken(x.col(i), r_.backlash * sx, f.col(i));
      const double mean = x.col(i).mean() / sx;  // small motion is about the mean position
      stiffness_at_mean_(i, i) += K_(i, i) * (3.0 * r_.hardening * mean * mean + 0.5 * r_.position * mean);
      for (Eigen::Index t = 0; t < f.rows(); ++t) {
        const double share = static_cast<double>(t) / static_cast<double>(f.rows());
        const double p = x(t, i) / sx;
        const double q = v(t, i) / sv;
        f(t, i) += r_.friction * size * std::tanh(50.0 * q) + r_.hardening * K_(i, i) * sx * p * p * p +
                   r_.drag * B_(i, i) * sv * q * std::abs(q) + 0.25 * r_.position * K_(i, i) * sx * p * p +
                   r_.wander * K_(i, i) * x(t, i) * std::sin(kTau * share + phase) +
                   r_.stiffness_step * K_(i, i) * x(t, i) * (share < 0.5 ? -0.5 : 0.5) +
                   r_.stiffness_wave * K_(i, i) * x(t, i) * std::sin(kTau * waves * share + phase);
      }
    }
  }

  /// The spring part of the force acts on what is left of x behind a slack.
  void slacken(const Eigen::Ref<const Eigen::VectorXd>& x, double slack, Eigen::Ref<Eigen::VectorXd> f) {
    double behind = x[0];
    for (Eigen::Index t = 0; t < x.size(); ++t) {
      behind = std::clamp(behind, x[t] - slack, x[t] + slack);
      f[t] += K_(0, 0) * (behind - x[t]);
    }
  }

  /// Values at fractional rows by cubic convolution.
  static double between(const Eigen::VectorXd& all, double row) {
    const auto at = [&](Eigen::Index i) { return all[std::clamp<Eigen::Index>(i, 0, all.size() - 1)]; };
    const auto i = static_cast<Eigen::Index>(std::floor(row));
    const double s = row - static_cast<double>(i);
    return at(i) + 0.5 * s *
                       (at(i + 1) - at(i - 1) +
                        s * (2.0 * at(i - 1) - 5.0 * at(i) + 4.0 * at(i + 1) - at(i + 2) +
                             s * (3.0 * (at(i) - at(i + 1)) + at(i + 2) - at(i - 1))));
  }

  /// Samples of a slower rate at this one: by cubics, or as steps behind a filter that takes their images.
  Eigen::VectorXd resampled(const Eigen::VectorXd& fast) const {
    Eigen::VectorXd slow((fast.size() + r_.held - 1) / r_.held);
    for (Eigen::Index i = 0; i < slow.size(); ++i) slow[i] = fast[i * r_.held];
    Eigen::VectorXd found(fast.size());
    for (Eigen::Index t = 0; t < fast.size(); ++t)
      found[t] = r_.is_splined ? between(slow, static_cast<double>(t) / r_.held) : slow[t / r_.held];
    if (r_.is_splined) return found;
    Eigen::MatrixXcd S = transformed(found.head(found.size() / 2 * 2));
    const auto last = static_cast<Eigen::Index>(static_cast<double>(S.rows()) / r_.held);
    S.bottomRows(S.rows() - last).setZero();
    S(0, 0) = 0.0;
    Eigen::VectorXd smooth = fast;
    std::vector<Complex> whole(static_cast<std::size_t>(2 * S.rows()), 0.0);
    for (Eigen::Index k = 1; k < S.rows(); ++k) {
      whole[static_cast<std::size_t>(k)] = S(k, 0);
      whole[whole.size() - static_cast<std::size_t>(k)] = std::conj(S(k, 0));
    }
    std::vector<Complex> signal;
    Eigen::FFT<double> transform;
    transform.inv(signal, whole);
    for (Eigen::Index t = 0; t < std::ssize(signal); ++t)
      smooth[t] = signal[static_cast<std::size_t>(t)].real();
    return smooth;
  }

  /// Axes and times that are not what they seem.
  void mislead(Eigen::MatrixXd& x, Eigen::MatrixXd& f) {
    if (r_.axes == 2) {
      Eigen::Matrix2d C = Eigen::Matrix2d::Identity();
      C(0, 1) = r_.crosstalk;
      if (r_.is_swapped) C << 0.0, 1.0, 1.0, 0.0;
      if (r_.turned != 0.0) C = Eigen::Rotation2Dd(r_.turned).toRotationMatrix();
      f = (f * C.transpose()).eval();
    }
    if (r_.slow_axis > 1) {
      for (Eigen::Index t = 0; t < x.rows(); ++t) {
        x(t, 1) = x(t / r_.slow_axis * r_.slow_axis, 1);
        f(t, 1) = f(t / r_.slow_axis * r_.slow_axis, 1);
      }
    }
    if (r_.jitter > 0.0) {
      const Eigen::MatrixXd old_x = x;
      const Eigen::MatrixXd old_f = f;
      for (Eigen::Index t = 0; t < x.rows(); ++t) {
        const double row = static_cast<double>(t) + uniform(-r_.jitter, r_.jitter);
        for (int i = 0; i < r_.axes; ++i) {
          x(t, i) = between(old_x.col(i), row);
          f(t, i) = between(old_f.col(i), row);
        }
      }
    }
    for (int n = 0; n < r_.dropped; ++n) {
      const Eigen::Index rows = x.rows() - 1 - n;
      const auto at = static_cast<Eigen::Index>(uniform(0.05, 0.95) * static_cast<double>(rows));
      for (auto* signal : {&x, &f})
        signal->middleRows(at, rows - at) = signal->middleRows(at + 1, rows - at).eval();
    }
    if (r_.dropped > 0) {
      x.conservativeResize(x.rows() - r_.dropped, Eigen::NoChange);
      f.conservativeResize(f.rows() - r_.dropped, Eigen::NoChange);
    }
  }

  /// What recording does.
  void spoil(Eigen::MatrixXd& x, Eigen::MatrixXd& f) {
    for (int i = 0; i < r_.axes; ++i) {
      const double size = rms(f, i);
      const double step = r_.step_x * rms(x, i);
      const double phase = uniform(0.0, kTau);
      if (r_.is_splined || r_.is_hold_smoothed) f.col(i) = resampled(f.col(i));
      const Eigen::VectorXd slow = f.col(i);
      const double step_f = r_.step_f * size;
      const double sx = rms(x, i);
      const double hum_x = uniform(0.0, kTau);
      const double hum_f = uniform(0.0, kTau);
      double walk = 0.0;
      const double stride = r_.drift_x * sx / std::sqrt(static_cast<double>(f.rows()));
      for (Eigen::Index t = 0; t < f.rows(); ++t) {
        if (r_.drift_x > 0.0) x(t, i) += walk += stride * normal();
        if (r_.hum > 0.0) {
          x(t, i) += r_.hum * sx * std::sin(kTau * 50.0 * static_cast<double>(t) / rate_ + hum_x);
          f(t, i) += r_.hum * size * std::sin(kTau * 50.0 * static_cast<double>(t) / rate_ + hum_f);
        }
        f(t, i) += r_.offset_steps * size * static_cast<double>(4 * t / f.rows() % 2);
        const double share = static_cast<double>(t) / static_cast<double>(f.rows());
        f(t, i) += r_.drift * size * (std::sin(kTau * share + phase) + 2.0 * share);
        if (r_.clip > 0.0) f(t, i) = std::clamp(f(t, i), -r_.clip * size, r_.clip * size);
        if (step > 0.0) x(t, i) = step * std::round(x(t, i) / step);
        if (step_f > 0.0) f(t, i) = step_f * std::round(f(t, i) / step_f);
        if (r_.held > 1 && !r_.is_splined && !r_.is_hold_smoothed) {
          const Eigen::Index from = t / r_.held * r_.held;
          const Eigen::Index to = std::min(from + r_.held, f.rows() - 1);
          const double part = static_cast<double>(t - from) / r_.held;
          f(t, i) = r_.is_joined ? slow[from] + part * (slow[to] - slow[from]) : slow[from];
        }
      }
    }
  }

  Recipe r_;
  std::mt19937_64 random_;
  double rate_ = 1000.0;
  double resonance_ = 10.0;
  double rig_mass_ = 0.0;
  double rig_stiffness_ = 0.0;
  double low_ = 0.0;
  double high_ = 0.0;
  double delay_ = 0.0;
  double late_ = 0.0;
  double scale_ = 1.0;
  Eigen::Index rows_ = 0;
  Eigen::MatrixXd M_, B_, K_;
  Eigen::MatrixXd stiffness_at_mean_;  // less K_; summed over the records
  Eigen::VectorXd lag_;
};

}  // namespace

const std::vector<RecordKind>& record_kinds() {
  static const std::vector<RecordKind> kinds = [] {
    std::vector<RecordKind> list;
    for (const Named& named : all_kinds()) list.push_back(named.kind);
    return list;
  }();
  return kinds;
}

DrawnRecords draw(const RecordKind& kind, std::uint64_t seed) {
  std::uint64_t mixed = 1469598103934665603ull ^ seed;  // FNV over the name: kinds do not share their draws
  for (const char c : kind.name) mixed = (mixed ^ static_cast<unsigned char>(c)) * 1099511628211ull;
  return Draw(recipe_of(kind), mixed).records();
}

}  // namespace tonus::campaigns
