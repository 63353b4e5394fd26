#include "renderer/integrator/path_tracer.h"

#include <algorithm>
#include <cmath>

#include "renderer/integrator/path_numbers.h"
#include "renderer/integrator/path_rows.h"
#include "renderer/integrator/path_vertex.h"
#include "renderer/integrator/surface_point.h"
#include "renderer/math/elementary.h"
#include "renderer/shading/bsdf.h"

namespace tessera {

namespace {

/// kRich: materials may have textures. kPasses: something may let a ray through unbent, or absorb.
template <typename Scatter, bool kRich, bool kPasses>
class PathTracer final : public Integrator {
 public:
  explicit PathTracer(std::shared_ptr<const Scene> scene) : scene_(std::move(scene)) {
    if (kPasses) at_camera_ = media_at_camera(*scene_);
    if (can_follow_paths(*scene_)) rows_ = make_path_rows(*scene_);
  }

  Color background(const Ray& ray) const override {
    return scene_->background.radiance(ray.origin, ray.direction, scene_->lights);
  }

  Color radiance(const Ray& camera_ray, const SampleKey& key, TraceState& state) const override {
    ++state.counters.rays_primary;
    Path path{.ray = camera_ray, .media = at_camera_};
    const SampleStream stream = scene_->sampler->stream(key.x, key.y, key.sample);
    while (follow(path, stream, state)) {
    }
    return path.sum;
  }
  const RowTracer* rows() const override { return rows_.get(); }

 private:
  struct Path {
    Ray ray;
    Color sum = kBlack, throughput = kWhite;
    Media media;                ///< that the ray begins in
    double path_length = 0;     ///< metres from the camera to its origin
    double view_distance = 0;   ///< metres back to the camera or the last bounce, for fog
    double density = 0;         ///< of the ray's direction; 0: there was no other way to go
    double radiance_scale = 1;  ///< of the throughput, what media of other density make of it
    Point3 from{};              ///< where it scattered last
    Vec3 from_normal{};         ///< the geometric one there
    uint32_t bounces = 0;       ///< so far
    uint32_t vertex = 0;        ///< surfaces met so far
  };

  /// Adds what the path's next surface sends along it; false where the path ends.
  /// Also for a row of paths, PathRowFollower::step() in path_row_follower-inl.h, to the bit.
  bool follow(Path& path, const SampleStream& stream, TraceState& state) const {
    const VertexNumbers numbers(stream, path.vertex++, scene_->skips.unread_numbers,
                                state.counters.numbers_skipped);
    if (path.bounces > 0) numbers.draw_ahead();
    Hit hit;
    if (!scene_->surfaces ||
        !scene_->surfaces->closest_hit(path.ray, hit, state.counters.traversal)) {
      add_background(path);
      return false;
    }
    ++state.counters.hits;
    path.path_length += hit.t;
    path.view_distance += hit.t;
    SurfacePoint point(*scene_, hit.instance, path.ray, hit);
    if constexpr (kRich) {
      look_up_textures(*scene_, path.ray, cone_width(state.cone, path.path_length), point,
                       state.counters);
    }
    if constexpr (kPasses) {
      note_media_before(path.media, point);
      if (!is_black(path.media.absorption()))
        path.throughput = path.throughput * transmittance(path.media.absorption(), hit.t);
      if (passes_straight(path, point, hit.t, numbers, state)) {
        if (path.vertex < kMaxPasses) return true;
        ++state.counters.paths_cut;
        return false;
      }
    }
    // As far as the surface is seen; light that comes to it from all sides is as if there were
    // none.
    if (path.density == 0 && scene_->fog.kind != FogKind::none) enter_fog(path);
    add_emission(path, point, hit.primitive);
    if (path.bounces >= scene_->settings.max_depth ||
        point.material->model == MaterialModel::unlit) {
      return false;
    }
    const Scatter scatter({.material = *point.material,
                           .diffuse = surface_diffuse(point),
                           .normal = point.normal,
                           .geometric_normal = point.geometric_normal,
                           .wo = -path.ray.direction,
                           .from_inside = point.is_back});
    RayOrigins origins(point.surface);
    if (scatter.is_smooth()) {
      const PathVertex<kRich, Scatter> vertex{*scene_,
                                              point,
                                              scatter,
                                              origins,
                                              path.media,
                                              path.path_length,
                                              cone_width(state.cone, path.path_length),
                                              state};
      path.sum += path.throughput * vertex.direct_light(numbers);
    }
    return bounce(path, point, scatter, origins, numbers, state.counters);
  }

  /// Whether the path goes on through the surface as if it were not there.
  bool passes_straight(Path& path, const SurfacePoint& point, double t,
                       const VertexNumbers& numbers, TraceState& state) const {
    if (!goes_straight(point, numbers)) return false;
    const double t_max = path.ray.t_max - t;
    pass_into(path.media, point);
    path.ray = spawn_ray(point.surface, path.ray.direction);
    path.ray.t_max = t_max;
    ++state.counters.rays_refraction;
    return true;
  }

  void enter_fog(Path& path) const {
    const double clearness = scene_->fog.clearness(path.view_distance);
    path.sum += path.throughput * scene_->fog.color * (1 - clearness);
    path.throughput = path.throughput * clearness;
  }

  void add_background(Path& path) const {
    path.sum += path.throughput * background(path.ray) *
                background_weight(*scene_, path.density, path.ray.direction);
  }

  void add_emission(Path& path, const SurfacePoint& point, uint32_t primitive) const {
    const Color shine = emission(point);
    if (is_black(shine)) return;
    path.sum +=
        path.throughput * shine *
        emission_weight(*scene_, point, primitive, path.density, {path.from, path.from_normal});
  }

  bool bounce(Path& path, const SurfacePoint& point, const Scatter& scatter, RayOrigins& origins,
              const VertexNumbers& numbers, TraceCounters& counters) const {
    BsdfSample sample;
    if (!choose_way(scatter, path.bounces, numbers, path.throughput, path.radiance_scale, sample,
                    counters))
      return false;
    if constexpr (kPasses) {
      if (sample.is_beyond) pass_into(path.media, point);
    }
    path.ray = origins.spawn(sample.wi);
    path.from = point.surface.point;
    path.from_normal = point.geometric_normal;
    path.density = sample.is_mirror ? 0 : sample.density;
    path.view_distance = 0;
    ++path.bounces;
    return true;
  }

  std::shared_ptr<const Scene> scene_;
  Media at_camera_;
  std::unique_ptr<const RowTracer> rows_;
};

}  // namespace

std::unique_ptr<const Integrator> make_path_tracer(std::shared_ptr<const Scene> scene) {
  const SceneFeatures& features = scene->features;
  if (features.lambert && !features.secondary) {
    return std::make_unique<PathTracer<LambertBsdf, false, false>>(std::move(scene));
  }
  if (!features.rich) return std::make_unique<PathTracer<Bsdf, false, true>>(std::move(scene));
  return std::make_unique<PathTracer<Bsdf, true, true>>(std::move(scene));
}

}  // namespace tessera
