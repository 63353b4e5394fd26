#include "scenes/formats/x3d/x3d_polygons.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <numbers>

#include "renderer/math/elementary.h"
#include "scenes/formats/x3d/x3d_faces.h"
#include "scenes/mesh/mesh_data.h"
#include "scenes/mesh/triangulate.h"
#include "scenes/mesh/vertex_table.h"

namespace tessera {
namespace {

constexpr std::array<std::string_view, 9> kPolygonNodes{
    "IndexedFaceSet",        "IndexedTriangleSet", "IndexedTriangleStripSet",
    "IndexedTriangleFanSet", "IndexedQuadSet",     "TriangleSet",
    "TriangleStripSet",      "TriangleFanSet",     "QuadSet"};

class MeshBuilder {
 public:
  MeshBuilder(const X3dNode& node, const X3dValues& values, bool linear)
      : node_(node), values_(values), linear_(linear) {
    if (const X3dNode* coord = node.child("coord")) points_ = values.floats(*coord, "point", 3);
    faces_ = read_x3d_faces(node, values, points_.size() / 3);
    corners_.resize(faces_.polygons.corners.size());
    for (size_t c = 0; c < corners_.size(); ++c) corners_[c].position = faces_.polygons.corners[c];
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
      const Vec3 area = newell_normal(face_points(f));
      areas_.push_back(ccw_ ? area : -area);
    }
  }

  /// Gives each corner its index into `count` values, by the index field called `name` where the
  /// node has one, else by coordinate or face.
  void assign(uint32_t MeshCorner::*member, std::string_view name, bool per_vertex, size_t count) {
    const auto index = values_.integers(node_, name);
    const X3dField* field = node_.field(name);
    const Polygons& polygons = faces_.polygons;
    for (size_t f = 0; f < polygons.size(); ++f) {
      for (size_t c = polygons.starts[f]; c < polygons.starts[f + 1]; ++c) {
        const size_t slot = per_vertex ? faces_.corner_slots[c] : faces_.numbers[f];
        const bool indexed = !index.values.empty();
        if (indexed && slot >= index.values.size())
          throw values_.document().error(
              field->offset,
              fmt::format("{} of {} ends before face {}", name, describe(node_), faces_.numbers[f]),
              per_vertex ? "an entry for each of coordIndex" : "an entry for each face");
        const int64_t value = indexed      ? index.values[slot]
                              : per_vertex ? polygons.corners[c]
                                           : faces_.numbers[f];
        if (value < 0 || value >= static_cast<int64_t>(count))
          throw values_.document().error(
              indexed ? index.offsets[slot] : node_.offset,
              fmt::format("{} {} in face {} of {}", name, value, faces_.numbers[f],
                          describe(node_)),
              count == 0 ? std::string("values to refer to") : fmt::format("0 to {}", count - 1));
        corners_[c].*member = static_cast<uint32_t>(value);
      }
    }
  }

  void read_colors() {
    const X3dNode* node = node_.child("color");
    if (!node || (node->type != "Color" && node->type != "ColorRGBA")) return;
    const bool alpha = node->type == "ColorRGBA";
    const std::vector<float> values = values_.floats(*node, "color", alpha ? 4 : 3);
    const size_t width = alpha ? 4 : 3;
    for (size_t i = 0; i < values.size(); i += width) {
      for (size_t k = 0; k < 3; ++k) {
        const float c = std::clamp(values[i + k], 0.f, 1.f);
        if (c != values[i + k])
          values_.warnings().add(fmt::format("color of {} outside 0 to 1 is clamped", node->type));
        colors_.push_back(linear_ ? static_cast<float>(linear_from_srgb(c)) : c);
      }
      colors_.push_back(alpha ? std::clamp(values[i + 3], 0.f, 1.f) : 1.f);
    }
    const bool per_vertex = values_.boolean(node_, "colorPerVertex", true);
    assign(&MeshCorner::color, "colorIndex", per_vertex, colors_.size() / 4);
  }

  void read_normals() {
    const bool per_vertex = values_.boolean(node_, "normalPerVertex", true);
    const X3dNode* node = node_.child("normal");
    if (node && node->type == "Normal") {
      normals_ = values_.floats(*node, "vector", 3);
      assign(&MeshCorner::normal, "normalIndex", per_vertex, normals_.size() / 3);
      normalize_all();
      return;
    }
    const bool creased = node_.type == "IndexedFaceSet";
    const double angle = creased      ? values_.number(node_, "creaseAngle", 0)
                         : per_vertex ? std::numbers::pi
                                      : 0;
    if (angle < 0)
      throw values_.document().error(node_.field("creaseAngle")->offset, "a negative creaseAngle",
                                     "0 or more");
    if (angle == 0 || corners_.empty()) return;
    GeneratedNormals made = crease_normals(faces_.polygons, areas_, points_.size() / 3, angle);
    if (made.corner_normal.empty())
      throw values_.document().error(
          node_.offset, fmt::format("too many faces at a point of {}", describe(node_)),
          fmt::format("at most {} where creaseAngle is between 0 and pi", kMaxCreaseFaces));
    normals_ = std::move(made.normals);
    for (size_t c = 0; c < corners_.size(); ++c) corners_[c].normal = made.corner_normal[c];
  }

  void normalize_all() {
    for (size_t i = 0; i < normals_.size(); i += 3) {
      const Vec3 given{normals_[i], normals_[i + 1], normals_[i + 2]};
      const Vec3 unit = given == Vec3{} ? Vec3{0, 0, 1} : normalize(given);
      for (int a = 0; a < 3; ++a) normals_[i + a] = static_cast<float>(unit[a]);
    }
  }

  void read_uvs() {
    const X3dNode* node = node_.child("texCoord");
    if (!node || node->type != "TextureCoordinate" || corners_.empty()) return;
    uvs_ = values_.floats(*node, "point", 2);
    assign(&MeshCorner::uv, "texCoordIndex", true, uvs_.size() / 2);
  }

  void cut_up() {
    std::vector<CornerTriple> triples;
    for (size_t f = 0; f < faces_.polygons.size(); ++f) {
      triples.clear();
      const auto points = face_points(f);
      // Files that call their concave faces convex are common, so every face is looked at.
      if (!triangulate(points, triples))
        throw values_.document().error(
            node_.offset,
            fmt::format("face {} of {} is concave with {} corners", faces_.numbers[f],
                        describe(node_), points.size()),
            fmt::format("at most {}", kMaxConcaveCorners));
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
  const bool linear_;
  bool ccw_ = true;
  std::vector<float> points_, normals_, uvs_, colors_;
  X3dFaces faces_;
  std::vector<MeshCorner> corners_;
  std::vector<Vec3> areas_, face_points_;
  VertexTable vertices_;
  std::vector<uint32_t> triangles_;
};

}  // namespace

bool is_x3d_polygons(std::string_view type) {
  return std::find(kPolygonNodes.begin(), kPolygonNodes.end(), type) != kPolygonNodes.end();
}

X3dMesh build_x3d_mesh(const X3dNode& node, const X3dValues& values, bool linear,
                       BlobStore& blobs) {
  return MeshBuilder(node, values, linear).build(blobs);
}

double linear_from_srgb(double value) {
  return value <= 0.04045 ? value / 12.92 : portable::pow((value + 0.055) / 1.055, 2.4);
}

}  // namespace tessera
