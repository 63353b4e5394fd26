#include "scenes/formats/x3d/geometry/x3d_polygons.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <map>
#include <numbers>

#include "base/plural.h"
#include "renderer/math/bounds.h"
#include "renderer/math/encodings.h"
#include "scenes/formats/x3d/geometry/x3d_faces.h"
#include "scenes/mesh/mesh_data.h"
#include "scenes/mesh/triangulate.h"
#include "scenes/mesh/vertex_table.h"
#include "scenes/mesh/weld.h"

namespace tessera {
namespace {

using ReadFaces = X3dFaces (*)(const X3dNode&, const X3dValues&);

/// How each node's faces are read.
ReadFaces find_reader(std::string_view type) {
  static const std::map<std::string_view, ReadFaces> kReaders{
      {"IndexedFaceSet", &read_x3d_polygons},
      {"IndexedTriangleSet", &read_x3d_polygons},
      {"IndexedTriangleStripSet", &read_x3d_polygons},
      {"IndexedTriangleFanSet", &read_x3d_polygons},
      {"IndexedQuadSet", &read_x3d_polygons},
      {"TriangleSet", &read_x3d_polygons},
      {"TriangleStripSet", &read_x3d_polygons},
      {"TriangleFanSet", &read_x3d_polygons},
      {"QuadSet", &read_x3d_polygons},
      {"ElevationGrid", &read_x3d_grid},
      {"Extrusion", &read_x3d_extrusion},
      {"Text", &read_x3d_text}};
  const auto at = kReaders.find(type);
  return at == kReaders.end() ? nullptr : at->second;
}

class MeshBuilder {
 public:
  MeshBuilder(const X3dNode& node, const X3dValues& values, const X3dMeshOptions& options)
      : node_(node),
        values_(values),
        options_(options),
        faces_(is_x3d_lines(node.type) ? read_x3d_lines(node, values, options.pen)
                                       : find_reader(node.type)(node, values)),
        points_(faces_.points) {
    corners_.resize(faces_.polygons.corners.size());
    for (size_t c = 0; c < corners_.size(); ++c) corners_[c].position = faces_.polygons.corners[c];
    for (size_t f = 0; f < faces_.polygons.size(); ++f)
      is_far_.push_back(
          !std::ranges::all_of(face_points(f), [](const Vec3& p) { return is_finite(p); }));
    for (float& coordinate : faces_.points)
      if (!std::isfinite(coordinate)) coordinate = 0;  // of no face that is shown
  }

  X3dMesh build(BlobStore& blobs) {
    X3dMesh out;
    measure_faces();
    read_colors();
    read_normals();
    read_uvs();
    cut_up();
    out.empty = triangles_.empty();
    if (out.empty) return out;
    MeshData mesh;
    mesh.positions = vertices_.gather(points_, 3, &MeshCorner::position);
    if (!normals_.empty()) mesh.normals = vertices_.gather(normals_, 3, &MeshCorner::normal);
    if (!uvs_.empty()) mesh.uvs = vertices_.gather(uvs_, 2, &MeshCorner::uv);
    if (!colors_.empty()) mesh.colors = vertices_.gather(colors_, 4, &MeshCorner::color);
    mesh.triangles = std::move(triangles_);
    out.has_colors = !colors_.empty();
    out.has_color_alpha = has_color_alpha_;
    out.mesh = store_mesh(std::move(mesh), blobs);
    return out;
  }

 private:
  std::span<const Vec3> face_points(size_t face) {
    face_points_.clear();
    for (const uint32_t p : faces_.polygons.face(face))
      face_points_.push_back(
          {points_[3 * size_t{p}], points_[3 * size_t{p} + 1], points_[3 * size_t{p} + 2]});
    return face_points_;
  }

  void measure_faces() {
    ccw_ = values_.boolean(node_, "ccw", true);
    areas_.reserve(faces_.polygons.size());
    for (size_t f = 0; f < faces_.polygons.size(); ++f) {
      const Vec3 area = is_far_[f] ? Vec3{} : newell_normal(face_points(f));
      areas_.push_back(ccw_ ? area : -area);
    }
  }

  uint32_t coordinate(size_t corner) const {
    return faces_.corner_coordinates.empty() ? faces_.polygons.corners[corner]
                                             : faces_.corner_coordinates[corner];
  }

