#include "analysis_service/study/figures.hpp"

#include <Eigen/LU>
#include <algorithm>
#include <cmath>
#include <functional>
#include <iterator>
#include <numbers>
#include <optional>
#include <spdlog/fmt/fmt.h>

#include "analysis_service/impedance/constrained.hpp"
#include "analysis_service/impedance/ellipse.hpp"
#include "analysis_service/impedance/static_stiffness.hpp"
#include "analysis_service/study/workspace_plot.hpp"

namespace tonus::study {
namespace {

using impedance::Hypothesis;
using Matrix = impedance::AxisMatrix;
using Which = Matrix impedance::Parameters::*;

/// The identified matrices of a subject's unloaded postures.
std::vector<PlacedMatrix> identified(const Subject& subject, Which which) {
  std::vector<PlacedMatrix> all;
  for (const auto& condition : subject.unloaded->conditions) {
    const auto* e = condition.find();
    if (e == nullptr) continue;
    const Eigen::Matrix2d half = 0.5 * (e->high.*which - e->low.*which);
    all.push_back({condition.condition.position, e->value.*which, half});
  }
  return all;
}

/// Other matrices at the places of `identified`.
std::vector<PlacedMatrix> at_places_of(const std::vector<PlacedMatrix>& places,
                                       const std::vector<Eigen::Matrix2d>& matrices) {
  std::vector<PlacedMatrix> all;
  for (std::size_t i = 0; i < std::min(places.size(), matrices.size()); ++i)
    all.push_back({places[i].position, matrices[i], {}});
  return all;
}

Figure workspace_figure(std::string id, std::string title, std::string caption,
                        const std::vector<std::pair<std::string, WorkspacePlot>>& panels) {
  Figure figure{std::move(id), std::move(title), std::move(caption), 16.0, 13.0, {}, {}};
  const bool is_multiple = panels.size() > 1;
  if (is_multiple) {
    figure.width_cm = 12.0 * static_cast<double>(panels.size());
    figure.height_cm = 11.0;
    figure.script = fmt::format("set multiplot layout 1,{}\n", panels.size());
  }
  for (const auto& [panel_title, plot] : panels) {
    figure.data.push_back(plot.data());
    figure.script += plot.script(panel_title);
  }
  if (is_multiple) figure.script += "unset multiplot\n";
  return figure;
}

std::optional<Figure> figure_three(const Subject& subject) {
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
      "set xlabel 'time from onset (s)'\nset ylabel '{}'\nplot 'figure3.dat' using 1:{} with lines lw 1.5 dt "
      "1 "
      "lc rgb 'black' title 'x', 'figure3.dat' using 1:{} with lines lw 1.5 dt 2 lc rgb 'black' title 'y'\n";
  Figure figure{"figure3",
                "Fig. 3. Force and position of one perturbation",
                fmt::format("Subject {}, {}, perturbation {}. Displacement from the rest, force on the arm.",
                            subject.name, conditions.front().condition.posture, trial.number),
                16.0,
                12.0,
                {{"figure3.dat", rows}},
                "set multiplot layout 2,1\nset grid\n" + fmt::format(fmt::runtime(panel), "force (N)", 4, 5) +
                    fmt::format(fmt::runtime(panel), "displacement (mm)", 2, 3) + "unset multiplot\n"};
  return figure;
}

std::optional<Figure> figure_four(const Subject& subject) {
  const auto places = identified(subject, &impedance::Parameters::K);
  if (places.empty()) return std::nullopt;
  const Eigen::Matrix2d K = impedance::symmetric_part(places.front().matrix);
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
  const double shown = 30.0 * std::numbers::pi / 180.0;  // a displacement off the axes
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
      "set size ratio -1\nset xlabel 'x (N/m)'\nset ylabel 'y (N/m)'\nset grid\n"
      "plot 'figure4-ellipse.dat' with lines lw 2 lc rgb 'black' title 'restoring force', "
      "'figure4-arrows.dat' index 0 using 1:2:3:4 with vectors nohead dt 2 lc rgb 'black' title 'axes', "
      "'' index 1 using 1:2:3:4 with vectors lw 1.5 lc rgb '#808080' title 'direction of a displacement', "
      "'' index 2 using 1:2:3:4 with vectors lw 2 lc rgb 'black' title 'its restoring force'\n"};
}

std::optional<Figure> figure_five(const Subject& subject) {
  const auto masses = subject.link_masses(impedance::Method::kStateVariable);
  if (!masses) return std::nullopt;
  const auto places = identified(subject, &impedance::Parameters::M);
  WorkspacePlot plot("figure5.dat", 2.0, "kg");
  plot.sketch_arms(subject.links, places);
  plot.add("identified", 2, places);
  plot.add("modelled, two cylinders", 1, at_places_of(places, masses->modelled));
  return workspace_figure(
      "figure5", "Fig. 5. Identified and modelled mass",
      "Subject " + subject.name + ". Modelled: the two-cylinder arm with the link masses of Table I.",
      {{"mass", plot}});
}

std::optional<Figure> figure_six(const Subject& subject) {
  const auto masses = subject.link_masses(impedance::Method::kStateVariable);
  if (!masses) return std::nullopt;
  const auto places = identified(subject, &impedance::Parameters::B);
  std::vector<Eigen::Matrix2d> constrained;
  for (const auto& condition : subject.unloaded->conditions) {
    const auto* e = condition.find();
    if (e == nullptr) continue;
    const auto damping = impedance::constrain(*e, masses->modelled[constrained.size()], e->value.K);
    if (!damping) return std::nullopt;
    constrained.push_back(damping->B);
  }
  WorkspacePlot plot("figure6.dat", 15.0, "N s/m");
  plot.sketch_arms(subject.links, places);
  plot.add("free", 2, places);
  plot.add("constrained to the modelled masses", 1, at_places_of(places, constrained));
  return workspace_figure(
      "figure6", "Fig. 6. Damping, free and constrained",
      "Subject " + subject.name + ". Constrained: mass held at that of Fig. 5, stiffness at the free one.",
      {{"damping", plot}});
}

std::optional<Figure> figure_seven(const Subject& subject) {
  struct Panel {
    const char* title;
    const char* file;
    Which which;
    double calibration;
    const char* unit;
  };
  std::vector<std::pair<std::string, WorkspacePlot>> panels;
  for (const Panel& panel :
       {Panel{"mass", "figure7-mass.dat", &impedance::Parameters::M, 2.5, "kg"},
        Panel{"damping", "figure7-damping.dat", &impedance::Parameters::B, 16.0, "N s/m"},
        Panel{"stiffness", "figure7-stiffness.dat", &impedance::Parameters::K, 200.0, "N/m"}}) {
    const auto places = identified(subject, panel.which);
    if (places.empty()) return std::nullopt;
    WorkspacePlot plot(panel.file, panel.calibration, panel.unit);
    plot.sketch_arms(subject.links, places);
    plot.add("identified", 1, places);
    panels.emplace_back(panel.title, plot);
  }
  return workspace_figure("figure7", "Fig. 7. Mass, damping and stiffness at the five postures",
                          "Subject " + subject.name + ".", panels);
}

std::optional<Figure> hypothesis_figure(const Subject& subject, const char* id, const char* title,
                                        Hypothesis first, Hypothesis second) {
  const auto joints =
      impedance::joint_matrices(subject.postures(impedance::Method::kStateVariable), subject.links);
  if (!joints) return std::nullopt;
  const auto places = identified(subject, &impedance::Parameters::B);
  std::vector<std::pair<std::string, WorkspacePlot>> panels;
  for (const Hypothesis hypothesis : {first, second}) {
    const auto fit = impedance::fit_hypothesis(*joints, hypothesis);
    if (!fit) return std::nullopt;
    const std::string name(impedance::name_of(hypothesis));
    WorkspacePlot plot(fmt::format("{}-{}.dat", id, name), 15.0, "N s/m");
    plot.sketch_arms(subject.links, places);
    plot.add("identified", 2, places);
    plot.add("reconstructed, " + name, 1, at_places_of(places, fit->damping));
    panels.emplace_back(fmt::format("{}, error {:.0f} %", name, 100.0 * fit->error), plot);
  }
  return workspace_figure(id, title, "Subject " + subject.name + ".", panels);
}

std::optional<Figure> figure_ten(const Subject& subject) {
  struct Reference {
    Eigen::Matrix2d K = Eigen::Matrix2d::Zero();
    int count = 0;
  };
  constexpr double kEnlarged = 12.0;  // times, of the vectors
  std::map<std::uint32_t, Reference> references;
  for (const auto& c : subject.loaded->conditions) {
    const auto* e = c.find();
    if (e == nullptr || c.condition.is_loaded()) continue;
    references[c.condition.posture_index].K += Eigen::Matrix2d(e->value.K);
    ++references[c.condition.posture_index].count;
  }
  std::string predicted;
  std::string actual;
  std::string places;
  const auto arrow = [&](const Eigen::Vector2d& from, const Eigen::Vector2d& centre) {
    const Eigen::Vector2d to = kEnlarged * centre;
    return fmt::format("{:.5f} {:.5f} {:.5f} {:.5f}\n", from.x(), from.y(), to.x(), to.y());
  };
  for (const auto& c : subject.loaded->conditions) {
    const auto* e = c.find();
    const auto reference = references.find(c.condition.posture_index);
    if (e == nullptr || !c.condition.is_loaded() || reference == references.end()) continue;
    const auto centre =
        impedance::predicted_spring_centre(reference->second.K / reference->second.count, c.condition.bias);
    if (!centre) continue;
    predicted += arrow(c.condition.position, *centre);
    const auto still = impedance::static_stiffness(c.trials, {});
    actual += arrow(c.condition.position, still ? Eigen::Vector2d(still->X0) : Eigen::Vector2d(e->value.X0));
    places += fmt::format("{:.5f} {:.5f}\n", c.condition.position.x(), c.condition.position.y());
  }
  if (predicted.empty()) return std::nullopt;
  return Figure{
      "figure10",
      "Fig. 10. Spring centres under bias forces, predicted and actual",
      fmt::format(
          "Subject {}. Vectors from the posture to the spring centre, enlarged {:g} times. Predicted: "
          "-K^-1 F_bias with the unloaded stiffness (20); actual: static points (19).",
          subject.name, kEnlarged),
      13.0,
      16.0,
      {{"figure10.dat",
        "# from x, from y (m), vector x, vector y (m, enlarged); blocks: predicted, actual, postures\n" +
            predicted + "\n\n" + actual + "\n\n" + places}},
      "set size ratio -1\nset xlabel 'x from the shoulder (m)'\nset ylabel 'y (m)'\nset xrange [-0.2:0.2]\n"
      "set yrange [0.1:0.66]\nset key outside bottom center horizontal\n"
      "plot 'figure10.dat' index 0 with vectors dt 2 lw 1.5 lc rgb '#606060' title 'predicted', "
      "'' index 1 with vectors lw 1.5 lc rgb 'black' title 'actual', "
      "'' index 2 with points pt 7 ps 0.5 lc rgb 'black' title 'posture'\n"};
}

std::optional<Figure> convergence_figure(const Subject& subject) {
  const auto& conditions = subject.unloaded->conditions;
  const auto* e = conditions.empty() ? nullptr : conditions.front().find();
  if (e == nullptr || e->trace.empty()) return std::nullopt;
  struct Panel {
    const char* title;
    Which which;
  };
  std::string rows =
      "# end of the fitted window (s from onset), then xx xy yx yy of M, B, K, each as a share of the "
      "largest "
      "element of the final matrix\n";
  for (const auto& point : e->trace) {
    rows += fmt::format("{:.3f}", point.end_time);
    for (const Which which :
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
      "[-1.2:1.2]\n";
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
                            "within 8 % after {}.",
                            subject.name, conditions.front().condition.posture,
                            e->settling_time ? fmt::format("{:.2f} s", *e->settling_time)
                                             : std::string("the window's end")),
                16.0,
                18.0,
                {{"convergence.dat", rows}},
                script + "unset multiplot\n"};
}

}  // namespace

