#pragma once

#include <string>
#include <vector>

namespace tonus::report {

/// A data file of a figure: blocks of rows, apart by two empty lines, with a heading that says columns and
/// units.
struct DataFile {
  std::string name;  ///< "figure7-mass.dat"
  std::string text;
};

/// A figure: what gnuplot needs to draw it. The script says neither terminal nor output.
struct Figure {
  std::string id;       ///< "figure7"; names its files.
  std::string title;    ///< "Fig. 7. ..."
  std::string caption;  ///< What is drawn, with scales and units.
  double width_cm = 16.0;
  double height_cm = 10.0;
  std::vector<DataFile> data;
  std::string script;
};

}  // namespace tonus::report
