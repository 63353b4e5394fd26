#include "renderer/integrator/surface_point.h"

#include <algorithm>

namespace tessera {

namespace {

/// Where a ray cone `width` wide meets the surface: across the ray, and along it on the surface.
void add_patch(const Ray& ray, double width, const Vec3& n, TextureCoordinate& world) {
  constexpr double kMostStretched = 64;
  const Vec3 d = normalize(ray.direction);
  const double cosine = std::max(std::abs(dot(d, n)), 1 / kMostStretched);
  const Vec3 across = cross(n, d);
  const Vec3 unit = length_squared(across) > 1e-20
                        ? normalize(across)
                        : normalize(cross(n, std::abs(n.x) < 0.5 ? Vec3{1, 0, 0} : Vec3{0, 1, 0}));
  world.a = unit * width;
  world.b = cross(n, unit) * (width / cosine);
}

Vec3 transposed(const Affine& m, const Vec3& v) {
  return {m.m[0][0] * v.x + m.m[1][0] * v.y + m.m[2][0] * v.z,
          m.m[0][1] * v.x + m.m[1][1] * v.y + m.m[2][1] * v.z,
          m.m[0][2] * v.x + m.m[1][2] * v.y + m.m[2][2] * v.z};
}

TextureCoordinate uv_coordinate(const Vec2& uv, const Vec3& dpdu, const Vec3& dpdv,
                                const TextureCoordinate& world) {
  TextureCoordinate out{{uv.x, uv.y, 0}, {}, {}};
  uv_along(dpdu, dpdv, world.a, out.a);
  uv_along(dpdu, dpdv, world.b, out.b);
  return out;
}

TexturePoint texture_point(const Scene& scene, const Ray& ray, double width,
                           const SurfacePoint& point) {
  const SurfaceInteraction& s = point.surface;
  const Transform& world_from_object = scene.instances[s.instance].world_from_object;
  const Affine& to_object = world_from_object.inverse_matrix();
  TexturePoint at;
  at.world.at = s.point - Point3{};
  add_patch(ray, width, point.geometric_normal, at.world);
  at.object = {to_object(s.point) - Point3{}, to_object(at.world.a), to_object(at.world.b)};
  at.uv = uv_coordinate(s.uv, s.dpdu, s.dpdv, at.world);
  at.second_uv =
      s.has_second_uv ? uv_coordinate(s.second_uv, s.second_dpdu, s.second_dpdv, at.world) : at.uv;
  const auto front = static_cast<Vec3>(s.shading_normal);
  at.object_normal = normalize(transposed(world_from_object.matrix(), front));
  const Camera& camera = *scene.camera;
  at.view_normal = {dot(front, camera.right()), dot(front, camera.up()),
                    -dot(front, camera.view())};
  return at;
}

Hit in_instance(Hit hit, uint32_t instance_index) {
  hit.instance = instance_index;
  return hit;
}

}  // namespace

SurfacePoint::SurfacePoint(const Scene& scene, uint32_t instance_index, const Ray& ray,
                           const Hit& hit)
    : SurfacePoint(scene, surface_at(scene.instances, ray, in_instance(hit, instance_index)),
                   ray.direction) {}

SurfacePoint::SurfacePoint(const Scene& scene, const SurfaceInteraction& met, const Vec3& direction)
    : surface(met) {
  is_back = dot(surface.geometric_normal, direction) > 0;
  material = &scene.material(surface.instance, surface.material);
  if (is_back) {
    is_hidden = material->hides_back();
    if (material->has_other_back()) material = &scene.materials[material->back];
  }
  absorption = &material->absorption;
  geometric_normal = static_cast<Vec3>(surface.geometric_normal);
  normal = material->flat ? geometric_normal : static_cast<Vec3>(surface.shading_normal);
  if (!is_back) return;
  geometric_normal = -geometric_normal;
  normal = -normal;
}

void look_up_textures(const Scene& scene, const Ray& ray, double width, SurfacePoint& point,
                      TraceCounters& counters) {
  if (point.material->inputs == kNoMaterialInputs || point.is_hidden) {
    ++counters.texture_points_skipped;
    return;
  }
  const MaterialInputs& inputs = scene.inputs[point.material->inputs];
  SurfaceInteraction& s = point.surface;
  point.resolved = *point.material;
  point.material = &*point.resolved;
  TexturePoint at;
  if (inputs.needs_point()) {
    at = texture_point(scene, ray, width, point);
  } else {
    ++counters.texture_points_skipped;
  }
  VertexColor vertex{s.vertex_color, s.vertex_alpha, s.has_vertex_color};
  resolve_material(inputs, at, scene.textures, vertex, *point.resolved);
  s.vertex_alpha = vertex.alpha;
  s.has_vertex_color = vertex.exists;
  if (inputs.normal_map == kNoTexture && inputs.bump == kNoTexture) return;
  // Relief is given as seen from the front.
  const double side = point.is_back ? -1 : 1;
  SurfaceFrame frame{point.normal * side, s.dpdu,        s.dpdv,       s.tangent,
                     s.bitangent,         s.second_dpdu, s.second_dpdv};
  if (!s.has_second_uv) frame.second_dpdu = s.dpdu, frame.second_dpdv = s.dpdv;
  // Nothing finer than the rounding of the point can be told apart.
  const double least = 0x1p-20 * max_component(abs(at.world.at));
  const Affine& to_object = scene.instances[s.instance].world_from_object.inverse_matrix();
  point.normal = perturbed_normal(inputs, at, scene.textures, frame, to_object,
                                  std::max({width, least, 1e-100})) *
                 side;
}

Media media_at_camera(const Scene& scene) {
  Media around;
  const auto absorbs = [](const Material& material) { return !is_black(material.absorption); };
  if (!scene.surfaces || std::none_of(scene.materials.begin(), scene.materials.end(), absorbs))
    return around;
  constexpr int kMostSurfaces = 1000;
  TraversalCounters counters;
  std::vector<uint32_t> entered;
  Ray ray{scene.camera->position(), scene.camera->view()};
  for (int i = 0; i < kMostSurfaces; ++i) {
    Hit hit;
    if (!scene.surfaces->closest_hit(ray, hit, counters)) break;
    const SurfacePoint point(scene, hit.instance, ray, hit);
    if (!point.is_hidden && fills(*point.material)) {
      const auto here = std::find(entered.begin(), entered.end(), point.surface.instance);
      if (!point.is_back) {
        entered.push_back(point.surface.instance);
      } else if (here != entered.end()) {
        entered.erase(here);
      } else {
        around.note_inside(point.surface.instance, *point.absorption);
      }
    }
    ray = spawn_ray(point.surface, ray.direction);
  }
  return around;
}

Coverage straight_coverage(const SurfacePoint& point) {
  if (point.is_hidden) return {1, 0};
  const Material& material = *point.material;
  const double alpha = point.surface.vertex_alpha * material.alpha;
  double covered = alpha;
  // Vertex colours that replace the material's replace its transparency too.
  const bool replaced = material.vertex_color_replaces_diffuse && point.surface.vertex_alpha < 1;
  if (!replaced) covered *= 1 - material.passed_straight();
  return {1 - covered, covered};
}

Color emission(const SurfacePoint& point) {
  const Material& material = *point.material;
  if (material.is_lit() || !point.surface.has_vertex_color) return material.emission;
  return material.emission * point.surface.vertex_color;
}

Color looked_up_emission(const Scene& scene, uint32_t instance, const SurfaceSample& there,
                         const Point3& from, double width, TraceCounters& counters) {
  constexpr double kAround = 1e-6, kRoundings = 0x1p-50, kLeastCosine = 1e-3;
  const Vec3 way = there.point - from;
  const double distance = length(way);
  const Vec3 direction = way / distance;
  // As far as rounding may take it across the surface, the farther along the ray.
  const double off = l1_norm(there.point_error) + kRoundings * l1_norm(from - Point3{});
  const double cosine = std::max(std::abs(dot(direction, there.normal)), kLeastCosine);
  const double around = std::min(kAround * distance + 4 * off / cosine, distance / 2);
  const Ray ray{from, direction, distance - around, distance + around};
  Hit hit;
  if (!closest_hit_of(scene.instances[instance], instance, ray, hit, counters.traversal))
    return kBlack;
  SurfacePoint point(scene, instance, ray, hit);
  look_up_textures(scene, ray, width, point, counters);
  return emission(point);
}

}  // namespace tessera
