#include "services/verification/estimate_difference.hpp"

#include <algorithm>
#include <bit>
#include <cmath>
#include <cstdint>
#include <limits>
#include <span>
#include <spdlog/fmt/fmt.h>

namespace tonus::verification {
namespace {

bool is_same(double a, double b) {
  return std::bit_cast<std::uint64_t>(a) == std::bit_cast<std::uint64_t>(b);
}

class Comparison {
 public:
  /// Elements of one quantity; differences are shares of its largest.
  void compare(const std::string& name, std::span<const double> a, std::span<const double> b,
               bool is_matrix) {
    double largest = 0.0;
    for (const double value : a) largest = std::max(largest, std::abs(value));
    for (std::size_t i = 0; i < a.size(); ++i) {
      if (is_same(a[i], b[i])) continue;
      const double share =
          largest > 0.0 ? std::abs(a[i] - b[i]) / largest : std::numeric_limits<double>::infinity();
      std::string place = name;
      if (is_matrix)
        place += fmt::format("({},{})", i / 2 + 1, i % 2 + 1);
      else if (a.size() > 1)
        place += fmt::format("({})", i + 1);
      note(place, std::isfinite(share) ? share : std::numeric_limits<double>::infinity());
    }
  }

  void compare(const std::string& name, const v1::MatrixEstimate& a, const v1::MatrixEstimate& b) {
    compare(name, a.value(), b.value(), true);
    compare("standard error of " + name, a.standard_error(), b.standard_error(), true);
    compare("interval of " + name, a.low95(), b.low95(), true);
    compare("interval of " + name, a.high95(), b.high95(), true);
  }

  void compare(const std::string& name, double a, double b) {
    compare(name, std::span(&a, 1), std::span(&b, 1), false);
  }

  void require(bool is_so, const std::string& name) {
    if (!is_so) note(name, std::numeric_limits<double>::infinity());
  }

  [[nodiscard]] EstimateDifference take() && { return std::move(found_); }

 private:
  void note(const std::string& place, double share) {
    const bool is_first = found_.is_equal;
    found_.is_equal = false;
    if (!is_first && share <= found_.largest) return;
    found_.largest = share;
    found_.where = place;
  }

  EstimateDifference found_;
};

}  // namespace

EstimateDifference difference_of(const v1::Estimate& a, const v1::Estimate& b) {
  Comparison c;
  c.compare("M", a.mass_kg(), b.mass_kg());
  c.compare("B", a.damping_Ns_per_m(), b.damping_Ns_per_m());
  c.compare("K", a.stiffness_N_per_m(), b.stiffness_N_per_m());
  c.compare("spring centre", a.spring_centre_m().value(), b.spring_centre_m().value(), false);
  c.compare("standard error of spring centre", a.spring_centre_m().standard_error(),
            b.spring_centre_m().standard_error(), false);
  c.compare("sigma", a.sigma_N(), b.sigma_N(), false);
  c.compare("condition_number", a.condition_number(), b.condition_number());
  c.compare("degrees_of_freedom", a.degrees_of_freedom(), b.degrees_of_freedom());
  c.compare("natural_frequency", a.natural_frequency_Hz(), b.natural_frequency_Hz());
  c.compare("damping_ratio", a.damping_ratio(), b.damping_ratio());
  c.compare("cutoff", a.cutoff_Hz(), b.cutoff_Hz());
  c.compare("window", a.window_s(), b.window_s());
  c.compare("band_low", a.band_low_Hz(), b.band_low_Hz());
  c.compare("band_high", a.band_high_Hz(), b.band_high_Hz());
  c.require(a.samples() == b.samples(), "samples");
  c.require(a.trials_used() == b.trials_used(), "trials_used");
  c.require(a.status() == b.status(), "status");
  return std::move(c).take();
}

}  // namespace tonus::verification
