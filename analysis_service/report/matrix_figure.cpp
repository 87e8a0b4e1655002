#include "analysis_service/report/matrix_figure.hpp"

#include <cmath>
#include <iterator>
#include <numbers>
#include <spdlog/fmt/fmt.h>

#include "analysis_service/impedance/ellipse.hpp"

namespace tonus::report {

std::optional<Figure> matrix_figure(const study::Subject& subject) {
  const auto* estimate =
      subject.unloaded->conditions.empty() ? nullptr : subject.unloaded->conditions.front().find();
  if (estimate == nullptr) return std::nullopt;
  const Eigen::Matrix2d K = impedance::symmetric_part(estimate->value.K);
  const auto ellipse = impedance::ellipse_of(K);
  if (!ellipse) return std::nullopt;
  std::string curve;
  for (int i = 0; i <= 120; ++i) {
    const double angle = 2.0 * std::numbers::pi * i / 120.0;
    const Eigen::Vector2d f = K * Eigen::Vector2d(std::cos(angle), std::sin(angle));
    fmt::format_to(std::back_inserter(curve), "{:.3f} {:.3f}\n", f.x(), f.y());
  }
  const auto axis = [](double angle, double length) {
    return fmt::format("0 0 {:.3f} {:.3f}\n", length * std::cos(angle), length * std::sin(angle));
  };
  constexpr double kOffAxis = 50.0 * std::numbers::pi / 180.0;  // of the displacement that is shown
  const double shown = ellipse->orientation + kOffAxis;
  const Eigen::Vector2d u(std::cos(shown), std::sin(shown));
  const Eigen::Vector2d force = K * u;
  std::string arrows = axis(ellipse->orientation, ellipse->major) +
                       axis(ellipse->orientation + std::numbers::pi / 2.0, ellipse->minor) + "\n\n" +
                       fmt::format("0 0 {:.3f} {:.3f}\n", ellipse->minor * u.x(), ellipse->minor * u.y()) +
                       "\n\n" + fmt::format("0 0 {:.3f} {:.3f}\n", force.x(), force.y());
  return Figure{
      "figure4",
      "Fig. 4. A matrix as an ellipse",
      fmt::format("Stiffness of subject {} at {}: the restoring force for a displacement of 1 m, turned "
                  "through 360 deg. Displacement and force are along one line on the axes only.",
                  subject.name, subject.unloaded->conditions.front().condition.posture),
      14.0,
      12.0,
      {{"figure4-ellipse.dat", "# force x (N/m)  force y (N/m)\n" + curve},
       {"figure4-arrows.dat",
        "# from x, from y, to x, to y (N/m); blocks: axes, direction of a displacement, its force\n" +
            arrows}},
      fmt::format(
          "set size ratio -1\nset xlabel 'x (N/m)'\nset ylabel 'y (N/m)'\nset grid\nset xrange "
          "[-{0:.0f}:{0:.0f}]\n"
          "set yrange [-{0:.0f}:{0:.0f}]\nset key outside bottom center vertical maxrows 2\n"
          "plot 'figure4-ellipse.dat' with lines lw 2 lc rgb 'black' title 'restoring force', "
          "'figure4-arrows.dat' index 0 using 1:2:3:4 with vectors nohead dt 2 lc rgb 'black' title 'axes', "
          "'' index 1 using 1:2:3:4 with vectors lw 2 dt 1 lc rgb '#909090' title 'direction of a "
          "displacement', "
          "'' index 2 using 1:2:3:4 with vectors lw 2 lc rgb 'black' title 'its restoring force'\n",
          1.15 * ellipse->major)};
}

}  // namespace tonus::report
