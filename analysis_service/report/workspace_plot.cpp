#include "analysis_service/report/workspace_plot.hpp"

#include <algorithm>
#include <cmath>
#include <iterator>
#include <numbers>
#include <spdlog/fmt/fmt.h>

#include "analysis_service/impedance/ellipse.hpp"

namespace tonus::report {
namespace {

constexpr double kLargestRadius = 0.11;  // m in the drawing, of the largest ellipse.
constexpr int kPoints = 120;             // Of an ellipse.
const Eigen::Vector2d kCalibrationPlace{-0.47, 0.66};

void add_point(std::string& rows, const Eigen::Vector2d& point) {
  fmt::format_to(std::back_inserter(rows), "{:.5f} {:.5f}\n", point.x(), point.y());
}

/// Half width of the interval of |Zs u|, the elements' errors taken as independent.
double band(const PlacedMatrix& placed, const Eigen::Vector2d& u, const Eigen::Vector2d& force) {
  const Eigen::Matrix2d& width = *placed.half_width;
  const Eigen::Vector2d along = force.normalized();
  const double off = 0.5 * (along[0] * u[1] + along[1] * u[0]);
  const double variance = std::pow(along[0] * u[0] * width(0, 0), 2) +
                          std::pow(along[1] * u[1] * width(1, 1), 2) + std::pow(off * width(0, 1), 2) +
                          std::pow(off * width(1, 0), 2);
  return std::sqrt(variance);
}

/// Points of the force for a unit displacement turned through 360 deg, `side` bands farther out.
std::vector<Eigen::Vector2d> locus(const PlacedMatrix& placed, double scale, double side) {
  std::vector<Eigen::Vector2d> points;
  const Eigen::Matrix2d symmetric = impedance::symmetric_part(placed.matrix);
  for (int i = 0; i <= kPoints; ++i) {
    const double angle = 2.0 * std::numbers::pi * i / kPoints;
    const Eigen::Vector2d u(std::cos(angle), std::sin(angle));
    Eigen::Vector2d force = symmetric * u;
    if (side != 0.0) force += side * band(placed, u, force) * force.normalized();
    points.emplace_back(placed.position + scale * force);
  }
  return points;
}

std::string curve(const PlacedMatrix& placed, double scale) {
  std::string rows;
  for (const auto& point : locus(placed, scale, 0.0)) add_point(rows, point);
  return rows + "\n";
}

/// The ring between the two ends of the interval, as one outline: outer curve, then the inner one backward.
std::string ring(const PlacedMatrix& placed, double scale) {
  std::string rows;
  for (const auto& point : locus(placed, scale, 1.0)) add_point(rows, point);
  auto inner = locus(placed, scale, -1.0);
  std::reverse(inner.begin(), inner.end());
  for (const auto& point : inner) add_point(rows, point);
  return rows + "\n";
}

std::string circle(const Eigen::Vector2d& centre, double radius) {
  PlacedMatrix round{centre, Eigen::Matrix2d::Identity(), {}};
  return curve(round, radius);
}

}  // namespace

WorkspacePlot::WorkspacePlot(std::string file, double calibration, std::string unit)
    : file_(std::move(file)), calibration_(calibration), unit_(std::move(unit)) {}

void WorkspacePlot::sketch_arms(const TwoLink& links, const std::vector<PlacedMatrix>& places) {
  for (const PlacedMatrix& place : places) {
    if (!links.reaches(place.position)) continue;
    const double shoulder = links.angles_at(place.position)[0];
    add_point(arms_, Eigen::Vector2d::Zero());
    add_point(arms_, links.l1 * Eigen::Vector2d(std::cos(shoulder), std::sin(shoulder)));
    add_point(arms_, place.position);
    arms_ += "\n";
  }
}

void WorkspacePlot::add(const std::string& label, LineStyle style,
                        const std::vector<PlacedMatrix>& matrices) {
  pending_.push_back({label, style, matrices});
}

double WorkspacePlot::scale() const {
  double largest = calibration_;
  for (const Pending& kind : pending_) {
    for (const PlacedMatrix& placed : kind.matrices) {
      if (const auto ellipse = impedance::ellipse_of(placed.matrix))
        largest = std::max(largest, ellipse->major);
    }
  }
  return kLargestRadius / largest;
}

std::vector<WorkspacePlot::Series> WorkspacePlot::series() const {
  std::vector<Series> all;
  Series bands{"95 % band", "filledcurves closed fc rgb '#c8c8c8' fs solid noborder", {}};
  for (const Pending& kind : pending_) {
    for (const PlacedMatrix& placed : kind.matrices) {
      if (placed.half_width) bands.rows += ring(placed, scale());
    }
  }
  if (!bands.rows.empty()) all.push_back(std::move(bands));
  all.push_back({"arm", "lines lw 1 dt 3 lc rgb '#808080'", arms_});
  for (const Pending& kind : pending_) {
    Series ellipses{
        kind.label, fmt::format("lines lw {:g} lc rgb '{}'", kind.style.weight, kind.style.colour), {}};
    for (const PlacedMatrix& placed : kind.matrices) ellipses.rows += curve(placed, scale());
    all.push_back(std::move(ellipses));
  }
  all.push_back({"", "lines lw 1 dt 2 lc rgb 'black'", circle(kCalibrationPlace, scale() * calibration_)});
  return all;
}

DataFile WorkspacePlot::data() const {
  std::string text =
      "# x (m)  y (m), in the shoulder frame; blocks in the order of the plot, the calibration circle last\n";
  for (const Series& part : series()) text += part.rows + "\n";
  return {file_, text};
}

std::string WorkspacePlot::script(const std::string& panel_title) const {
  const double label_y = kCalibrationPlace.y() - scale() * calibration_ - 0.035;
  std::string text = fmt::format(
      "set title '{}'\nset size ratio -1\nset xlabel 'x from the shoulder (m)'\nset ylabel 'y (m)'\n"
      "set lmargin 8\nset rmargin 2\nset tmargin 2\nset bmargin 4\n"
      "set xrange [-0.62:0.55]\nset yrange [-0.05:0.80]\nset xtics 0.2\nset ytics 0.2\n"
      "set key top right vertical samplen 2\nset label 1 'radius {:g} {}' at {:.3f},{:.3f} center\nplot ",
      panel_title, calibration_, unit_, kCalibrationPlace.x() + 0.03, label_y);
  const auto all = series();
  for (std::size_t i = 0; i < all.size(); ++i) {
    fmt::format_to(std::back_inserter(text), "{}'{}' index {} using 1:2 with {} {}", i == 0 ? "" : ", \\\n  ",
                   file_, i, all[i].style,
                   all[i].label.empty() ? std::string("notitle") : "title '" + all[i].label + "'");
  }
  return text + "\n";
}

}  // namespace tonus::report
