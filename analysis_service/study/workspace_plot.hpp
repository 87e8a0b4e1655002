#pragma once

#include <Eigen/Core>
#include <optional>
#include <string>
#include <vector>

#include "analysis_service/impedance/axes.hpp"
#include "analysis_service/study/figure.hpp"
#include "services/core/two_link.hpp"

namespace tonus::study {

/// A matrix at a place, with the 95 % intervals of its elements where there are some.
struct PlacedMatrix {
  Eigen::Vector2d position = Eigen::Vector2d::Zero();  ///< m, in S.
  Eigen::Matrix2d matrix = Eigen::Matrix2d::Zero();
  std::optional<Eigen::Matrix2d> half_width;  ///< Of the intervals.
};

/// Ellipses of one kind of matrix drawn in the workspace, readable in grey: series differ by dashes.
class WorkspacePlot {
 public:
  /// `calibration` is the radius of the calibration circle, in the matrices' `unit`.
  WorkspacePlot(std::string file, double calibration, std::string unit);

  void sketch_arms(const TwoLink& links, const std::vector<PlacedMatrix>& places);
  /// `dash` is a gnuplot dash type: 1 solid, 2 dashed, 3 dotted.
  void add(const std::string& label, int dash, const std::vector<PlacedMatrix>& matrices);

  [[nodiscard]] DataFile data() const;
  /// Commands from "set size" to the plot itself.
  [[nodiscard]] std::string script(const std::string& panel_title) const;

 private:
  struct Series {
    std::string label;
    std::string style;
    std::string rows;
    bool has_key = true;
  };
  struct Pending {
    std::string label;
    int dash = 1;
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

}  // namespace tonus::study
