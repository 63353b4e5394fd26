#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>

#include "scenes/formats/x3d/geometry/stroke_font.h"
#include "scenes/formats/x3d/geometry/x3d_faces.h"

namespace tessera {
namespace {

constexpr double kPen = 1.1;  // width of a line, in units of the font
constexpr double kBoldPen = 1.7;
constexpr double kSlant = 0.2;

class TextBuilder {
 public:
  TextBuilder(const X3dNode& node, const X3dValues& values) : node_(node), values_(values) {
    lines_ = values.strings(node, "string");
    lengths_ = values.numbers(node, "length", 1);
    for (double& length : lengths_) length = values.clamped(node, "length", length);
    most_ = values.amount(node, "maxExtent", 0);
    const X3dNode* style = node.child("fontStyle");
    if (!style || style->type != "FontStyle") return;
    size_ = values.number(*style, "size", 1);
    spacing_ = values.amount(*style, "spacing", 1);
    if (!(size_ > 0)) {
      values.repair(*style, "size", "a height above 0", "1 is taken");
      size_ = 1;
    }
    constexpr std::array<std::string_view, 4> kStyles{"PLAIN", "BOLD", "ITALIC", "BOLDITALIC"};
    const size_t look = values.choice(*style, "style", kStyles);
    bold_ = look % 2 == 1;
    italic_ = look >= 2;
    for (const char* name : {"horizontal", "leftToRight", "topToBottom"})
      if (!values.boolean(*style, name, true))
        values.warn(style->field(name)->offset,
                    "Text is written in lines from the left and from the top");
    const auto justify = values.strings(*style, "justify");
    constexpr std::array<std::string_view, 4> kMajor{"BEGIN", "FIRST", "MIDDLE", "END"},
        kMinor{"FIRST", "BEGIN", "MIDDLE", "END"};
    if (!justify.empty()) major_ = kMajor[values.choice(*style, "justify", justify[0], kMajor)];
    if (justify.size() > 1) minor_ = kMinor[values.choice(*style, "justify", justify[1], kMinor)];
  }

  X3dFaces make() {
    std::vector<double> widths;
    double widest = 0;
    for (size_t i = 0; i < lines_.size(); ++i) {
      const double wanted = i < lengths_.size() ? lengths_[i] : 0;
      widths.push_back(wanted > 0 ? wanted : natural_width(lines_[i]));
      widest = std::max(widest, widths.back());
    }
    const double narrowing = most_ > 0 && widest > most_ ? most_ / widest : 1;
    const double lead = size_ * spacing_;
    double y = first_line(lead);
    for (size_t i = 0; i < lines_.size(); ++i, y -= lead)
      add_line(lines_[i], widths[i] * narrowing, y);
    return std::move(out_);
  }

 private:
  double unit() const { return size_ / (kGlyphDepth + kGlyphHeight); }

  static bool begins_character(char c) { return (static_cast<unsigned char>(c) & 0xC0) != 0x80; }

  double natural_width(const std::string& line) const {
    double width = 0;
    for (const char c : line)
      if (begins_character(c)) width += stroke_glyph(static_cast<unsigned char>(c)).advance;
    return width * unit();
  }

  /// The height of the first baseline.
  double first_line(double lead) const {
    const double rest = lead * (static_cast<double>(std::max<size_t>(lines_.size(), 1)) - 1);
    const double top = kGlyphHeight * unit(), bottom = kGlyphDepth * unit();
    if (minor_ == "BEGIN") return -top;
    if (minor_ == "END") return rest + bottom;
    if (minor_ == "MIDDLE") return (rest + bottom - top) / 2;
    return 0;
  }

  void add_line(const std::string& line, double width, double y) {
    const double natural = natural_width(line);
    const double stretch = natural > 0 ? width / natural : 1;
    double x = major_ == "END" ? -width : major_ == "MIDDLE" ? -width / 2 : 0;
    for (const char c : line) {
      if (!begins_character(c)) continue;
      const auto code = static_cast<unsigned char>(c);
      if (code < ' ' || code > '~')
        values_.warn(node_.field("string")->offset,
                     "a character that our font does not have is written as '?'");
      const StrokeGlyph glyph = stroke_glyph(code);
      for (const Stroke& stroke : glyph.strokes) add_stroke(stroke, x, y, stretch);
      x += glyph.advance * unit() * stretch;
    }
  }

  void add_stroke(const Stroke& stroke, double x, double y, double stretch) {
    const auto place = [&](const Stroke::Point& p) {
      const double across = p.x + kPen / 2 + (italic_ ? kSlant * p.y : 0);
      return Vec3{x + across * unit() * stretch, y + (p.y + kPen / 2) * unit(), 0};
    };
    const auto& points = stroke.points;
    if (points.size() == 1) add_bar(place(points[0]), place(points[0]));
    for (size_t i = 0; i + 1 < points.size(); ++i) add_bar(place(points[i]), place(points[i + 1]));
  }

  /// A line with square ends, so that corners close.
  void add_bar(const Vec3& a, const Vec3& b) {
    if (out_.points.size() / 3 + 4 > kMaxX3dPoints)
      throw values_.document().error(node_.offset, "a text that is too long",
                                     fmt::format("at most {} corners", kMaxX3dPoints));
    values_.spend(4 * 3 * sizeof(float), node_.offset);
    const double half = (bold_ ? kBoldPen : kPen) / 2 * unit();
    const Vec3 along = length_squared(b - a) > 0 ? normalize(b - a) * half : Vec3{half, 0, 0};
    const Vec3 up{-along.y, along.x, 0};
    const auto first = static_cast<uint32_t>(out_.points.size() / 3);
    for (const Vec3& p : {a - along - up, b + along - up, b + along + up, a - along + up})
      for (int k = 0; k < 3; ++k) out_.points.push_back(static_cast<float>(p[k]));
    const uint32_t quad[] = {first, first + 1, first + 2, first + 3};
    out_.add_face(quad);
  }

  const X3dNode& node_;
  const X3dValues& values_;
  std::vector<std::string> lines_;
  std::vector<double> lengths_;
  double most_ = 0, size_ = 1, spacing_ = 1;
  bool bold_ = false, italic_ = false;
  std::string_view major_ = "BEGIN", minor_ = "FIRST";
  X3dFaces out_;
};

}  // namespace

X3dFaces read_x3d_text(const X3dNode& node, const X3dValues& values) {
  return TextBuilder(node, values).make();
}

}  // namespace tessera
