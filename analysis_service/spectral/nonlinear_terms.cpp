#include "analysis_service/spectral/nonlinear_terms.hpp"

#include <algorithm>
#include <cmath>

#include "analysis_service/spectral/motion_estimate.hpp"
#include "analysis_service/spectral/term_regression.hpp"

namespace tonus::spectral {
namespace {

/// A term at a delay.
struct Tested {
  Term term = Term::kFriction;
  double delay = 0.0;  // s
};

std::vector<Tested> tested_terms() {
  std::vector<Tested> all{{Term::kFriction}, {Term::kHardening}, {Term::kDrag}, {Term::kPosition}};
  for (const double delay : kReflexDelays) all.push_back({Term::kReflex, delay});
  return all;
}

/// x^ of all records and its root mean squares by axis.
struct Motions {
  std::vector<MotionEstimate> of_record;
  Eigen::ArrayXd position;
  Eigen::ArrayXd velocity;
};

template <int N>
Motions motions_of(std::span<const Record> records, const SegmentFit<N>& fit) {
  Motions motions;
  motions.position = motions.velocity = Eigen::ArrayXd::Zero(N);
  double rows = 0.0;
  for (const Record& record : records) {
    motions.of_record.push_back(motion_estimate<N>(record, fit));
    const MotionEstimate& motion = motions.of_record.back();
    motions.position += motion.position.colwise().squaredNorm().transpose().array();
    motions.velocity += motion.velocity.colwise().squaredNorm().transpose().array();
    rows += static_cast<double>(record.samples());
  }
  motions.position = (motions.position / rows).sqrt();
  motions.velocity = (motions.velocity / rows).sqrt();
  return motions;
}

/// Spectra of every term of every axis at the fitted bins: by segment, row n N + j. A reflex is x^ turned by
/// its delay, which is exact for one that is small against the segment.
template <int N>
std::vector<Eigen::MatrixXcd> term_spectra(const std::vector<Tested>& tested, const Motions& motions,
                                           const SegmentFit<N>& fit, std::span<const Eigen::MatrixXcd> motion,
                                           Eigen::Index first_bin) {
  const auto functions =
      std::ranges::count_if(tested, [](const Tested& one) { return one.term != Term::kReflex; });
  std::vector<Eigen::MatrixXd> signals;
  for (const MotionEstimate& of_record : motions.of_record) {
    Eigen::MatrixXd values(of_record.position.rows(), functions * N);
    for (Eigen::Index t = 0; t < values.rows(); ++t) {
      for (int j = 0; j < N; ++j) {
        const double x = of_record.position(t, j) / motions.position[j];
        const double v = of_record.velocity(t, j) / motions.velocity[j];
        for (Eigen::Index n = 0; n < functions; ++n)
          values(t, n * N + j) = value_of(tested[static_cast<std::size_t>(n)].term, x, v);
      }
    }
    signals.push_back(std::move(values));
  }
  auto spectra = windowed_spectra(signals, fit.segments, fit.length, fit.bins);
  const auto all = static_cast<Eigen::Index>(tested.size()) * N;
  for (std::size_t s = 0; s < spectra.size(); ++s) {
    spectra[s].conservativeResize(all, Eigen::NoChange);
    for (Eigen::Index k = 0; k < fit.w.size(); ++k) {
      const Eigen::Index at = fit.bins[static_cast<std::size_t>(k)] - first_bin;
      for (auto n = static_cast<Eigen::Index>(functions); n < std::ssize(tested); ++n) {
        const auto turned = std::polar(1.0, -fit.w[k] * tested[static_cast<std::size_t>(n)].delay);
        for (int j = 0; j < N; ++j)
          spectra[s](n * N + j, k) = turned * motion[s](3 * N + j, at) / motions.position[j];
      }
    }
  }
  return spectra;
}

}  // namespace

double value_of(Term term, double position, double velocity) {
  switch (term) {
    case Term::kFriction:
      return velocity > 0.0 ? 1.0 : velocity < 0.0 ? -1.0 : 0.0;
    case Term::kHardening:
      return position * position * position;
    case Term::kDrag:
      return velocity * std::abs(velocity);
    case Term::kPosition:
      return position * position;
    case Term::kReflex:
      return position;
  }
  return 0.0;
}

double unit_of(Term term, double force, double position, double velocity) {
  switch (term) {
    case Term::kFriction:
      return force;
    case Term::kHardening:
      return force / (position * position * position);
    case Term::kDrag:
      return force / (velocity * velocity);
    case Term::kPosition:
      return force / (position * position);
    case Term::kReflex:
      return force / position;
  }
  return force;
}

template <int N>
std::vector<TermFit> fit_terms(std::span<const Record> records, const SegmentFit<N>& fit) {
  const std::vector<Tested> tested = tested_terms();
  const Motions motions = motions_of<N>(records, fit);
  std::vector<Record> estimated;  // x^ through the same windows
  for (std::size_t r = 0; r < records.size(); ++r)
    estimated.push_back({records[r].sample_period, motions.of_record[r].position, records[r].force, {}});
  const Bins range{fit.bins.front(), fit.bins.back() + 1};
  const auto motion = windowed_spectra(estimated, fit.segments, fit.length, range);
  const auto spectra = term_spectra<N>(tested, motions, fit, motion, range.first);
  const Eigen::VectorXd none = Eigen::VectorXd::Zero(static_cast<Eigen::Index>(tested.size()) * N);

  std::vector<TermFit> found;
  for (int i = 0; i < N; ++i) {
    const auto regression = TermRegression::make(fit, i, motion, range.first, spectra, none);
    for (std::size_t n = 0; n < tested.size(); ++n) {
      for (int j = 0; j < N; ++j) {
        const int column = static_cast<int>(n) * N + j;
        const auto solution = regression.solve({&column, 1});
        const Eigen::VectorXd error = TermRegression::standard_errors(solution.without_block);
        const int at = regression.linear_columns();
        TermFit term;
        term.term = tested[n].term;
        term.delay = tested[n].delay;
        term.force_axis = i;
        term.motion_axis = j;
        const double unit = unit_of(term.term, fit.force_unit[i], motions.position[j], motions.velocity[j]);
        term.coefficient = solution.theta[at] * unit;
        term.standard_error = error[at] * unit;
        term.t = solution.theta[at] / std::max(error[at], 1e-300);
        term.share = regression.share(column, solution.theta[at]);
        for (int part = 0; part < 3; ++part) {
          for (int c = 0; c < N; ++c) {
            const double shift = solution.theta[part * N + c] - regression.plain()[part * N + c];
            term.change =
                std::max(term.change, std::abs(shift) / fit.largest_beside(part * N * N + i * N + c));
          }
        }
        if (term.term == Term::kPosition) {
          const double stiffness = fit.largest_beside(2 * N * N) * fit.unit[2 * N * N + i * N + j];
          term.stiffness_change = std::abs(4.0 * term.coefficient * motions.position[j] / stiffness);
        }
        found.push_back(term);
      }
    }
  }
  return found;
}

template std::vector<TermFit> fit_terms<1>(std::span<const Record>, const SegmentFit<1>&);
template std::vector<TermFit> fit_terms<2>(std::span<const Record>, const SegmentFit<2>&);

}  // namespace tonus::spectral