  /// Gives each corner its index into `count` values, by the index field called `name` where the
  /// node has one, else by coordinate or face. False where there is no value at all.
  bool assign(uint32_t MeshCorner::*member, std::string_view name, bool per_vertex, size_t count) {
    const auto index = values_.integers(node_, name);
    const X3dField* field = node_.field(name);
    const Polygons& polygons = faces_.polygons;
    const char* const kExpected = per_vertex ? "a value for each corner" : "a value for each face";
    if (count == 0 && polygons.size() > 0) {
      values_.repair(node_.offset, fmt::format("no values for {} of {}", name, describe(node_)),
                     kExpected, "it is left out");
      return false;
    }
    for (size_t f = 0; f < polygons.size(); ++f) {
      for (size_t c = polygons.starts[f]; c < polygons.starts[f + 1]; ++c) {
        const bool indexed = !index.values.empty() && !faces_.corner_slots.empty();
        size_t slot = !indexed ? 0 : per_vertex ? faces_.corner_slots[c] : faces_.numbers[f];
        if (indexed && slot >= index.values.size()) {
          values_.repair(
              field->offset,
              fmt::format("{} of {} ends before face {}", name, describe(node_), faces_.numbers[f]),
              kExpected, "its last one is taken");
          slot = index.values.size() - 1;
        }
        int64_t value = indexed      ? index.values[slot]
                        : per_vertex ? coordinate(c)
                                     : faces_.numbers[f];
        if (value < 0 || value >= static_cast<int64_t>(count)) {
          values_.repair(indexed ? index.offsets[slot] : node_.offset,
                         fmt::format("{} {} in face {} of {}, of {}", name, value,
                                     faces_.numbers[f], describe(node_), counted(count, "value")),
                         "an index of a value", "the nearest one is taken");
          value = std::clamp<int64_t>(value, 0, static_cast<int64_t>(count) - 1);
        }
        corners_[c].*member = static_cast<uint32_t>(value);
      }
    }
    return true;
  }

  void read_colors() {
    const X3dNode* node = node_.child("color");
    if (!node || (node->type != "Color" && node->type != "ColorRGBA")) return;
    const bool alpha = node->type == "ColorRGBA";
    const std::vector<float> values = values_.floats(*node, "color", alpha ? 4 : 3);
    const size_t width = alpha ? 4 : 3;
    for (size_t i = 0; i < values.size(); i += width) {
      for (size_t k = 0; k < width; ++k) {
        const float c = std::clamp(values[i + k], 0.f, 1.f);
        if (c != values[i + k])
          values_.repair(*node, "color", "0 to 1", "the nearest colour is taken");
        colors_.push_back(options_.linear && k < 3 ? static_cast<float>(srgb_to_linear(c)) : c);
      }
      if (!alpha) colors_.push_back(1);
    }
    const bool per_vertex = values_.boolean(node_, "colorPerVertex", true);
    has_color_alpha_ =
        assign(&MeshCorner::color, "colorIndex", per_vertex, colors_.size() / 4) && alpha;
  }

  void read_normals() {
    const bool per_vertex = values_.boolean(node_, "normalPerVertex", true);
    const X3dNode* node = node_.child("normal");
    if (node && node->type == "Normal") {
      normals_ = values_.floats(*node, "vector", 3);
      normalize_all();
      if (assign(&MeshCorner::normal, "normalIndex", per_vertex, normals_.size() / 3)) return;
    }
    if (is_x3d_lines(node_.type)) return;
    if (node_.type == "Text") return;
    const bool creased = node_.type == "IndexedFaceSet" || node_.type == "ElevationGrid" ||
                         node_.type == "Extrusion";
    const double angle =
        creased      ? values_.clamped(node_, "creaseAngle", values_.angle(node_, "creaseAngle", 0))
        : per_vertex ? std::numbers::pi
                     : 0;
    if (angle == 0 || corners_.empty()) return;
    GeneratedNormals made = crease_normals(welded(), areas_, points_.size() / 3, angle);
    if (made.corner_normal.empty())
      return values_.repair(
          node_.offset, fmt::format("too many faces at a point of {}", describe(node_)),
          fmt::format("at most {} where creaseAngle is between 0 and pi", kMaxCreaseFaces),
          "its faces are flat");
    normals_ = std::move(made.normals);
    for (size_t c = 0; c < corners_.size(); ++c) corners_[c].normal = made.corner_normal[c];
  }

  /// The faces over points that stand for those near them.
  Polygons welded() const {
    Polygons polygons = faces_.polygons;
    if (options_.weld > 0) {
      const std::vector<uint32_t> stands_for = weld(points_, options_.weld);
      for (uint32_t& corner : polygons.corners) corner = stands_for[corner];
    }
    return polygons;
  }

