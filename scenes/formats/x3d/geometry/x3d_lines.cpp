#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <optional>

#include "base/plural.h"
#include "scenes/formats/x3d/geometry/x3d_faces.h"

namespace tessera {
namespace {

class LineBuilder {
 public:
  LineBuilder(const X3dNode& node, const X3dValues& values, const X3dPen& pen)
      : node_(node), values_(values), pen_(pen) {
    const double extent = pen.camera_from_node.determinant();
    if (extent != 0 && std::isfinite(extent)) node_from_camera_ = inverse(pen.camera_from_node);
    if (const X3dNode* coord = node.child("coord")) coordinates_ = values.points(*coord);
  }

  X3dFaces make() {
    if (node_.type == "PointSet")
      for (size_t i = 0; i < coordinates_.size() / 3; ++i) add_point(i);
    else if (node_.type == "LineSet")
      add_counted();
    else
      add_indexed();
    return std::move(out_);
  }

 private:
  Vec3 coordinate(size_t i) const {
    return {coordinates_[3 * i], coordinates_[3 * i + 1], coordinates_[3 * i + 2]};
  }

  void add_counted() {
    const std::vector<size_t> begins =
        values_.runs(node_, "vertexCount", 2, coordinates_.size() / 3);
    for (size_t k = 0; k + 1 < begins.size(); ++k)
      for (size_t i = begins[k]; i + 1 < begins[k + 1]; ++i) add_line(i, i + 1, i, i + 1, k);
  }

  void add_indexed() {
    constexpr const char* kLeftOut = "the lines there are left out";
    const auto index = values_.integers(node_, "coordIndex", X3dValues::kNoInteger, kLeftOut);
    const size_t most = coordinates_.size() / 3;
    const auto is_point = [&](int32_t i) { return i >= 0 && static_cast<size_t>(i) < most; };
    size_t line = 0;
    for (size_t at = 0; at < index.values.size(); ++at) {
      if (index.values[at] == -1) {
        ++line;
        continue;
      }
      if (index.values[at] == X3dValues::kNoInteger) continue;
      if (!is_point(index.values[at]))
        values_.repair(index.offsets[at],
                       fmt::format("coordIndex {} of {}, which has {}", index.values[at],
                                   describe(node_), counted(most, "point")),
                       "an index of a point", kLeftOut);
      else if (at > 0 && is_point(index.values[at - 1]))
        add_line(static_cast<size_t>(index.values[at - 1]), static_cast<size_t>(index.values[at]),
                 at - 1, at, line);
    }
  }

  uint32_t add_vertex(const Vec3& p) {
    constexpr size_t kBytes = 64;  // about, with the faces about it
    values_.spend(kBytes, node_.offset);
    const size_t number = out_.points.size() / 3;
    if (number >= kMaxX3dPoints)
      throw values_.document().error(node_.offset,
                                     fmt::format("too many lines in {}", describe(node_)),
                                     fmt::format("at most {} corners", kMaxX3dPoints));
    for (int a = 0; a < 3; ++a) out_.points.push_back(static_cast<float>(p[a]));
    return static_cast<uint32_t>(number);
  }

  /// A corner stands for a coordinate, at a place in the index.
  struct Corner {
    uint32_t vertex, coordinate, slot;
  };

  void add_face(std::span<const Corner> corners, size_t number) {
    std::vector<uint32_t> face;
    for (const Corner& c : corners) {
      face.push_back(c.vertex);
      out_.corner_coordinates.push_back(c.coordinate);
      out_.corner_slots.push_back(c.slot);
    }
    out_.add_face(face);
    out_.numbers.back() = static_cast<uint32_t>(number);
  }

  /// A place on a line, with the coordinate whose colour it has.
  struct End {
    Vec3 at;
    size_t coordinate, slot;
  };

  /// What is as wide as it is deep in view is so between its ends too, but not through the camera.
  void add_line(size_t from, size_t to, size_t from_slot, size_t to_slot, size_t number) {
    const End a{coordinate(from), from, from_slot}, b{coordinate(to), to, to_slot};
    if (!is_finite(a.at) || !is_finite(b.at)) return;
    const double depth_a = pen_.depth(a.at), depth_b = pen_.depth(b.at);
    if (pen_.width_per_depth == 0 || depth_a * depth_b >= 0) return add_prism(a, b, number);
    const Vec3 beside = a.at + (b.at - a.at) * (depth_a / (depth_a - depth_b));
    add_prism(a, {beside, from, from_slot}, number);
    add_prism({beside, to, to_slot}, b, number);
  }

