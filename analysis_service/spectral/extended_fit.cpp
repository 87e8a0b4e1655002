#include "analysis_service/spectral/extended_fit.hpp"

#include <algorithm>
#include <cmath>
#include <complex>
#include <numbers>
#include <numeric>

#include "analysis_service/spectral/motion_estimate.hpp"
#include "analysis_service/spectral/nonlinear_terms.hpp"
#include "analysis_service/spectral/term_regression.hpp"

namespace tonus::spectral {
namespace {

constexpr int kMostTurns = 30;
constexpr int kFreeTurns = 3;      // after which coefficients are means over the turns
constexpr double kSettled = 0.25;  // of a standard error
/// The addition's effect on M, B, K is known to this share of itself, as x^ is.
constexpr double kEffectKnown = 0.005;

/// Coefficients of the addition, SI, with what the jackknife over blocks says of them. Row i: force axis i.
/// Columns: the functions of its own motion; or stiffness and damping of a reflex by motion axis.
struct Coefficients {
  Eigen::MatrixXd value;
  Eigen::MatrixXd error;
  double delay = 0.5 * (kShortestReflex + kLongestReflex);  // s
  double delay_error = 0.0;
};

template <int N>
class Turns {
 public:
  Turns(std::span<const Record> records, const SegmentFit<N>& linear, Addition addition,
        const FitSettings& settings)
      : records_(records),
        addition_(addition),
        settings_(settings),
        length_(linear.length),
        linear_(linear.p.cwiseProduct(linear.unit)) {
    lead_ = lag_of(linear);
    settings_.is_lag_known = true;
    settings_.start = start_from(linear);
    settings_.range = {0.999 * linear.w[0] / kTau, 1.001 * linear.w[linear.w.size() - 1] / kTau};
    if (addition == Addition::kFriction) terms_ = {Term::kFriction};
    if (addition == Addition::kCubic) terms_ = {Term::kPosition, Term::kHardening};
    const int columns = addition == Addition::kReflex ? 2 * N : static_cast<int>(terms_.size());
    now_.value = now_.error = Eigen::MatrixXd::Zero(N, columns);
    align();
  }

  std::optional<ExtendedFit<N>> run() {
    for (int turn = 0; turn < kMostTurns; ++turn) {
      auto fit = fit_segments<N>(corrected_, length_, settings_, lead_);
      if (!fit || !fit->p.allFinite() || !fit->covariance.allFinite()) return std::nullopt;
      settings_.start = start_from(*fit);
      const Coefficients before = now_;
      regress(*fit);
      if (!now_.value.allFinite() || !now_.error.allFinite()) return std::nullopt;
      if (addition_ == Addition::kFriction && turn >= kFreeTurns) {
        // sign(x'^) flips with the smallest change of x^, so that the coefficient wavers about its value.
        now_.value = before.value + (now_.value - before.value) / (turn - kFreeTurns + 2.0);
      }
      if (turn > 0 && is_settled(before)) return result(std::move(*fit));
      const Eigen::VectorXd lag = lag_of(*fit);
      if ((lag - lead_).cwiseAbs().maxCoeff() > 0.1 * records_.front().sample_period) {
        lead_ = lag;
        align();
      }
      correct(*fit);
    }
    return std::nullopt;
  }

 private:
  static constexpr double kTau = 2.0 * std::numbers::pi;

  static Eigen::VectorXd lag_of(const SegmentFit<N>& fit) {
    return fit.lead + fit.p.segment(Likelihood<N>::kImpedance, N) / fit.w_unit;
  }

  [[nodiscard]] bool is_settled(const Coefficients& before) const {
    const bool is_delay_settled =
        addition_ != Addition::kReflex ||
        std::abs(now_.delay - before.delay) <= std::max(kSettled * now_.delay_error, 1e-6);
    return is_delay_settled &&
           ((now_.value - before.value).array().abs() <= kSettled * now_.error.array()).all();
  }

  void align() {
    aligned_.clear();
    for (const Record& record : records_) aligned_.push_back(with_force_advanced(record, lead_));
    corrected_ = aligned_;
  }