  void normalize_all() {
    for (size_t i = 0; i < normals_.size(); i += 3) {
      const Vec3 given{normals_[i], normals_[i + 1], normals_[i + 2]};
      if (given == Vec3{})
        values_.repair(*node_.child("normal"), "vector", "vectors other than 0 0 0",
                       "0 0 1 is taken");
      const Vec3 unit = given == Vec3{} ? Vec3{0, 0, 1} : normalize(given);
      for (int a = 0; a < 3; ++a) normals_[i + a] = static_cast<float>(unit[a]);
    }
  }

  void read_uvs() {
    const X3dNode* node = node_.child("texCoord");
    if (node && node->type == "MultiTextureCoordinate") node = node->child("texCoord");
    if (corners_.empty()) return;
    if (node && node->type == "TextureCoordinate") {
      uvs_ = values_.floats(*node, "point", 2);
      if (assign(&MeshCorner::uv, "texCoordIndex", true, uvs_.size() / 2)) return;
    }
    if (options_.textured && faces_.corner_uvs.empty()) {
      make_box_uvs();
    } else if (options_.textured) {
      uvs_ = std::move(faces_.uvs);
      for (size_t c = 0; c < corners_.size(); ++c) corners_[c].uv = faces_.corner_uvs[c];
    }
  }

  /// S along the longest side of the bounding box, T along the second longest, in one scale.
  void make_box_uvs() {
    Bounds3 box;
    for (const MeshCorner& c : corners_) box.extend(point(c.position));
    const Vec3 size = box.diagonal();
    int s = 0;
    for (int a = 1; a < 3; ++a)
      if (size[a] > size[s]) s = a;
    int t = s == 0 ? 1 : 0;
    for (int a = t + 1; a < 3; ++a)
      if (a != s && size[a] > size[t]) t = a;
    for (size_t p = 0; p < points_.size() / 3; ++p) {
      for (const int a : {s, t}) {
        const double along = points_[3 * p + static_cast<size_t>(a)] - box.min[a];
        uvs_.push_back(static_cast<float>(size[s] > 0 ? along / size[s] : 0));
      }
    }
    for (MeshCorner& c : corners_) c.uv = c.position;
  }

  Point3 point(uint32_t p) const {
    return {points_[3 * size_t{p}], points_[3 * size_t{p} + 1], points_[3 * size_t{p} + 2]};
  }

  void cut_up() {
    std::vector<CornerTriple> triples;
    for (size_t f = 0; f < faces_.polygons.size(); ++f) {
      triples.clear();
      if (is_far_[f]) {
        values_.repair(
            node_.offset,
            fmt::format("face {} of {}, which is too far", faces_.numbers[f], describe(node_)),
            "points in the range of single precision", "it is left out");
        continue;
      }
      const auto points = face_points(f);
      // Files that call their concave faces convex are common, so every face is looked at.
      if (!triangulate(points, triples)) {
        values_.repair(node_.offset,
                       fmt::format("face {} of {} is concave with {} corners", faces_.numbers[f],
                                   describe(node_), points.size()),
                       fmt::format("at most {}", kMaxConcaveCorners), "it is left out");
        continue;
      }
      const size_t first = faces_.polygons.starts[f];
      for (const CornerTriple& t : triples) {
        const MeshCorner &a = corners_[first + t[0]], &b = corners_[first + t[1]],
                         &c = corners_[first + t[2]];
        if (a.position == b.position || b.position == c.position || c.position == a.position)
          continue;
        triangles_.push_back(vertices_.add(a));
        triangles_.push_back(vertices_.add(ccw_ ? b : c));
        triangles_.push_back(vertices_.add(ccw_ ? c : b));
      }
    }
  }

  const X3dNode& node_;
  const X3dValues& values_;
  const X3dMeshOptions& options_;
  bool ccw_ = true, has_color_alpha_ = false;
  X3dFaces faces_;
  const std::vector<float>& points_;
  std::vector<float> normals_, uvs_, colors_;
  std::vector<MeshCorner> corners_;
  std::vector<bool> is_far_;  ///< of each face: whether single precision cannot hold its points
  std::vector<Vec3> areas_, face_points_;
  VertexTable vertices_;
  std::vector<uint32_t> triangles_;
};

}  // namespace

bool is_x3d_mesh(std::string_view type) { return is_x3d_lines(type) || find_reader(type); }

bool is_x3d_lines(std::string_view type) {
  return type == "IndexedLineSet" || type == "LineSet" || type == "PointSet";
}

X3dMesh build_x3d_mesh(const X3dNode& node, const X3dValues& values, const X3dMeshOptions& options,
                       BlobStore& blobs) {
  return MeshBuilder(node, values, options).build(blobs);
}

}  // namespace tessera
