#include "analysis_service/report/posture_figures.hpp"

#include <algorithm>
#include <spdlog/fmt/fmt.h>

#include "analysis_service/impedance/constrained.hpp"
#include "analysis_service/report/workspace_plot.hpp"

namespace tonus::report {
namespace {

using impedance::Hypothesis;
using Matrix = impedance::AxisMatrix;
using Which = Matrix impedance::Parameters::*;

const std::string kEllipse =
    "Ellipses: the force for a unit displacement (or velocity, acceleration) turned through 360 deg, at the "
    "hand; grey bands: 95 % intervals.";

/// The identified matrices of a subject's unloaded postures.
std::vector<PlacedMatrix> identified(const study::Subject& subject, Which which) {
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

}  // namespace

std::optional<Figure> mass_figure(const study::Subject& subject) {
  const auto masses = subject.link_masses(impedance::Method::kStateVariable);
  if (!masses) return std::nullopt;
  const auto places = identified(subject, &impedance::Parameters::M);
  WorkspacePlot plot("figure5.dat", 2.0, "kg");
  plot.sketch_arms(subject.links, places);
  plot.add("modelled, two cylinders", kBroadGrey, at_places_of(places, masses->modelled));
  plot.add("identified", kBlack, places);
  return workspace_figure(
      "figure5", "Fig. 5. Identified and modelled mass",
      "Subject " + subject.name + ". Modelled: the two-cylinder arm with the link masses of Table I.",
      {{"mass", plot}});
}

std::optional<Figure> constrained_figure(const study::Subject& subject) {
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
  plot.add("constrained", kBroadGrey, at_places_of(places, constrained));
  plot.add("free", kBlack, places);
  return workspace_figure(
      "figure6", "Fig. 6. Damping, free and constrained",
      "Subject " + subject.name +
          ". Constrained: mass held at the modelled one of Fig. 5, stiffness at the free one.",
      {{"damping", plot}});
}

std::optional<Figure> posture_figure(const study::Subject& subject) {
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
    plot.add("identified", kBlack, places);
    panels.emplace_back(panel.title, plot);
  }
  return workspace_figure("figure7", "Fig. 7. Mass, damping and stiffness at the five postures",
                          "Subject " + subject.name + ". " + kEllipse, panels);
}

std::optional<Figure> hypothesis_figure(const study::Subject& subject, const char* id, const char* title,
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
    plot.add("reconstructed", kBroadGrey, at_places_of(places, fit->damping));
    plot.add("identified", kBlack, places);
    panels.emplace_back(fmt::format("{}, error {:.0f} %", name, 100.0 * fit->error), plot);
  }
  return workspace_figure(id, title, "Subject " + subject.name + ". " + kEllipse, panels);
}

}  // namespace tonus::report
