#pragma once

#include <memory>
#include <mutex>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "proto/tessera/v1/farm.pb.h"
#include "proto/tessera/v1/scene.pb.h"
#include "proto/wire/blob_store.h"
#include "query/ray_arrays.h"
#include "renderer/camera/camera.h"
#include "renderer/scene/scene_builder.h"

namespace tessera {

/// Ray queries on a scene's geometry. A surface is met whatever its material lets through and
/// whether or not it casts shadows; hidden nodes are not there. Immutable: any number of threads
/// may ask at once. Functions that return bool, or an optional, say false, or nothing, where they
/// were cancelled; the arrays then hold some results. A t_min below 0, or a hit that this scene
/// cannot have, is a usage error. Memory of a call is its results and some KiB a thread, but for
/// all_hits(), which needs twice its results.
class RayQueries {
 public:
  /// Of `frame` only size, camera, time and accelerator count. Materials are known by name alone:
  /// neither they nor textures and lights are read. Throws a scene error as build_scene() does.
  RayQueries(const v1::Scene& description, const BlobStore& blobs, const v1::FrameSettings& frame,
             int threads);
  ~RayQueries();

  bool closest_hits(const RayArrays& rays, const HitArrays& hits,
                    const QueryControl& control = {}) const;
  /// 1 where closest_hits() would find a hit, else 0.
  bool occluded(const RayArrays& rays, uint8_t* result, const QueryControl& control = {}) const;
  /// Each (instance, primitive) once for each real intersection.
  std::optional<AllHits> all_hits(const RayArrays& rays, const QueryControl& control = {}) const;
  /// Passages from front to back less those from back to front. A ray through an edge or vertex of
  /// a mesh counts for one of the triangles there. rays.cull does not count.
  bool crossings(const RayArrays& rays, int32_t* result, const QueryControl& control = {}) const;
  /// What is inside a mesh that is open.
  enum class OpenInside {
    nothing,
    by_winding,  ///< what it goes around more than half, by its generalised winding number
  };
  /// 1 for points inside some solid or closed mesh; `among` some instances, where these are given.
  /// One of these without an inside is a usage error. Points on a surface are on either side, the
  /// same each time.
  bool contains(size_t count, const VectorRows& points,
                const std::optional<std::vector<uint32_t>>& among, OpenInside open, uint8_t* result,
                const QueryControl& control = {}) const;
  struct OpenShape {
    uint32_t instance = 0;
    bool is_mesh = false;       ///< else a solid, parts of whose surface are left out
    size_t edges = 0;           ///< at which a mesh is open
    uint32_t from = 0, to = 0;  ///< the vertices of one of them
  };
  /// The meshes and solids that are open, in the order of their instances.
  std::vector<OpenShape> open_shapes() const;

  /// What lies at hits that closest_hits() or all_hits() found for these rays.
  bool attributes(const RayArrays& rays, const ConstHitArrays& hits, const AttributeArrays& out,
                  const QueryControl& control = {}) const;
  /// Three numbers a hit: where a ray starts that leaves the hit's surface in the direction given
  /// for it, so that it does not meet that surface there; NaN where there is no hit.
  bool spawn(const RayArrays& rays, const ConstHitArrays& hits, const VectorRows& directions,
             double* origins, const QueryControl& control = {}) const;

  /// The camera of that name for a frame of that size; an empty name and sizes of 0 stand for those
  /// of the constructor.
  Camera camera(const std::string& name = {}, int width = 0, int height = 0) const;
  /// The size of the constructor's frame in pixels.
  int width() const { return scene_->settings.width; }
  int height() const { return scene_->settings.height; }
  /// Around all that ends somewhere; empty where nothing does.
  Bounds3 bounds() const;
  /// By instance: of its node, or else of its shape.
  const std::vector<std::string>& instance_names() const { return names_.instances; }
  /// By AttributeArrays::material; empty for the default material.
  const std::vector<std::string>& material_names() const { return materials_; }
  AcceleratorStatistics statistics() const;
  const Scene& scene() const { return *scene_; }
  /// What the constructor was given, without what these queries do not need of it.
  const v1::Scene& description() const { return description_; }
  const BlobStore& blobs() const { return blobs_; }

 private:
  struct Insides;

  const Insides& insides() const;
  void find_all(const Ray& ray, std::vector<Hit>& hits) const;
  uint32_t row_of(const Hit& hit) const;
  /// The hit of entry `i`, in the scene's numbers; nothing where none was hit.
  std::optional<Hit> hit_at(const ConstHitArrays& hits, size_t i) const;

  v1::Scene description_;
  BlobStore blobs_;
  v1::FrameSettings frame_;
  int threads_;
  SceneNames names_;
  std::shared_ptr<const Scene> scene_;
  std::vector<std::string> materials_;      ///< each name once
  std::vector<uint32_t> material_of_slot_;  ///< into materials_, one each of Scene::material_slots
  /// Where one mesh that stands as it is makes up the scene: its triangles.
  const Accelerator* only_mesh_ = nullptr;
  double reach_ = 0;  ///< how far apart the origins of rays that are traced together may be
  /// By instance, where some mesh lost triangles: TriangleMesh::original_numbers, or null.
  std::vector<const std::vector<uint32_t>*> rows_;
  std::unique_ptr<Insides> insides_;
};

}  // namespace tessera
