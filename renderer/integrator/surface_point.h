#pragma once

#include <optional>

#include "renderer/integrator/integrator.h"
#include "renderer/scene/scene.h"
#include "renderer/shading/media.h"
#include "renderer/shapes/surface_interaction.h"

namespace tessera {

/// A hit, seen from where the ray came: the material of the side that is seen, and the normals of
/// that side. The geometric one faces the viewer; the shading one may not.
struct SurfacePoint {
  /// What lies at the hit, with the material's constants.
  SurfacePoint(const Scene& scene, uint32_t instance_index, const Ray& ray, const Hit& hit);
  /// A surface that is known already, met along `direction`.
  SurfacePoint(const Scene& scene, const SurfaceInteraction& surface, const Vec3& direction);
  SurfacePoint(const SurfacePoint&) = delete;
  SurfacePoint& operator=(const SurfacePoint&) = delete;

  SurfaceInteraction surface;
  const Material* material = nullptr;  ///< the scene's, or `resolved`
  Vec3 geometric_normal;               ///< unit, towards the viewer
  Vec3 normal;                         ///< unit, for shading
  /// Per metre, of what the material that is seen would fill a solid with; the scene's.
  const Color* absorption = nullptr;
  bool is_back = false;              ///< the ray met the back of the surface: it was inside
  bool is_hidden = false;            ///< a back face that is not there
  std::optional<Material> resolved;  ///< the material with its textures looked up
};

/// Looks the material's textures up at the point, where it has any. Only scenes with rich materials
/// need it. `width`, in metres, is that of the patch across the ray that the point stands for.
void look_up_textures(const Scene& scene, const Ray& ray, double width, SurfacePoint& point,
                      TraceCounters& counters);

/// What a ray to the point goes through, which was in `media` as far as is known: a ray that meets
/// a back face came through that solid.
inline void note_media_before(Media& media, const SurfacePoint& point) {
  if (point.is_back && !point.is_hidden && fills(*point.material))
    media.note_inside(point.surface.instance, *point.absorption);
}
/// From before the point to behind it.
inline void pass_into(Media& media, const SurfacePoint& point) {
  if (point.is_hidden || !fills(*point.material)) return;
  if (point.is_back) {
    media.leave(point.surface.instance);
  } else {
    media.enter(point.surface.instance, *point.absorption);
  }
}
inline Media media_beyond(Media media, const SurfacePoint& point) {
  pass_into(media, point);
  return media;
}
/// What the camera is inside of, told by the surfaces that the middle of the view meets.
Media media_at_camera(const Scene& scene);

/// How much of what is behind the surface comes straight through, and the rest. For a refracting
/// material 0 and 1: what it lets through is bent.
struct Coverage {
  double through = 0, covered = 1;
};
Coverage straight_coverage(const SurfacePoint& point);

/// The material's diffuse colour with the vertex colour.
inline Color surface_diffuse(const SurfacePoint& point) {
  const Material& material = *point.material;
  if (!point.surface.has_vertex_color) return material.diffuse;
  return material.vertex_color_replaces_diffuse ? point.surface.vertex_color
                                                : material.diffuse * point.surface.vertex_color;
}
/// The radiance that the surface itself sends to the viewer.
Color emission(const SurfacePoint& point);
/// The same of `there`, a point of a surface of `instance`, towards `from`, with its textures.
/// `width` as for look_up_textures(). Black where it is not found again.
Color looked_up_emission(const Scene& scene, uint32_t instance, const SurfaceSample& there,
                         const Point3& from, double width, TraceCounters& counters);

}  // namespace tessera
