#include <fmt/format.h>

#include <algorithm>

#include "base/plural.h"
#include "scenes/formats/x3d/geometry/x3d_faces.h"

namespace tessera {
namespace {

size_t dimension(const X3dNode& node, const X3dValues& values, const char* name) {
  const int64_t count = values.integer(node, name, 0);
  if (count >= 0) return static_cast<size_t>(count);
  values.repair(node, name, "0 or more", "0 is taken");
  return 0;
}

double spacing(const X3dNode& node, const X3dValues& values, const char* name) {
  const double value = values.number(node, name, 1);
  if (value <= 0) values.repair(node, name, "a length above 0", "it is taken as it is");
  return value;
}

}  // namespace

X3dFaces read_x3d_grid(const X3dNode& node, const X3dValues& values) {
  X3dFaces out;
  const size_t columns = dimension(node, values, "xDimension");
  size_t rows = dimension(node, values, "zDimension");
  const double dx = spacing(node, values, "xSpacing"), dz = spacing(node, values, "zSpacing");
  const std::vector<float> heights = values.floats(node, "height", 1);
  if (columns < 2 || rows < 2) return out;
  // No product of two 32-bit numbers is too large for 64 bits.
  if (columns * rows > heights.size()) {
    values.repair(node.offset,
                  fmt::format("{} of {}, {} x {}", counted(heights.size(), "height"),
                              describe(node), columns, rows),
                  "xDimension times zDimension", "the rows that are whole are taken");
    rows = heights.size() / columns;
    if (rows < 2) return out;
  } else if (columns * rows < heights.size()) {
    values.repair(node, "height", node.field("height")->offset,
                  fmt::format("{} for {} x {}", heights.size(), columns, rows),
                  "xDimension times zDimension", "the first ones are taken");
  }
  if (columns * rows > kMaxX3dPoints)
    throw values.document().error(node.offset,
                                  fmt::format("{} heights of {}", columns * rows, describe(node)),
                                  fmt::format("at most {}", kMaxX3dPoints));
  for (size_t row = 0; row < rows; ++row) {
    for (size_t column = 0; column < columns; ++column) {
      const auto x = static_cast<double>(column), z = static_cast<double>(row);
      out.points.insert(out.points.end(),
                        {static_cast<float>(x * dx), heights[row * columns + column],
                         static_cast<float>(z * dz)});
      out.uvs.push_back(static_cast<float>(x / static_cast<double>(columns - 1)));
      out.uvs.push_back(static_cast<float>(z / static_cast<double>(rows - 1)));
    }
  }
  const auto width = static_cast<uint32_t>(columns);
  for (uint32_t row = 0; row + 1 < rows; ++row) {
    for (uint32_t column = 0; column + 1 < width; ++column) {
      const uint32_t a = row * width + column;
      const uint32_t quad[] = {a, a + width, a + width + 1, a + 1};
      out.add_face(quad);
    }
  }
  out.corner_uvs = out.polygons.corners;
  return out;
}

}  // namespace tessera
