#include "analysis_service/report/trace_figures.hpp"

#include <Eigen/Core>
#include <iterator>
#include <spdlog/fmt/fmt.h>

namespace tonus::report {
namespace {

using Matrix = impedance::AxisMatrix;

}  // namespace

std::optional<Figure> perturbation_figure(const study::Subject& subject) {
  const auto& conditions = subject.unloaded->conditions;
  if (conditions.empty() || conditions.front().trials.empty()) return std::nullopt;
  const impedance::Trial& trial = conditions.front().trials.front();
  std::string rows = "# time from onset (s)  x (mm)  y (mm)  force x (N)  force y (N)\n";
  for (Eigen::Index i = 0; i < trial.samples(); ++i) {
    fmt::format_to(std::back_inserter(rows), "{:.3f} {:.4f} {:.4f} {:.4f} {:.4f}\n",
                   static_cast<double>(i - trial.onset) * trial.sample_period, 1e3 * trial.displacement(i, 0),
                   1e3 * trial.displacement(i, 1), trial.force(i, 0), trial.force(i, 1));
  }
  const std::string panel =
      "set ylabel '{}'\nplot 'figure3.dat' using 1:{} with lines lw 1.5 dt 1 lc rgb 'black' title 'x', "
      "'' using 1:{} with lines lw 1.5 dt 2 lc rgb 'black' title 'y'\n";
  return Figure{
      "figure3",
      "Fig. 3. Force and position of one perturbation",
      fmt::format(
          "Subject {}, {}, perturbation {}. Force on the arm, as measured; displacement from the rest "
          "before the onset, in steps of the encoders.",
          subject.name, conditions.front().condition.posture, trial.number),
      16.0,
      12.0,
      {{"figure3.dat", rows}},
      "set multiplot layout 2,1\nset grid\nset lmargin 9\nset rmargin 2\nset offsets 0,0,graph 0.08,graph "
      "0.08\n"
      "set key top right horizontal\nset xrange [-0.5:2]\nset xlabel 'time from onset (s)'\n" +
          fmt::format(fmt::runtime(panel), "force (N)", 4, 5) +
          fmt::format(fmt::runtime(panel), "displacement (mm)", 2, 3) + "unset multiplot\n"};
}

std::optional<Figure> convergence_figure(const study::Subject& subject) {
  const auto& conditions = subject.unloaded->conditions;
  const auto* e = conditions.empty() ? nullptr : conditions.front().find();
  if (e == nullptr || e->trace.empty()) return std::nullopt;
  std::string rows =
      "# end of the fitted window (s from onset), then xx xy yx yy of M, B, K, each as a share of the "
      "largest element of the final matrix\n";
  for (const auto& point : e->trace) {
    rows += fmt::format("{:.3f}", point.end_time);
    for (Matrix impedance::Parameters::*const which :
         {&impedance::Parameters::M, &impedance::Parameters::B, &impedance::Parameters::K}) {
      const double largest = (e->value.*which).cwiseAbs().maxCoeff();
      const Matrix& m = point.value.*which;
      for (const double value : {m(0, 0), m(0, 1), m(1, 0), m(1, 1)})
        rows += fmt::format(" {:.5f}", value / largest);
    }
    rows += "\n";
  }
  std::string script =
      "set multiplot layout 3,1\nset xlabel 'end of the fitted window (s)'\nset grid\nset yrange "
      "[-1.5:1.5]\nset lmargin 9\nset key outside right center vertical samplen 2\n";
  if (e->settling_time) {
    script += fmt::format("set arrow 1 from {0:.3f},graph 0 to {0:.3f},graph 1 nohead dt 3 lc rgb 'black'\n",
                          *e->settling_time);
  }
  int column = 2;
  for (const char* name : {"mass", "damping", "stiffness"}) {
    script += fmt::format("set ylabel '{}'\nplot ", name);
    int dash = 1;
    for (const char* element : {"xx", "xy", "yx", "yy"}) {
      script +=
          fmt::format("{}'convergence.dat' using 1:{} with lines lw 1.5 dt {} lc rgb 'black' title '{}'",
                      dash == 1 ? "" : ", ", column++, dash, element);
      ++dash;
    }
    script += "\n";
  }
  return Figure{"convergence",
                "Convergence of the estimates",
                fmt::format("Subject {}, {}: elements as a share of the largest of the final matrix; settled "
                            "within 8 % after {} (dotted line; published: within 0.5 s).",
                            subject.name, conditions.front().condition.posture,
                            e->settling_time ? fmt::format("{:.2f} s", *e->settling_time)
                                             : std::string("the window's end")),
                16.0,
                18.0,
                {{"convergence.dat", rows}},
                script + "unset multiplot\n"};
}

}  // namespace tonus::report
