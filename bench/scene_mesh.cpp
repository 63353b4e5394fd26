#include "bench/scene_mesh.h"

#include <spdlog/spdlog.h>

#include <algorithm>

#include "base/error.h"
#include "renderer/scene/read_mesh.h"
#include "renderer/scene/scene_graph.h"

namespace tessera {
namespace {

void append(const TriangleMesh& mesh, const Affine& world_from_mesh, TriangleMesh& out) {
  if (out.positions.size() + mesh.positions.size() > UINT32_MAX)
    throw scene_error("the scene has more vertices than one mesh can number");
  const auto first = static_cast<uint32_t>(out.positions.size());
  for (uint32_t i = 0; i < mesh.positions.size(); ++i) {
    const Point3 p = world_from_mesh(mesh.vertex(i));
    out.positions.push_back(
        {static_cast<float>(p.x), static_cast<float>(p.y), static_cast<float>(p.z)});
  }
  for (const auto& [a, b, c] : mesh.triangles)
    out.triangles.push_back({first + a, first + b, first + c});
}

}  // namespace

TriangleMesh to_triangles(const MeshData& mesh) {
  TriangleMesh out;
  const auto& p = mesh.positions;
  for (size_t i = 0; i < p.size(); i += 3) out.positions.push_back({p[i], p[i + 1], p[i + 2]});
  const auto& t = mesh.triangles;
  for (size_t i = 0; i < t.size(); i += 3) out.triangles.push_back({t[i], t[i + 1], t[i + 2]});
  drop_degenerate(out);
  return out;
}

TriangleMesh mesh_of_scene(const v1::Scene& scene, const BlobStore& blobs) {
  const SceneGraph graph = unfold_graph(scene, scene.settings().time(), Affine{});
  TriangleMesh whole;
  size_t left_out = 0;
  for (const GraphInstance& instance : graph.instances) {
    const GraphShape& shape = graph.shapes[instance.shape];
    if (!shape.shape->has_mesh()) {
      ++left_out;
      continue;
    }
    const size_t materials = static_cast<size_t>(std::max(1, shape.shape->materials_size()));
    append(read_mesh({.kind = shape.path.c_str()}, shape.shape->mesh(), blobs, materials),
           instance.world_from_object, whole);
  }
  drop_degenerate(whole);
  if (whole.triangles.empty()) throw scene_error("the scene has no triangles to trace");
  if (left_out > 0) spdlog::warn("{} shapes that are no meshes: left out", left_out);
  return whole;
}

}  // namespace tessera
