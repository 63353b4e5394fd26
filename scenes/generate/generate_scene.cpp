#include "scenes/generate/generate_scene.h"

#include <fmt/format.h>

#include <array>
#include <charconv>

#include "base/error.h"
#include "scenes/generate/generate_forest.h"
#include "scenes/generate/put.h"
#include "scenes/generate/random.h"

namespace tessera {
namespace {

std::string add_material(v1::Scene& scene, double r, double g, double b) {
  v1::Material& material = *scene.add_materials();
  material.set_name(fmt::format("color{}", scene.materials_size()));
  put(r, g, b, material.mutable_classic()->mutable_diffuse()->mutable_value());
  put(.3, .3, .3, material.mutable_classic()->mutable_specular()->mutable_value());
  return material.name();
}

/// Looks from (2, 1.5, 3) times `distance` at the origin.
void add_view(v1::Scene& scene, double distance) {
  v1::LookAt& look =
      *scene.add_cameras()->mutable_world_from_camera()->add_steps()->mutable_look_at();
  put(2 * distance, 1.5 * distance, 3 * distance, look.mutable_eye());
  put(0, 0, 0, look.mutable_target());
  scene.mutable_cameras(0)->mutable_perspective()->set_field_of_view(40);
  v1::Light& sun = *scene.add_nodes()->mutable_light();
  put(-1, -2, -1.5, sun.mutable_directional()->mutable_direction());
  v1::Light& lamp = *scene.add_nodes()->mutable_light();
  put(3 * distance, 2 * distance, -distance, lamp.mutable_point()->mutable_position());
  lamp.set_intensity(.4);
  v1::Background::Gradient& gradient = *scene.mutable_background()->mutable_gradient();
  put(.4, .5, .65, gradient.mutable_sky());
  put(.15, .15, .17, gradient.mutable_ground());
}

void add_mesh(LoadedScene& out, const char* name, MeshData mesh) {
  v1::Node& node = *out.scene.add_nodes();
  node.set_name(name);
  node.mutable_shape()->add_materials(add_material(out.scene, .75, .7, .6));
  *node.mutable_shape()->mutable_mesh() = store_mesh(std::move(mesh), out.blobs);
}

LoadedScene icosphere_scene(uint32_t subdivisions) {
  LoadedScene out;
  add_mesh(out, "icosphere", icosphere(static_cast<int>(subdivisions), false));
  add_view(out.scene, 1);
  return out;
}

LoadedScene soup_scene(uint32_t count) {
  LoadedScene out;
  add_mesh(out, "soup", triangle_soup(count, .05, 1));
  add_view(out.scene, 1.2);
  return out;
}

LoadedScene uv_sphere_scene(uint32_t rings) {
  LoadedScene out;
  add_mesh(out, "uvsphere", uv_sphere(rings, 2 * rings));
  add_view(out.scene, 1);
  return out;
}

/// side^3 spheres in [-1, 1]^3, a third of their spacing in radius, in colours that vary.
LoadedScene sphere_grid(uint32_t side) {
  LoadedScene out;
  Random random(side);
  std::array<std::string, 8> colors;
  for (std::string& color : colors)
    color = add_material(out.scene, .2 + .8 * random.uniform(), .2 + .8 * random.uniform(),
                         .2 + .8 * random.uniform());
  const double spacing = 2.0 / side;
  const auto at = [&](uint32_t i) { return -1 + spacing * (i + .5); };
  for (uint32_t z = 0; z < side; ++z)
    for (uint32_t y = 0; y < side; ++y)
      for (uint32_t x = 0; x < side; ++x) {
        v1::Shape& shape = *out.scene.add_nodes()->mutable_shape();
        put(at(x), at(y), at(z), shape.mutable_sphere()->mutable_center());
        shape.mutable_sphere()->set_radius(spacing / 3);
        shape.add_materials(colors[random.bits() % colors.size()]);
      }
  add_view(out.scene, 1.2);
  return out;
}

struct Kind {
  const char* name;
  uint32_t least, most, usual;
  LoadedScene (*make)(uint32_t);
};

constexpr std::array kKinds{
    Kind{"forest", 1, 1'000'000, 10'000, forest}, Kind{"icosphere", 0, 10, 5, icosphere_scene},
    Kind{"soup", 1, 50'000'000, 100'000, soup_scene}, Kind{"spheres", 1, 100, 10, sphere_grid},
    Kind{"uvsphere", 3, 5'000, 200, uv_sphere_scene}};

}  // namespace

std::vector<std::string> generated_scene_names() {
  std::vector<std::string> names;
  for (const Kind& kind : kKinds) names.emplace_back(kind.name);
  return names;
}

LoadedScene generate_scene(std::string_view what) {
  const size_t colon = what.find(':');
  const std::string_view name = what.substr(0, colon);
  for (const Kind& kind : kKinds) {
    if (name != kind.name) continue;
    uint32_t number = kind.usual;
    if (colon != std::string_view::npos) {
      const std::string_view text = what.substr(colon + 1);
      const auto [stop, problem] = std::from_chars(text.data(), text.data() + text.size(), number);
      if (problem != std::errc() || stop != text.data() + text.size() || number < kind.least ||
          number > kind.most)
        throw usage_error(fmt::format("'{}' in '{}'; expected a number from {} to {}", text, what,
                                      kind.least, kind.most));
    }
    LoadedScene out = kind.make(number);
    out.scene.mutable_metadata()->set_title(std::string(what));
    return out;
  }
  const auto names = generated_scene_names();
  throw usage_error(fmt::format("unknown scene '{}'; expected one of {}{}", name,
                                fmt::join(names, ", "), suggestion(name, names)));
}

}  // namespace tessera
