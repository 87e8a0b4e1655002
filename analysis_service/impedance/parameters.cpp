#include "analysis_service/impedance/parameters.hpp"

#include <Eigen/LU>

namespace tonus::impedance {

Parameters parameters_from(const Eigen::MatrixXd& theta, int axes) {
  const Eigen::Index terms = theta.rows() - Eigen::Index{2} * axes - 1;
  Parameters p;
  p.M = theta.topRows(axes).transpose();
  p.B = theta.middleRows(axes, terms).transpose();
  p.K = theta.middleRows(axes + terms, axes).transpose();
  const AxisVector c = theta.row(theta.rows() - 1).transpose();
  if (axes == 1) {
    p.X0 = -c / p.K(0, 0);
  } else {
    p.X0 = -(Eigen::Matrix2d(p.K).inverse() * Eigen::Vector2d(c));
  }
  return p;
}

Eigen::VectorXd flatten(const Parameters& p) {
  Eigen::VectorXd elements(p.M.size() + p.B.size() + p.K.size() + p.X0.size());
  elements << p.M.reshaped(), p.B.reshaped(), p.K.reshaped(), p.X0;
  return elements;
}

Parameters unflatten(const Eigen::VectorXd& elements, const Parameters& like) {
  Parameters p = like;
  Eigen::Index at = 0;
  for (AxisMatrix* matrix : {&p.M, &p.B, &p.K}) {
    matrix->reshaped() = elements.segment(at, matrix->size());
    at += matrix->size();
  }
  p.X0 = elements.segment(at, p.X0.size());
  return p;
}

double largest_element(const AxisMatrix& matrix) {
  return matrix.size() > 0 ? matrix.cwiseAbs().maxCoeff() : 0.0;
}

}  // namespace tonus::impedance
