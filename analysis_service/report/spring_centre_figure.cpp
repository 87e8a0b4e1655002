#include "analysis_service/report/spring_centre_figure.hpp"

#include <Eigen/Core>
#include <spdlog/fmt/fmt.h>

#include "analysis_service/impedance/static_stiffness.hpp"
#include "analysis_service/report/loaded_table.hpp"

namespace tonus::report {

std::optional<Figure> spring_centre_figure(const study::Subject& subject) {
  constexpr double kEnlarged = 12.0;  // times, of the vectors
  std::size_t resting = 0;
  std::size_t sets = 0;
  std::string predicted;
  std::string actual;
  std::string places;
  const auto arrow = [&](const Eigen::Vector2d& from, const Eigen::Vector2d& centre) {
    const Eigen::Vector2d to = kEnlarged * centre;
    return fmt::format("{:.5f} {:.5f} {:.5f} {:.5f}\n", from.x(), from.y(), to.x(), to.y());
  };
  for (const study::LoadedPosture& posture : loaded_of(subject)) {
    for (const study::LoadedSet& set : posture.sets) {
      const study::ConditionAnalysis& own = condition_of(subject, posture, set);
      const Eigen::Vector2d& place = own.condition.position;
      const auto still = impedance::static_stiffness(own.trials, study::static_options());
      ++sets;
      if (still) ++resting;
      predicted += arrow(place, set.predicted);
      actual += arrow(place, still ? Eigen::Vector2d(still->X0) : set.actual);
      places += fmt::format("{:.5f} {:.5f}\n", place.x(), place.y());
    }
  }
  if (predicted.empty()) return std::nullopt;
  return Figure{
      "figure10",
      "Fig. 10. Spring centres under bias forces, predicted and actual",
      fmt::format(
          "Subject {}. Vectors from the posture to the spring centre, enlarged {:g} times; the bar is 5 mm. "
          "Predicted: -K^-1 F_bias with the unloaded stiffness (20). Actual: from the static points (19) "
          "in {} of {} sets{}.",
          subject.name, kEnlarged, resting, sets,
          resting < sets ? ", from the set's own fit in the others, where too few trials came to rest" : ""),
      13.0,
      16.0,
      {{"figure10.dat",
        "# from x, from y (m), vector x, vector y (m, enlarged); blocks: predicted, actual, postures\n" +
            predicted + "\n\n" + actual + "\n\n" + places}},
      fmt::format("set size ratio -1\nset xlabel 'x from the shoulder (m)'\nset ylabel 'y (m)'\nset xrange "
                  "[-0.22:0.22]\n"
                  "set yrange [0.1:0.68]\nset xtics 0.1\nset key top right vertical samplen 3\n"
                  "set arrow 1 from -0.2,0.13 to {:.4f},0.13 heads size screen 0.005,90 lw 1.5\n"
                  "set label 1 '5 mm' at {:.4f},0.145 center\n"
                  "plot 'figure10.dat' index 0 with vectors lw 4 lc rgb '#b0b0b0' title 'predicted', "
                  "'' index 1 with vectors lw 1.2 lc rgb 'black' title 'actual', "
                  "'' index 2 with points pt 7 ps 0.5 lc rgb 'black' title 'posture'\n",
                  -0.2 + 0.005 * kEnlarged, -0.2 + 0.0025 * kEnlarged)};
}

}  // namespace tonus::report
