#pragma once

#include <string>
#include <vector>

#include "bench/error/statistics.h"

namespace tessera {

/// Points of a plot with both axes logarithmic; what is not above 0 is left out.
struct PlotPoint {
  double x = 0, y = 0;
  Band band;  ///< of y; both 0: none
};
struct PlotSeries {
  std::string name;
  std::vector<PlotPoint> points;
  bool is_mark = false;  ///< single marks, not a line
};
struct LogPlot {
  std::string title, note;  ///< the note stands below the title, smaller
  std::string x_label, y_label;
  std::vector<PlotSeries> series;
  std::vector<double> guides;  ///< slopes of dashed lines from the first point on
  double floor = 0;            ///< a dotted line at this y; 0: none
  std::string floor_name;
};

/// The plot as an SVG file that reads well on a light and on a dark page. The same plot gives the
/// same text.
std::string to_svg(const LogPlot& plot);

}  // namespace tessera
