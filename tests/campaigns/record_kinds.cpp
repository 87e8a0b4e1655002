#include "tests/campaigns/record_kinds.hpp"

#include <Eigen/Eigenvalues>
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
    if (r_.reflex > 0.0 || r_.held > 1) rate_ = 1000.0;
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
    Eigen::MatrixXcd U = spectrum(period, low_, high_, 0.0, r_.is_multisine);
    Eigen::MatrixXcd D = Eigen::MatrixXcd::Zero(period / 2, r_.axes);
    if (r_.disturbance > 0.0) D = spectrum(period, low_, high_, 1.0, false);
    Eigen::MatrixXcd X = Eigen::MatrixXcd::Zero(period / 2, r_.axes);
    Eigen::MatrixXcd V = X;
    Eigen::MatrixXcd F = X;
    double drive = U.norm();
    if (r_.disturbance > 0.0) D *= r_.disturbance * drive / D.norm();
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
      X.row(k) = x.transpose();
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
      const double mean = x.col(i).mean() / sx;  // small motion is about the mean position
      stiffness_at_mean_(i, i) += K_(i, i) * (3.0 * r_.hardening * mean * mean + 0.5 * r_.position * mean);
      for (Eigen::Index t = 0; t < f.rows(); ++t) {
        const double share = static_cast<double>(t) / static_cast<double>(f.rows());
        const double p = x(t, i) / sx;
        const double q = v(t, i) / sv;
        f(t, i) += r_.friction * size * std::tanh(50.0 * q) + r_.hardening * K_(i, i) * sx * p * p * p +
                   r_.drag * B_(i, i) * sv * q * std::abs(q) + 0.25 * r_.position * K_(i, i) * sx * p * p +
                   r_.wander * K_(i, i) * x(t, i) * std::sin(kTau * share + phase);
      }
    }
  }

  /// What recording does.
  void spoil(Eigen::MatrixXd& x, Eigen::MatrixXd& f) {
    for (int i = 0; i < r_.axes; ++i) {
      const double size = rms(f, i);
      const double step = r_.step_x * rms(x, i);
      const double phase = uniform(0.0, kTau);
      const Eigen::VectorXd slow = f.col(i);
      for (Eigen::Index t = 0; t < f.rows(); ++t) {
        const double share = static_cast<double>(t) / static_cast<double>(f.rows());
        f(t, i) += r_.drift * size * (std::sin(kTau * share + phase) + 2.0 * share);
        if (r_.clip > 0.0) f(t, i) = std::clamp(f(t, i), -r_.clip * size, r_.clip * size);
        if (step > 0.0) x(t, i) = step * std::round(x(t, i) / step);
        if (r_.held > 1) {
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
