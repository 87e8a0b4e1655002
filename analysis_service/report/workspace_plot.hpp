#pragma once

#include <Eigen/Core>
#include <optional>
#include <string>
#include <vector>

#include "analysis_service/impedance/axes.hpp"
#include "analysis_service/report/figure.hpp"
#include "services/mechanics/two_link.hpp"

namespace tonus::report {

/// A matrix at a place, with the 95 % intervals of its elements where there are some.
struct PlacedMatrix {
  Eigen::Vector2d position = Eigen::Vector2d::Zero();  ///< m, in S.
  Eigen::Matrix2d matrix = Eigen::Matrix2d::Zero();
  std::optional<Eigen::Matrix2d> half_width;  ///< Of the intervals.
};

/// How a series of ellipses is drawn; readable in grey, and one upon the other.
struct LineStyle {
  double weight = 1.4;
  const char* colour = "black";
};
inline constexpr LineStyle kBlack{1.4, "black"};
inline constexpr LineStyle kBroadGrey{4.5, "#b8b8b8"};  ///< Below another series.

/// Ellipses of one kind of matrix drawn in the workspace, with the arm sketched, equal axes and
/// a calibration circle; intervals are bands.
class WorkspacePlot {
 public:
  /// `calibration` is the radius of the calibration circle, in the matrices' `unit`.
  WorkspacePlot(std::string file, double calibration, std::string unit);

  void sketch_arms(const TwoLink& links, const std::vector<PlacedMatrix>& places);
  /// Later series are drawn upon earlier ones.
  void add(const std::string& label, LineStyle style, const std::vector<PlacedMatrix>& matrices);

  [[nodiscard]] DataFile data() const;
  /// Commands from "set size" to the plot itself.
  [[nodiscard]] std::string script(const std::string& panel_title) const;

 private:
  struct Series {
    std::string label;
    std::string style;  ///< After "with".
    std::string rows;
  };
  struct Pending {
    std::string label;
    LineStyle style;
    std::vector<PlacedMatrix> matrices;
  };
  [[nodiscard]] std::vector<Series> series() const;
  [[nodiscard]] double scale() const;

  std::string file_;
  double calibration_;
  std::string unit_;
  std::string arms_;
  std::vector<Pending> pending_;
};

}  // namespace tonus::report