  /// The force without what the addition makes of x^.
  void correct(const SegmentFit<N>& fit) {
    std::vector<Eigen::MatrixXd> forces;
    for (std::size_t r = 0; r < aligned_.size(); ++r) {
      const double delay = addition_ == Addition::kReflex ? now_.delay : 0.0;
      const MotionEstimate motion = motion_estimate<N>(corrected_[r], fit, delay, true);
      Eigen::MatrixXd force = aligned_[r].force;
      if (addition_ == Addition::kReflex) {
        force -= motion.position * now_.value.leftCols(N).transpose() +
                 motion.velocity * now_.value.rightCols(N).transpose();
      } else {
        for (int i = 0; i < N; ++i) {
          for (std::size_t n = 0; n < terms_.size(); ++n) {
            const double c = now_.value(i, static_cast<Eigen::Index>(n));
            for (Eigen::Index t = 0; t < force.rows(); ++t)
              force(t, i) -= c * value_of(terms_[n], motion.position(t, i), motion.velocity(t, i));
          }
        }
      }
      forces.push_back(std::move(force));
    }
    for (std::size_t r = 0; r < aligned_.size(); ++r) corrected_[r].force = std::move(forces[r]);
  }

  /// New coefficients; `fit` was made from the force without the old ones.
  void regress(const SegmentFit<N>& fit) {
    std::vector<MotionEstimate> motions;
    std::vector<Record> estimated;
    for (const Record& record : corrected_) {
      motions.push_back(motion_estimate<N>(record, fit, 0.0, true));
      estimated.push_back({record.sample_period, motions.back().position, record.force, {}});
    }
    const Bins range{fit.bins.front(), fit.bins.back() + 1};
    const auto motion = windowed_spectra(estimated, fit.segments, fit.length, range);
    variance_ = Eigen::VectorXd::Zero(Likelihood<N>::kStructural);
    gain_ = 0.0;
    if (addition_ == Addition::kReflex && now_.value.isZero(0.0)) {
      scan_reflex(fit, motion, range.first);
    } else if (addition_ == Addition::kReflex) {
      regress_reflex(fit, motion, range);
    } else {
      regress_function(fit, motions, motion, range.first);
    }
  }

  void regress_function(const SegmentFit<N>& fit, const std::vector<MotionEstimate>& motions,
                        const std::vector<Eigen::MatrixXcd>& motion, Eigen::Index first_bin) {
    const auto count = static_cast<int>(terms_.size());
    Eigen::Array<double, N, 1> x = Eigen::Array<double, N, 1>::Zero();
    Eigen::Array<double, N, 1> v = x;
    double rows = 0.0;
    for (const MotionEstimate& m : motions) {
      x += m.position.colwise().squaredNorm().transpose().array();
      v += m.velocity.colwise().squaredNorm().transpose().array();
      rows += static_cast<double>(m.position.rows());
    }
    x = (x / rows).sqrt();
    v = (v / rows).sqrt();
    std::vector<Eigen::MatrixXd> signals;
    for (const MotionEstimate& m : motions) {
      Eigen::MatrixXd values(m.position.rows(), count * N);
      for (int n = 0; n < count; ++n) {
        for (int i = 0; i < N; ++i) {
          for (Eigen::Index t = 0; t < values.rows(); ++t)
            values(t, n * N + i) = value_of(terms_[static_cast<std::size_t>(n)], m.position(t, i) / x[i],
                                            m.velocity(t, i) / v[i]);
        }
      }
      signals.push_back(std::move(values));
    }
    const auto spectra = windowed_spectra(signals, fit.segments, fit.length, fit.bins);
    for (int i = 0; i < N; ++i) {
      const auto unit = [&](int n) {
        return unit_of(terms_[static_cast<std::size_t>(n)], fit.force_unit[i], x[i], v[i]);
      };
      Eigen::VectorXd removed = Eigen::VectorXd::Zero(count * N);
      std::vector<int> own;
      for (int n = 0; n < count; ++n) {
        own.push_back(n * N + i);
        removed[n * N + i] = now_.value(i, n) / unit(n);
      }
      const auto regression = TermRegression::make(fit, i, motion, first_bin, spectra, removed);
      const auto solution = regression.solve(own);
      const Eigen::VectorXd error = TermRegression::standard_errors(solution.without_block);
      for (int n = 0; n < count; ++n) {
        now_.value(i, n) = solution.theta[regression.linear_columns() + n] * unit(n);
        now_.error(i, n) = error[regression.linear_columns() + n] * unit(n);
      }
      take_variance(i, error);
      gain_ += solution.reduction;
    }
  }

