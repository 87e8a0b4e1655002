#include "analysis_service/impedance/modulation.hpp"

#include "analysis_service/impedance/ellipse.hpp"

namespace tonus::impedance {

std::optional<Modulation> modulation(const Eigen::Matrix2d& changed, const Eigen::Matrix2d& reference) {
  const auto now = ellipse_of(changed);
  const auto before = ellipse_of(reference);
  if (!now || !before) return std::nullopt;
  Modulation m;
  m.size_ratio = now->size / before->size;
  m.shape_ratio = now->shape / before->shape;
  m.has_rotation = !now->is_circle && !before->is_circle;
  if (m.has_rotation) m.rotation = rotation_between(before->orientation, now->orientation);
  return m;
}

}  // namespace tonus::impedance
