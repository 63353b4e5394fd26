#pragma once

#include <cstdint>
#include <initializer_list>
#include <optional>
#include <vector>

#include "proto/tessera/v1/scene.pb.h"
#include "renderer/math/bounds.h"
#include "renderer/math/transform.h"
#include "scenes/mesh/mesh_data.h"

namespace tessera {

/// How wide points and lines are drawn: so that they look alike wide wherever they are, seen from
/// one camera. Lengths are the camera's, in whose frame it looks along -z.
struct Pen {
  Affine camera_from_node{};
  double width = 0;            ///< at the camera, and everywhere where it has no perspective
  double width_per_depth = 0;  ///< what is added a length along the view

  /// A pen of `scale` times 1/360 of the smaller side of the picture that `view` sees.
  /// `framed_extent`: how far apart about the points are that a view with frame_all sees.
  static Pen for_view(const v1::Camera& view, const Affine& world_from_node, double framed_extent,
                      double scale = 1);
  /// What to frame for points in a box: its diagonal, and some length where that is 0.
  static double extent_of(const Bounds3& box);

  /// Half the width at a point of the node.
  double radius(const Vec3& point) const;
  /// 0 at the camera, below 0 behind it.
  double depth(const Vec3& point) const;
};

/// Draws points as octahedra and lines as prisms of three sides, which look as wide from everywhere
/// to within a seventh. What single precision cannot hold is left out.
class PenStrokes {
 public:
  explicit PenStrokes(const Pen& pen);

  /// A place, and what the caller calls it: the vertices there take over its colour.
  struct End {
    Vec3 at;
    uint32_t source;
  };
  void add_point(const End& at);
  void add_line(const End& a, const End& b);

  /// Of the solids so far: x y z each, and the source of each.
  std::vector<float> positions;
  std::vector<uint32_t> sources;
  /// Faces of 3 or 4 corners, counter-clockwise seen from outside, one after the other.
  std::vector<uint32_t> corners;
  std::vector<uint8_t> face_sizes;

 private:
  void add_prism(const End& from, const End& to);
  bool to_node(Vec3& offset) const;
  uint32_t add_vertex(const Vec3& at, uint32_t source);
  void add_face(std::initializer_list<uint32_t> face);

  Pen pen_;
  std::optional<Affine> node_from_camera_;  ///< nothing where the node has no extent
};

/// The solids of points, where `corners_each` is 1, or of lines, where it is 2, between vertices of
/// a mesh whose triangles are not looked at: they take over its normals, texture coordinates and
/// colours. A corner that is not finite leaves out what it is of.
MeshData draw_strokes(const Pen& pen, const MeshData& vertices,
                      const std::vector<uint32_t>& corners, size_t corners_each);

}  // namespace tessera
