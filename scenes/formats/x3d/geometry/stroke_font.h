#pragma once

#include <string_view>
#include <vector>

namespace tessera {

/// A line of a glyph, in eighths of a capital's height; y = 0 is the baseline.
struct Stroke {
  struct Point {
    double x, y;
  };
  std::vector<Point> points;  ///< one: a dot
};

struct StrokeGlyph {
  std::vector<Stroke> strokes;
  double advance = 4;  ///< from its left edge to the next glyph's
};

/// How far below the baseline glyphs reach, and how high they are above it.
inline constexpr double kGlyphDepth = 3, kGlyphHeight = 8;

/// Our own font: the printable characters of ASCII; a question mark for all others.
StrokeGlyph stroke_glyph(unsigned char character);

}  // namespace tessera
