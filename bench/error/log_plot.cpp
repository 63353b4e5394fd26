#include "bench/error/log_plot.h"

#include <fmt/format.h>

#include <cmath>
#include <limits>

namespace tessera {
namespace {

constexpr double kLeft = 76, kTop = 56, kWidth = 460, kHeight = 330, kLegend = 190, kBottom = 50;
constexpr size_t kColors = 8;

/// Of middling lightness, so that they stand out on white and on black; told apart by the
/// colour-blind too (after Okabe and Ito 2008).
constexpr const char* kStyle = R"(<style>
text { font: 12px sans-serif; fill: #24292f }
.title { font-size: 15px; font-weight: bold }
.note, .guide { fill: #6a737d; font-size: 11px }
.grid { stroke: #8884; stroke-width: 1 }
.frame { stroke: #888; fill: none }
.slope { stroke: #888; stroke-dasharray: 6 4 }
.floor { stroke: #888; stroke-dasharray: 1 4; stroke-width: 2; stroke-linecap: round }
.line { fill: none; stroke-width: 2 }
.band { opacity: .22; stroke: none }
.s0 { stroke: #0072b2; fill: #0072b2 } .s1 { stroke: #d55e00; fill: #d55e00 }
.s2 { stroke: #009e73; fill: #009e73 } .s3 { stroke: #c05f9c; fill: #c05f9c }
.s4 { stroke: #b58900; fill: #b58900 } .s5 { stroke: #3f9fd8; fill: #3f9fd8 }
.s6 { stroke: #7a6fd0; fill: #7a6fd0 } .s7 { stroke: #888888; fill: #888888 }
.line { fill: none }
@media (prefers-color-scheme: dark) { text { fill: #d0d7de } .note, .guide { fill: #9aa4ae } }
</style>
)";

std::string escaped(const std::string& text) {
  std::string out;
  for (const char c : text) {
    if (c == '&') {
      out += "&amp;";
    } else if (c == '<') {
      out += "&lt;";
    } else if (c == '>') {
      out += "&gt;";
    } else {
      out += static_cast<unsigned char>(c) < ' ' ? ' ' : c;
    }
  }
  return out;
}

bool is_shown(double x, double y) { return x > 0 && y > 0 && std::isfinite(x) && std::isfinite(y); }

/// Decimal logarithms from edge to edge.
struct Range {
  double low = std::numeric_limits<double>::infinity();
  double high = -std::numeric_limits<double>::infinity();

  void include(double value) {
    if (!(value > 0) || !std::isfinite(value)) return;
    low = std::min(low, std::log10(value));
    high = std::max(high, std::log10(value));
  }
  /// By a margin at both ends, to a decade or nearly that.
  void widen() {
    if (!(low <= high)) low = high = 0;
    const double lack = std::max(0.0, .9 - (high - low)) / 2, margin = .05 * (high - low + lack);
    low -= lack + margin;
    high += lack + margin;
  }
};

class Drawing {
 public:
  explicit Drawing(const LogPlot& plot) : plot_(plot) {
    for (const PlotSeries& series : plot.series) {
      for (const PlotPoint& p : series.points) {
        if (!is_shown(p.x, p.y)) continue;
        x_.include(p.x);
        y_.include(p.y);
        y_.include(p.band.low);
        y_.include(p.band.high);
      }
    }
    y_.include(plot.floor);
    x_.widen();
    y_.widen();
  }

  std::string svg() {
    grid();
    guides();
    if (plot_.floor > 0) floor();
    for (size_t i = 0; i < plot_.series.size(); ++i) curve(plot_.series[i], i);
    const double width = kLeft + kWidth + kLegend, height = kTop + kHeight + kBottom;
    return fmt::format(
        "<svg xmlns=\"http://www.w3.org/2000/svg\" width=\"{0}\" height=\"{1}\" "
        "viewBox=\"0 0 {0} {1}\">\n{2}<text class=\"title\" x=\"{3}\" y=\"22\">{4}</text>\n"
        "<text class=\"note\" x=\"{3}\" y=\"40\">{5}</text>\n"
        "<clipPath id=\"inside\"><rect x=\"{3}\" y=\"{6}\" width=\"{7}\" height=\"{8}\"/>"
        "</clipPath>\n{9}"
        "<rect class=\"frame\" x=\"{3}\" y=\"{6}\" width=\"{7}\" height=\"{8}\"/>\n"
        "<text x=\"{10}\" y=\"{11}\" text-anchor=\"middle\">{12}</text>\n"
        "<text transform=\"translate(18 {13}) rotate(-90)\" text-anchor=\"middle\">{14}</text>\n"
        "</svg>\n",
        width, height, kStyle, kLeft, escaped(plot_.title), escaped(plot_.note), kTop, kWidth,
        kHeight, body_, kLeft + kWidth / 2, kTop + kHeight + 40, escaped(plot_.x_label),
        kTop + kHeight / 2, escaped(plot_.y_label));
  }

 private:
  double at_x(double value) const {
    return kLeft + kWidth * (std::log10(value) - x_.low) / (x_.high - x_.low);
  }
  double at_y(double value) const {
    return kTop + kHeight * (y_.high - std::log10(value)) / (y_.high - y_.low);
  }
  void line(const char* kind, double x0, double y0, double x1, double y1) {
    body_ += fmt::format(
        "<line class=\"{}\" clip-path=\"url(#inside)\" x1=\"{:.1f}\" y1=\"{:.1f}\" x2=\"{:.1f}\" "
        "y2=\"{:.1f}\"/>\n",
        kind, x0, y0, x1, y1);
  }
  /// Lines at 1, 2 and 5 of each decade where there are few decades, else at powers of ten.
  static std::vector<double> ticks(const Range& range) {
    const std::vector<double> steps =
        range.high - range.low < 2.6 ? std::vector<double>{1, 2, 5} : std::vector<double>{1};
    std::vector<double> out;
    for (double decade = std::floor(range.low); decade <= range.high; ++decade)
      for (const double step : steps) {
        const double place = decade + std::log10(step);
        if (place >= range.low && place <= range.high) out.push_back(step * std::pow(10, decade));
      }
    return out;
  }
  void grid() {
    for (const double x : ticks(x_)) {
      line("grid", at_x(x), kTop, at_x(x), kTop + kHeight);
      body_ += fmt::format("<text x=\"{:.1f}\" y=\"{}\" text-anchor=\"middle\">{:.4g}</text>\n",
                           at_x(x), kTop + kHeight + 18, x);
    }
    for (const double y : ticks(y_)) {
      line("grid", kLeft, at_y(y), kLeft + kWidth, at_y(y));
      body_ += fmt::format("<text x=\"{}\" y=\"{:.1f}\" text-anchor=\"end\">{:.4g}</text>\n",
                           kLeft - 6, at_y(y) + 4, y);
    }
  }
  /// From the first point of the first curve to the right edge, or to the lower one.
  void guides() {
    for (const PlotSeries& series : plot_.series) {
      for (const PlotPoint& p : series.points) {
        if (!is_shown(p.x, p.y)) continue;
        for (const double slope : plot_.guides) guide(p, slope);
        return;
      }
    }
  }
  void guide(const PlotPoint& from, double slope) {
    const double x0 = std::log10(from.x), y0 = std::log10(from.y);
    double x1 = x_.high;
    if (y0 + slope * (x1 - x0) < y_.low) x1 = x0 + (y_.low - y0) / slope;
    const double y1 = y0 + slope * (x1 - x0);
    line("slope", at_x(from.x), at_y(from.y), at_x(std::pow(10, x1)), at_y(std::pow(10, y1)));
    body_ += fmt::format(
        "<text class=\"guide\" x=\"{:.1f}\" y=\"{:.1f}\" text-anchor=\"end\">{:.3g}</text>\n",
        at_x(std::pow(10, x1)) - 4, at_y(std::pow(10, y1)) - 5, slope);
  }
  void floor() {
    line("floor", kLeft, at_y(plot_.floor), kLeft + kWidth, at_y(plot_.floor));
    body_ += fmt::format("<text class=\"guide\" x=\"{}\" y=\"{:.1f}\">{}</text>\n", kLeft + 6,
                         at_y(plot_.floor) - 5, escaped(plot_.floor_name));
  }
  void curve(const PlotSeries& series, size_t number) {
    const size_t color = number % kColors;
    std::string points, upper, lower, dots;
    for (const PlotPoint& p : series.points) {
      if (!is_shown(p.x, p.y)) continue;
      const double x = at_x(p.x), y = at_y(p.y);
      points += fmt::format("{:.1f},{:.1f} ", x, y);
      if (is_shown(p.band.low, p.band.high)) {
        upper += fmt::format("{:.1f},{:.1f} ", x, at_y(p.band.high));
        lower = fmt::format("{:.1f},{:.1f} ", x, at_y(p.band.low)) + lower;
      }
      dots += series.is_mark
                  ? fmt::format("<path class=\"s{}\" d=\"M{:.1f} {:.1f}l6 6l-6 6l-6 -6z\"/>\n",
                                color, x, y - 6)
                  : fmt::format("<circle class=\"s{}\" cx=\"{:.1f}\" cy=\"{:.1f}\" r=\"2.5\"/>\n",
                                color, x, y);
    }
    if (!series.is_mark) {
      body_ += fmt::format("<polygon class=\"band s{}\" points=\"{}{}\"/>\n", color, upper, lower);
      body_ += fmt::format("<polyline class=\"s{} line\" points=\"{}\"/>\n", color, points);
    }
    const double x = kLeft + kWidth + 12, y = kTop + 10 + 20 * static_cast<double>(number);
    body_ += dots;
    body_ += fmt::format(
        "<line class=\"s{} line\" x1=\"{}\" y1=\"{}\" x2=\"{}\" y2=\"{}\"/>\n"
        "<text x=\"{}\" y=\"{}\">{}</text>\n",
        color, x, y, x + 18, y, x + 24, y + 4, escaped(series.name));
  }

  const LogPlot& plot_;
  Range x_, y_;
  std::string body_;
};

}  // namespace

std::string to_svg(const LogPlot& plot) { return Drawing(plot).svg(); }

}  // namespace tessera
