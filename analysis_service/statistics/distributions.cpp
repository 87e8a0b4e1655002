#include "analysis_service/statistics/distributions.hpp"

#include <boost/math/distributions/chi_squared.hpp>
#include <boost/math/distributions/fisher_f.hpp>
#include <boost/math/distributions/students_t.hpp>

namespace tonus::statistics {

namespace math = boost::math;

double student_t_quantile(double probability, double freedom) {
  return math::quantile(math::students_t(freedom), probability);
}

double student_t_factor(double share, double freedom) {
  return math::quantile(math::complement(math::students_t(freedom), 0.5 * (1.0 - share)));
}

double fisher_quantile(double probability, double freedom, double freedom_below) {
  return math::quantile(math::fisher_f(freedom, freedom_below), probability);
}

double fisher_tail(double ratio, double freedom, double freedom_below) {
  return math::cdf(math::complement(math::fisher_f(freedom, freedom_below), ratio));
}

double chi_squared_tail(double squares, double freedom) {
  return math::cdf(math::complement(math::chi_squared(freedom), squares));
}

}  // namespace tonus::statistics