std::vector<Figure> figures(const Study& study) {
  std::vector<const Subject*> unloaded;
  const Subject* loaded = nullptr;
  for (const Subject& subject : study.subjects) {
    if (subject.unloaded && !subject.unloaded->conditions.empty()) unloaded.push_back(&subject);
    if (subject.loaded && loaded == nullptr) loaded = &subject;
  }
  std::vector<Figure> all;
  const auto add = [&all](std::optional<Figure> figure) {
    if (figure) all.push_back(std::move(*figure));
  };
  if (!unloaded.empty()) {
    const Subject& first = *unloaded.front();
    add(figure_three(first));
    add(figure_four(first));
    add(figure_five(first));
    add(figure_six(first));
    add(figure_seven(*unloaded[unloaded.size() > 1 ? 1 : 0]));
    add(hypothesis_figure(first, "figure8", "Fig. 8. Damping identified and reconstructed, one constant",
                          Hypothesis::kSS, Hypothesis::kSD));
    add(hypothesis_figure(first, "figure9", "Fig. 9. Damping identified and reconstructed, three constants",
                          Hypothesis::kMS, Hypothesis::kMD));
  }
  if (loaded != nullptr) add(figure_ten(*loaded));
  if (!unloaded.empty()) add(convergence_figure(*unloaded.front()));
  return all;
}

}  // namespace tonus::study
