#include "scenes/mesh/pen.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <utility>

#include "renderer/math/elementary.h"
#include "scenes/import/to_affine.h"

namespace tessera {
namespace {

/// Rows of `width` numbers, one for each of the `sources`, which are numbers of rows of `from`.
std::vector<float> gather(const std::vector<float>& from, size_t width,
                          const std::vector<uint32_t>& sources) {
  std::vector<float> out;
  if (from.empty()) return out;
  out.reserve(sources.size() * width);
  for (const uint32_t source : sources) {
    const auto row = from.begin() + static_cast<ptrdiff_t>(source * width);
    out.insert(out.end(), row, row + static_cast<ptrdiff_t>(width));
  }
  return out;
}

}  // namespace

Pen Pen::for_view(const v1::Camera& view, const Affine& world_from_node, double framed_extent,
                  double scale) {
  // A prism shows four fifths of its width: one to two pixels of a picture of 450 to 900.
  const double share = 1. / 360 * scale;
  Pen out{.camera_from_node = inverse(to_affine(view.world_from_camera())) * world_from_node};
  if (view.frame_all()) {
    out.width = share * framed_extent;
  } else if (view.has_orthographic()) {
    const v1::Orthographic& window = view.orthographic();
    constexpr double kDefaultSide = 2;
    const double side = window.has_min_x() ? std::min(window.max_x() - window.min_x(),
                                                      window.max_y() - window.min_y())
                                           : kDefaultSide;
    out.width = share * side;
  } else {
    const double half = portable::radians(view.perspective().field_of_view()) / 2;
    out.width_per_depth = share * 2 * portable::sin(half) / portable::cos(half);
  }
  return out;
}

double Pen::extent_of(const Bounds3& box) {
  if (box.empty()) return 0;
  const double extent = length(box.diagonal());
  // A point alone is as large as single precision tells apart where it lies, and more.
  return extent > 0 ? extent : 1 + length(box.center() - Point3{});
}

double Pen::depth(const Vec3& point) const { return -camera_from_node(Point3{} + point).z; }

double Pen::radius(const Vec3& point) const {
  constexpr double kLeast = 1e-3;  // of the distance, beside the camera
  const Point3 seen = camera_from_node(Point3{} + point);
  const double deep = std::max(std::abs(seen.z), kLeast * length(seen - Point3{}));
  return (width + width_per_depth * deep) / 2;
}

PenStrokes::PenStrokes(const Pen& pen) : pen_(pen) {
  const double extent = pen.camera_from_node.determinant();
  if (extent != 0 && std::isfinite(extent)) node_from_camera_ = inverse(pen.camera_from_node);
}

/// An octahedron.
void PenStrokes::add_point(const End& at) {
  if (!is_finite(at.at)) return;
  const double radius = pen_.radius(at.at);
  std::array<Vec3, 6> steps;  // -x +x -y +y -z +z
  for (size_t k = 0; k < 6; ++k) {
    steps[k][static_cast<int>(k / 2)] = k % 2 ? radius : -radius;
    if (!to_node(steps[k])) return;
  }
  std::array<uint32_t, 6> tips;
  for (size_t k = 0; k < 6; ++k) tips[k] = add_vertex(at.at + steps[k], at.source);
  for (size_t octant = 0; octant < 8; ++octant) {
    const size_t x = octant & 1, y = octant >> 1 & 1, z = octant >> 2;
    const bool even = (x + y + z) % 2 == 0;
    add_face(
        {tips[x], tips[(even ? 4 : 2) + (even ? z : y)], tips[(even ? 2 : 4) + (even ? y : z)]});
  }
}

/// What is as wide as it is deep in view is so between its ends too, but not through the camera.
void PenStrokes::add_line(const End& a, const End& b) {
  if (!is_finite(a.at) || !is_finite(b.at)) return;
  const double depth_a = pen_.depth(a.at), depth_b = pen_.depth(b.at);
  if (pen_.width_per_depth == 0 || depth_a * depth_b >= 0) return add_prism(a, b);
  const Vec3 beside = a.at + (b.at - a.at) * (depth_a / (depth_a - depth_b));
  add_prism(a, {beside, a.source});
  add_prism({beside, b.source}, b);
}

void PenStrokes::add_prism(const End& from, const End& to) {
  const Vec3 &a = from.at, &b = to.at;
  const Vec3 seen = pen_.camera_from_node(b - a);
  if (!(length_squared(b - a) > 0 && length_squared(seen) > 0)) return;
  const double radius_a = pen_.radius(a), radius_b = pen_.radius(b);
  const Vec3 along = normalize(seen);
  const Vec3 x = normalize(cross(along, std::abs(along.x) < .5 ? Vec3{1, 0, 0} : Vec3{0, 1, 0}));
  const Vec3 y = cross(along, x);
  const std::array<Vec3, 3> around{x, x * -0.5 + y * 0.8660254, x * -0.5 - y * 0.8660254};
  std::array<uint32_t, 3> begin, end;
  std::array<Vec3, 3> at_a, at_b;
  for (size_t k = 0; k < 3; ++k) {
    at_a[k] = around[k] * radius_a, at_b[k] = around[k] * radius_b;
    if (!to_node(at_a[k]) || !to_node(at_b[k])) return;
  }
  for (size_t k = 0; k < 3; ++k) {
    begin[k] = add_vertex(a + at_a[k], from.source);
    end[k] = add_vertex(b + at_b[k], to.source);
  }
  for (size_t k = 0; k < 3; ++k) {
    const size_t next = (k + 1) % 3;
    add_face({begin[k], begin[next], end[next], end[k]});
  }
  add_face({begin[2], begin[1], begin[0]});
  add_face({end[0], end[1], end[2]});
}

/// What is so long as the camera sees it, in the node's lengths; false where that is no number, or
/// does not fit into single precision.
bool PenStrokes::to_node(Vec3& offset) const {
  constexpr double kMost = 1e30;
  if (!node_from_camera_) return false;
  offset = (*node_from_camera_)(offset);
  return std::abs(offset.x) < kMost && std::abs(offset.y) < kMost && std::abs(offset.z) < kMost;
}

uint32_t PenStrokes::add_vertex(const Vec3& at, uint32_t source) {
  for (int a = 0; a < 3; ++a) positions.push_back(static_cast<float>(at[a]));
  sources.push_back(source);
  return static_cast<uint32_t>(sources.size() - 1);
}

void PenStrokes::add_face(std::initializer_list<uint32_t> face) {
  corners.insert(corners.end(), face);
  face_sizes.push_back(static_cast<uint8_t>(face.size()));
}

MeshData draw_strokes(const Pen& pen, const MeshData& vertices,
                      const std::vector<uint32_t>& corners, size_t corners_each) {
  const auto end = [&](uint32_t vertex) -> PenStrokes::End {
    const float* const p = &vertices.positions[size_t{vertex} * 3];
    return {{p[0], p[1], p[2]}, vertex};
  };
  PenStrokes strokes(pen);
  for (size_t i = 0; i + corners_each <= corners.size(); i += corners_each) {
    if (corners_each == 1)
      strokes.add_point(end(corners[i]));
    else
      strokes.add_line(end(corners[i]), end(corners[i + 1]));
  }
  MeshData out;
  out.normals = gather(vertices.normals, 3, strokes.sources);
  out.uvs = gather(vertices.uvs, 2, strokes.sources);
  out.second_uvs = gather(vertices.second_uvs, 2, strokes.sources);
  out.colors = gather(vertices.colors, 4, strokes.sources);
  out.positions = std::move(strokes.positions);
  const uint32_t* corner = strokes.corners.data();
  for (const uint8_t size : strokes.face_sizes) {
    for (uint8_t c = 2; c < size; ++c)
      out.triangles.insert(out.triangles.end(), {corner[0], corner[c - 1], corner[c]});
    corner += size;
  }
  return out;
}

}  // namespace tessera
