#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <map>
#include <nlohmann/json.hpp>

#include "bench/growth.h"

namespace tessera {
namespace {

using Value = double GrowthBenchRow::*;

/// A plot of one value over the number of triangles, both by powers of ten.
class Panel {
 public:
  Panel(double left, std::string title, Value value, const std::vector<GrowthBenchRow>& rows)
      : left_(left), title_(std::move(title)), value_(value), rows_(rows) {
    for (const GrowthBenchRow& r : rows) {
      const double x = std::log10(static_cast<double>(r.triangles)), y = std::log10(r.*value);
      low_x_ = std::min(low_x_, std::floor(x + 0.1)),
      high_x_ = std::max(high_x_, std::ceil(x - 0.1));
      low_y_ = std::min(low_y_, std::floor(y)), high_y_ = std::max(high_y_, std::ceil(y));
    }
  }

  std::string draw() const {
    std::string text = fmt::format("<text x='{}' y='24' font-size='15'>{}</text>\n", left_, title_);
    for (double x = low_x_; x <= high_x_; ++x) {
      text += line(at_x(x), kTop, at_x(x), kTop + kHeight) +
              fmt::format(
                  "<text x='{:.1f}' y='{}' text-anchor='middle'>10<tspan dy='-5' "
                  "font-size='9'>{}</tspan></text>\n",
                  at_x(x), kTop + kHeight + 18, x);
    }
    for (double y = low_y_; y <= high_y_; ++y) {
      text += line(left_, at_y(y), left_ + kWidth, at_y(y)) +
              fmt::format(
                  "<text x='{}' y='{:.1f}' text-anchor='end'>10<tspan dy='-5' "
                  "font-size='9'>{}</tspan></text>\n",
                  left_ - 6, at_y(y) + 4, y);
    }
    std::map<std::string, std::string> curves;
    for (const GrowthBenchRow& r : rows_) {
      std::string& points = curves[r.accelerator + ", " + r.scene];
      points += fmt::format("{:.1f},{:.1f} ", at_x(std::log10(static_cast<double>(r.triangles))),
                            at_y(std::log10(r.*value_)));
    }
    size_t number = 0;
    for (const auto& [name, points] : curves) {
      const char* color = kColors[number % std::size(kColors)];
      const double y = kTop + 16 + 16 * static_cast<double>(number++);
      text += fmt::format(
          "<polyline points='{}' fill='none' stroke='{}' stroke-width='2'/>\n"
          "<text x='{}' y='{}' fill='{}'>{}</text>\n",
          points, color, left_ + 10, y, color, name);
    }
    return text;
  }

  static constexpr double kTop = 40, kWidth = 380, kHeight = 340;

 private:
  static constexpr const char* kColors[] = {"#1b6ca8", "#5aa9e6", "#b5531c",
                                            "#f0a35e", "#2e7d32", "#81c784"};
  static std::string line(double x0, double y0, double x1, double y1) {
    return fmt::format("<line x1='{:.1f}' y1='{:.1f}' x2='{:.1f}' y2='{:.1f}' stroke='#ddd'/>\n",
                       x0, y0, x1, y1);
  }
  double at_x(double x) const { return left_ + kWidth * (x - low_x_) / (high_x_ - low_x_); }
  double at_y(double y) const { return kTop + kHeight * (high_y_ - y) / (high_y_ - low_y_); }

  double left_;
  std::string title_;
  Value value_;
  const std::vector<GrowthBenchRow>& rows_;
  double low_x_ = 99, high_x_ = -99, low_y_ = 99, high_y_ = -99;
};

}  // namespace

std::string growth_table(const std::vector<GrowthBenchRow>& rows) {
  std::string text =
      fmt::format("{:8} {:18} {:>10} {:>10} {:>9} {:>10} {:>10} {:>8}\n", "scene", "accelerator",
                  "triangles", "build s", "us/ray", "nodes/ray", "tests/ray", "B/tri");
  for (const GrowthBenchRow& r : rows)
    text += fmt::format("{:8} {:18} {:10} {:10.4f} {:9.3f} {:10.1f} {:10.1f} {:8.1f}\n", r.scene,
                        r.accelerator, r.triangles, r.build_seconds, r.microseconds_per_ray,
                        r.node_visits_per_ray, r.triangle_tests_per_ray, r.bytes_per_triangle);
  return text;
}

std::string growth_json(const std::vector<GrowthBenchRow>& rows) {
  nlohmann::ordered_json list = nlohmann::ordered_json::array();
  for (const GrowthBenchRow& r : rows)
    list.push_back({{"scene", r.scene},
                    {"accelerator", r.accelerator},
                    {"triangles", r.triangles},
                    {"build_seconds", r.build_seconds},
                    {"microseconds_per_ray", r.microseconds_per_ray},
                    {"node_visits_per_ray", r.node_visits_per_ray},
                    {"triangle_tests_per_ray", r.triangle_tests_per_ray},
                    {"bytes_per_triangle", r.bytes_per_triangle}});
  return nlohmann::ordered_json{{"rows", list}}.dump(2) + "\n";
}

std::string growth_svg(const std::vector<GrowthBenchRow>& rows) {
  if (rows.empty()) return "<svg xmlns='http://www.w3.org/2000/svg'/>\n";
  const Panel build(60, "Seconds to build, over triangles", &GrowthBenchRow::build_seconds, rows);
  const Panel trace(60 + Panel::kWidth + 80, "Microseconds a ray, over triangles",
                    &GrowthBenchRow::microseconds_per_ray, rows);
  return fmt::format(
      "<svg xmlns='http://www.w3.org/2000/svg' width='{0}' height='{1}' viewBox='0 0 {0} {1}' "
      "font-family='sans-serif' font-size='12'>\n<rect width='{0}' height='{1}' "
      "fill='white'/>\n{2}{3}</svg>\n",
      2 * Panel::kWidth + 180, Panel::kHeight + 80, build.draw(), trace.draw());
}

}  // namespace tessera