  void take_variance(int i, const Eigen::VectorXd& error) {
    for (int part = 0; part < 3; ++part) {
      for (int c = 0; c < N; ++c)
        variance_[part * N * N + i * N + c] = error[part * N + c] * error[part * N + c];
    }
    variance_[Likelihood<N>::kImpedance + i] = error[3 * N] * error[3 * N];
  }

  /// First turn: the delay on a grid, where columns turned by exp(-jw delay) do.
  void scan_reflex(const SegmentFit<N>& fit, const std::vector<Eigen::MatrixXcd>& motion,
                   Eigen::Index first_bin) {
    const double top = fit.w[fit.w.size() - 1] / kTau;
    const double step = std::clamp(0.1 / top, 0.001, 0.005);
    const auto count = static_cast<Eigen::Index>(std::ceil((kLongestReflex - kShortestReflex) / step)) + 1;
    const auto delays = Eigen::VectorXd::LinSpaced(count, kShortestReflex, kLongestReflex).eval();
    std::vector<int> all(2 * N);
    std::iota(all.begin(), all.end(), 0);
    double best = -1.0;
    for (const double delay : delays) {
      std::vector<Eigen::MatrixXcd> columns;
      for (const Eigen::MatrixXcd& of_segment : motion) {
        Eigen::MatrixXcd turned(2 * N, fit.w.size());
        for (Eigen::Index k = 0; k < fit.w.size(); ++k) {
          const Eigen::Index at = fit.bins[static_cast<std::size_t>(k)] - first_bin;
          const auto phase = std::polar(1.0, -fit.w[k] * delay);
          for (int j = 0; j < N; ++j) {
            turned(j, k) = phase * of_segment(3 * N + j, at) / fit.displacement_unit[j];
            turned(N + j, k) = phase * of_segment(2 * N + j, at) / (fit.displacement_unit[j] * fit.w_unit);
          }
        }
        columns.push_back(std::move(turned));
      }
      double explained = 0.0;
      Eigen::MatrixXd value(N, 2 * N);
      for (int i = 0; i < N; ++i) {
        const auto regression =
            TermRegression::make(fit, i, motion, first_bin, columns, Eigen::VectorXd::Zero(2 * N));
        const auto solution = regression.solve(all);
        explained += solution.explained;
        for (int j = 0; j < N; ++j) {
          const double unit = fit.force_unit[i] / fit.displacement_unit[j];
          value(i, j) = solution.theta[regression.linear_columns() + j] * unit;
          value(i, N + j) = solution.theta[regression.linear_columns() + N + j] * unit / fit.w_unit;
        }
      }
      if (explained <= best) continue;
      best = explained;
      now_.value = value;
      now_.delay = delay;
    }
    now_.error.setZero();
  }

  /// Spectra of x^ and its rate, `delay` s late, scaled: 2 N rows.
  [[nodiscard]] std::vector<Eigen::MatrixXcd> late_columns(const SegmentFit<N>& fit, const Bins& range,
                                                           double delay) const {
    std::vector<Record> late;
    for (const Record& record : corrected_)
      late.push_back(
          {record.sample_period, motion_estimate<N>(record, fit, delay, true).position, record.force, {}});
    std::vector<Eigen::MatrixXcd> columns;
    for (const Eigen::MatrixXcd& of_segment : windowed_spectra(late, fit.segments, fit.length, range)) {
      Eigen::MatrixXcd values(2 * N, fit.w.size());
      for (Eigen::Index k = 0; k < fit.w.size(); ++k) {
        const Eigen::Index at = fit.bins[static_cast<std::size_t>(k)] - range.first;
        for (int j = 0; j < N; ++j) {
          values(j, k) = of_segment(3 * N + j, at) / fit.displacement_unit[j];
          values(N + j, k) = of_segment(2 * N + j, at) / (fit.displacement_unit[j] * fit.w_unit);
        }
      }
      columns.push_back(std::move(values));
    }
    return columns;
  }

