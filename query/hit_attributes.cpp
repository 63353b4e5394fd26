// What lies at hits that were found before.
#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <limits>

#include "base/error.h"
#include "query/each_ray.h"
#include "query/ray_queries.h"
#include "renderer/accel/mesh_shape.h"

namespace tessera {
namespace {

constexpr double kNan = std::numeric_limits<double>::quiet_NaN();
constexpr Vec3 kNowhere{kNan, kNan, kNan};

void put(double* array, size_t i, const Vec3& v) {
  if (!array) return;
  for (int a = 0; a < 3; ++a) array[3 * i + static_cast<size_t>(a)] = v[a];
}

SurfaceInteraction surface_of(const std::vector<Instance>& instances, Ray ray, Hit hit) {
  hit.t = std::ldexp(hit.t, scale_if_extreme(ray));
  return surface_at(instances, ray, hit);
}

}  // namespace

std::optional<Hit> RayQueries::hit_at(const ConstHitArrays& hits, size_t i) const {
  if (hits.instance[i] == kNoInstance) return std::nullopt;
  const auto refuse = [&](const char* field, uint32_t found, size_t limit) {
    throw usage_error(
        fmt::format("{}[{}]: {}; expected a hit of this scene, below {}", field, i, found, limit));
  };
  const std::vector<Instance>& instances = scene_->instances;
  Hit hit{hits.t[i], hits.uv[2 * i], hits.uv[2 * i + 1], hits.instance[i], hits.primitive[i]};
  if (hit.instance >= instances.size()) refuse("instance", hit.instance, instances.size());
  const size_t primitives = instances[hit.instance].shape->primitive_count();
  if (const std::vector<uint32_t>* rows = rows_.empty() ? nullptr : rows_[hit.instance]) {
    const auto found = std::lower_bound(rows->begin(), rows->end(), hit.primitive);
    if (found == rows->end() || *found != hit.primitive)
      refuse("primitive", hit.primitive, rows->back() + size_t{1});
    hit.primitive = static_cast<uint32_t>(found - rows->begin());
  }
  if (hit.primitive >= primitives) refuse("primitive", hit.primitive, primitives);
  return hit;
}

bool RayQueries::attributes(const RayArrays& rays, const ConstHitArrays& hits,
                            const AttributeArrays& out, const QueryControl& control) const {
  return for_each_chunk(rays.count, control, [&](size_t begin, size_t end) {
    for (size_t i = begin; i < end; ++i) {
      SurfaceInteraction s;
      s.point = Point3{} + kNowhere;
      s.point_error = kNowhere;
      s.geometric_normal = s.shading_normal = to_normal(kNowhere);
      s.uv = {kNan, kNan};
      uint32_t material = kNoInstance;
      if (const std::optional<Hit> hit = hit_at(hits, i)) {
        s = surface_of(scene_->instances, rays[i], *hit);
        const InstanceShading& of = scene_->shading[hit->instance];
        material =
            material_of_slot_[of.first_material + std::min(s.material, of.material_count - 1)];
      }
      put(out.point, i, s.point - Point3{});
      put(out.point_error, i, s.point_error);
      put(out.normal, i, static_cast<Vec3>(s.geometric_normal));
      put(out.shading_normal, i, static_cast<Vec3>(s.shading_normal));
      if (out.texcoord) out.texcoord[2 * i] = s.uv.x, out.texcoord[2 * i + 1] = s.uv.y;
      if (out.material) out.material[i] = material;
    }
  });
}

bool RayQueries::spawn(const RayArrays& rays, const ConstHitArrays& hits,
                       const VectorRows& directions, double* origins,
                       const QueryControl& control) const {
  return for_each_chunk(rays.count, control, [&](size_t begin, size_t end) {
    for (size_t i = begin; i < end; ++i) {
      const std::optional<Hit> hit = hit_at(hits, i);
      if (!hit) {
        put(origins, i, kNowhere);
        continue;
      }
      const SurfaceInteraction s = surface_of(scene_->instances, rays[i], *hit);
      put(origins, i, RayOrigins(s).towards(directions[i]) - Point3{});
    }
  });
}

}  // namespace tessera
