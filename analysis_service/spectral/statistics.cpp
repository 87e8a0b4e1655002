#include "analysis_service/spectral/statistics.hpp"

#include <boost/math/distributions/fisher_f.hpp>
#include <boost/math/distributions/students_t.hpp>

namespace tonus::spectral {

double student_t_quantile(double probability, double freedom) {
  return boost::math::quantile(boost::math::students_t(freedom), probability);
}

double fisher_quantile(double probability, double freedom, double freedom_below) {
  return boost::math::quantile(boost::math::fisher_f(freedom, freedom_below), probability);
}

}  // namespace tonus::spectral