  /// Where values at equal steps peak, by the parabola through the highest and its neighbours.
  struct Peak {
    Eigen::Index at = 0;
    double way = 0.0;  ///< From it, in steps.

    explicit Peak(const Eigen::VectorXd& values) {
      values.maxCoeff(&at);
      at = std::clamp<Eigen::Index>(at, 1, values.size() - 2);
      const double curvature = values[at - 1] - 2.0 * values[at] + values[at + 1];
      const double slope = 0.5 * (values[at + 1] - values[at - 1]);
      way = curvature < 0.0 ? std::clamp(-slope / curvature, -1.5, 1.5) : std::copysign(1.5, slope);
    }
    [[nodiscard]] double position() const { return static_cast<double>(at) + way; }
    /// Parabola through three values at `way`.
    template <typename Value>
    [[nodiscard]] Eigen::VectorXd between(const Value& value) const {
      return 0.5 * way * (way - 1.0) * value(at - 1) + (1.0 - way * way) * value(at) +
             0.5 * way * (way + 1.0) * value(at + 1);
    }
  };

  /// Further turns: the delay by the parabola through what five of them explain. (A derivative with respect
  /// to the delay would be the damping's column over again.)
  void regress_reflex(const SegmentFit<N>& fit, const std::vector<Eigen::MatrixXcd>& motion,
                      const Bins& range) {
    constexpr Eigen::Index kTried = 5;
    constexpr double kStep = 0.002;  // s
    const double first_delay = std::clamp(now_.delay - 0.5 * (kTried - 1) * kStep, kShortestReflex - kStep,
                                          kLongestReflex - (kTried - 2) * kStep);
    const auto old = late_columns(fit, range, now_.delay);
    std::vector<int> all(2 * N);
    std::iota(all.begin(), all.end(), 0);
    std::vector<std::vector<TermRegression::Solution>> of_axis(N);  // by delay
    Eigen::VectorXd explained = Eigen::VectorXd::Zero(kTried);
    Eigen::MatrixXd without = Eigen::MatrixXd::Zero(kTried, fit.blocks());
    for (Eigen::Index d = 0; d < kTried; ++d) {
      auto columns = late_columns(fit, range, first_delay + kStep * static_cast<double>(d));
      for (std::size_t s = 0; s < columns.size(); ++s) {
        columns[s].conservativeResize(4 * N, Eigen::NoChange);
        columns[s].bottomRows(2 * N) = old[s];
      }
      for (int i = 0; i < N; ++i) {
        Eigen::VectorXd removed = Eigen::VectorXd::Zero(4 * N);
        for (int j = 0; j < N; ++j) {
          const double unit = fit.force_unit[i] / fit.displacement_unit[j];
          removed[2 * N + j] = now_.value(i, j) / unit;
          removed[3 * N + j] = now_.value(i, N + j) * fit.w_unit / unit;
        }
        const auto regression = TermRegression::make(fit, i, motion, range.first, columns, removed);
        of_axis[static_cast<std::size_t>(i)].push_back(regression.solve(all));
        const auto& solution = of_axis[static_cast<std::size_t>(i)].back();
        explained[d] += solution.explained;
        without.row(d) += solution.explained_without_block.transpose();
      }
    }
    const Peak best(explained);
    std::vector<Peak> best_without;
    Eigen::MatrixXd delay_without(1, fit.blocks());
    for (int b = 0; b < fit.blocks(); ++b) {
      best_without.emplace_back(without.col(b));
      delay_without(0, b) = kStep * best_without.back().position();
    }
    now_.delay = std::clamp(first_delay + kStep * best.position(), kShortestReflex, kLongestReflex);
    now_.delay_error = TermRegression::standard_errors(delay_without)[0];
    for (int i = 0; i < N; ++i) {
      const auto at = [&](Eigen::Index d) -> const TermRegression::Solution& {
        return of_axis[static_cast<std::size_t>(i)][static_cast<std::size_t>(d)];
      };
      const Eigen::VectorXd theta = best.between([&](Eigen::Index d) { return at(d).theta; });
      Eigen::MatrixXd theta_without(theta.size(), fit.blocks());
      for (int b = 0; b < fit.blocks(); ++b)
        theta_without.col(b) = best_without[static_cast<std::size_t>(b)].between(
            [&](Eigen::Index d) { return Eigen::VectorXd(at(d).without_block.col(b)); });
      const Eigen::VectorXd error = TermRegression::standard_errors(theta_without);
      for (int j = 0; j < N; ++j) {
        const double unit = fit.force_unit[i] / fit.displacement_unit[j];
        const int x = 3 * N + 1 + j;
        now_.value(i, j) = theta[x] * unit;
        now_.error(i, j) = error[x] * unit;
        now_.value(i, N + j) = theta[x + N] * unit / fit.w_unit;
        now_.error(i, N + j) = error[x + N] * unit / fit.w_unit;
      }
      take_variance(i, error);
      gain_ += at(best.at).reduction;
    }
  }