  /// What is so long as the camera sees it, in the node's lengths; false where that is no number,
  /// or has no room in single precision.
  bool to_node(Vec3& offset) const {
    constexpr double kMost = 1e30;
    if (!node_from_camera_) return false;
    offset = (*node_from_camera_)(offset);
    return std::abs(offset.x) < kMost && std::abs(offset.y) < kMost && std::abs(offset.z) < kMost;
  }

  /// Of three sides, so that it looks as wide from everywhere to within a seventh.
  void add_prism(const End& from, const End& to, size_t number) {
    const Vec3 &a = from.at, &b = to.at;
    const Vec3 seen = pen_.camera_from_node(b - a);
    if (!(length_squared(b - a) > 0 && length_squared(seen) > 0)) return;
    const double radius_a = pen_.radius(a), radius_b = pen_.radius(b);
    const Vec3 along = normalize(seen);
    const Vec3 x = normalize(cross(along, std::abs(along.x) < .5 ? Vec3{1, 0, 0} : Vec3{0, 1, 0}));
    const Vec3 y = cross(along, x);
    const std::array<Vec3, 3> around{x, x * -0.5 + y * 0.8660254, x * -0.5 - y * 0.8660254};
    std::array<Corner, 3> begin, end;
    std::array<Vec3, 3> at_a, at_b;
    for (size_t k = 0; k < 3; ++k) {
      at_a[k] = around[k] * radius_a, at_b[k] = around[k] * radius_b;
      if (!to_node(at_a[k]) || !to_node(at_b[k])) return;
    }
    for (size_t k = 0; k < 3; ++k) {
      begin[k] = {add_vertex(a + at_a[k]), static_cast<uint32_t>(from.coordinate),
                  static_cast<uint32_t>(from.slot)};
      end[k] = {add_vertex(b + at_b[k]), static_cast<uint32_t>(to.coordinate),
                static_cast<uint32_t>(to.slot)};
    }
    for (size_t k = 0; k < 3; ++k) {
      const size_t next = (k + 1) % 3;
      const Corner side[] = {begin[k], begin[next], end[next], end[k]};
      add_face(side, number);
    }
    const Corner back[] = {begin[2], begin[1], begin[0]};
    add_face(back, number);
    add_face(end, number);
  }

  /// An octahedron.
  void add_point(size_t i) {
    const Vec3 p = coordinate(i);
    if (!is_finite(p)) return;
    const double radius = pen_.radius(p);
    std::array<Vec3, 6> steps;  // -x +x -y +y -z +z
    for (size_t k = 0; k < 6; ++k) {
      steps[k][static_cast<int>(k / 2)] = k % 2 ? radius : -radius;
      if (!to_node(steps[k])) return;
    }
    std::array<Corner, 6> tips;
    for (size_t k = 0; k < 6; ++k)
      tips[k] = {add_vertex(p + steps[k]), static_cast<uint32_t>(i), static_cast<uint32_t>(i)};
    for (size_t octant = 0; octant < 8; ++octant) {
      const size_t x = octant & 1, y = octant >> 1 & 1, z = octant >> 2;
      const bool even = (x + y + z) % 2 == 0;
      const Corner face[] = {tips[x], tips[(even ? 4 : 2) + (even ? z : y)],
                             tips[(even ? 2 : 4) + (even ? y : z)]};
      add_face(face, i);
    }
  }

  const X3dNode& node_;
  const X3dValues& values_;
  const X3dPen& pen_;
  std::optional<Affine> node_from_camera_;  ///< nothing where the node has no extent
  std::vector<float> coordinates_;
  X3dFaces out_;
};

}  // namespace

double X3dPen::depth(const Vec3& point) const { return -camera_from_node(Point3{} + point).z; }

double X3dPen::radius(const Vec3& point) const {
  constexpr double kLeast = 1e-3;  // of the distance, beside the camera
  const Point3 seen = camera_from_node(Point3{} + point);
  const double deep = std::max(std::abs(seen.z), kLeast * length(seen - Point3{}));
  return (width + width_per_depth * deep) / 2;
}

X3dFaces read_x3d_lines(const X3dNode& node, const X3dValues& values, const X3dPen& pen) {
  return LineBuilder(node, values, pen).make();
}

}  // namespace tessera