  static Parameter::Kind kind_of(Term term) {
    if (term == Term::kFriction) return Parameter::Kind::kFriction;
    return term == Term::kPosition ? Parameter::Kind::kQuadratic : Parameter::Kind::kCubic;
  }

  [[nodiscard]] ExtendedFit<N> result(SegmentFit<N> fit) const {
    ExtendedFit<N> extended{std::move(fit), corrected_, {}, variance_, 0.0, 0.0};
    const auto effect = (linear_.cwiseQuotient(extended.fit.unit) - extended.fit.p)
                            .template head<Likelihood<N>::kImpedance>()
                            .cwiseAbs()
                            .maxCoeff();
    extended.variance.head(Likelihood<N>::kImpedance).array() += std::pow(kEffectKnown * effect, 2);
    constexpr double kCorrelated = kOverlap * kBinCorrelation;
    extended.gain = gain_ / kCorrelated;
    extended.data = 2.0 * N * static_cast<double>(extended.fit.segments.size()) *
                    static_cast<double>(extended.fit.bins.size()) / kCorrelated;
    using Kind = Parameter::Kind;
    for (int i = 0; i < N; ++i) {
      if (addition_ != Addition::kReflex) {
        for (std::size_t n = 0; n < terms_.size(); ++n) {
          const auto at = static_cast<Eigen::Index>(n);
          extended.parameters.push_back({kind_of(terms_[n]), i, i, now_.value(i, at), now_.error(i, at)});
        }
        continue;
      }
      for (const Kind kind : {Kind::kReflexStiffness, Kind::kReflexDamping}) {
        const int first = kind == Kind::kReflexStiffness ? 0 : N;
        for (int j = 0; j < N; ++j)
          extended.parameters.push_back({kind, i, j, now_.value(i, first + j), now_.error(i, first + j)});
      }
    }
    if (addition_ == Addition::kReflex)
      extended.parameters.push_back({Kind::kReflexDelay, 0, 0, now_.delay, now_.delay_error});
    return extended;
  }

  std::span<const Record> records_;
  Addition addition_;
  std::vector<Term> terms_;  ///< Functions of motion; none of a reflex.
  FitSettings settings_;
  Eigen::Index length_;
  typename Likelihood<N>::Vector linear_;  ///< Parameters without the addition, SI.
  Eigen::VectorXd lead_;
  std::vector<Record> aligned_;
  std::vector<Record> corrected_;
  Coefficients now_;
  Eigen::VectorXd variance_;
  double gain_ = 0.0;
};

}  // namespace

template <int N>
std::optional<ExtendedFit<N>> fit_extended(std::span<const Record> records, const SegmentFit<N>& linear,
                                           Addition addition, const FitSettings& settings) {
  return Turns<N>(records, linear, addition, settings).run();
}

template std::optional<ExtendedFit<1>> fit_extended<1>(std::span<const Record>, const SegmentFit<1>&,
                                                       Addition, const FitSettings&);
template std::optional<ExtendedFit<2>> fit_extended<2>(std::span<const Record>, const SegmentFit<2>&,
                                                       Addition, const FitSettings&);

}  // namespace tonus::spectral
