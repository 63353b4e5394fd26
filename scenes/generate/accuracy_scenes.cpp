#include "scenes/generate/accuracy_scenes.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "base/error.h"
#include "proto/wire/scene_codec.h"
#include "scenes/generate/random.h"

namespace tessera {
namespace {

// Text form of proto/tessera/v1/scene.proto. Those with a closed form have their twin in
// bench/error/closed_forms.cpp.

/// Straight down on [-1, 1]^2 of the floor, x to the right and z downwards.
#define FROM_ABOVE                                                                             \
  "cameras { world_from_camera { steps { look_at { eye { y: 5 } target { } up { z: -1 } } } }" \
  " orthographic { } }"

constexpr char kEdge[] = R"(
settings { width: 64 height: 64 integrator { kind: "whitted" } }
cameras { world_from_camera { steps { translate { z: 1 } } } orthographic { } }
materials { name: "white" unlit { } }
nodes { shape { materials: "white" half_plane {
  point { x: .0123 y: .0217 } normal { z: 1 } edge_normal { x: .8 y: .6 } } } }
)";

constexpr char kChecker[] = R"(
settings { width: 160 height: 100 integrator { kind: "whitted" } }
cameras { world_from_camera { steps { look_at { eye { y: 1 } target { x: .3 y: .8 z: -1 } } } } }
textures { name: "tiles" mapping: WORLD checker { } }
materials { name: "floor" classic { diffuse { texture: "tiles" } } }
nodes { shape { materials: "floor" plane { } } }
nodes { light { directional { direction { y: -1 } } } }
)";

constexpr char kTextured[] = R"(
settings { width: 160 height: 100 integrator { kind: "whitted" } }
cameras { world_from_camera { steps { look_at { eye { x: 1 y: 1.6 z: 4 } target { y: .45 } } } } perspective { field_of_view: 34 } }
background { gradient { sky { r: .4 g: .5 b: .7 } ground { r: .3 g: .3 b: .3 } } }
textures { name: "marble" mapping: OBJECT noise { kind: MARBLE octaves: 6 frequency: 1.5 strength: 2 low { r: .15 g: .1 b: .12 } high { r: .9 g: .88 b: .82 } } }
textures { name: "wood" mapping: OBJECT noise { kind: WOOD octaves: 3 frequency: 9 strength: .35 low { r: .3 g: .12 b: .03 } high { r: .7 g: .42 b: .18 } } }
textures { name: "bumps" mapping: OBJECT noise { octaves: 3 frequency: 9 } }
textures { name: "tiles" mapping: WORLD checker { odd { value { r: .25 g: .28 b: .3 } } even { texture: "marble" } } transform { steps { scale { x: 3 z: 3 } } } }
materials { name: "floor" classic { diffuse { texture: "tiles" } } }
materials { name: "wooden" classic { diffuse { texture: "wood" } specular { value { r: .3 g: .3 b: .3 } } } }
materials { name: "marbled" classic { diffuse { texture: "marble" } } }
materials { name: "rough" classic { diffuse { value { r: .8 g: .3 b: .1 } } specular { value { r: .5 g: .5 b: .5 } } } bump { texture: "bumps" value: .03 } }
nodes { shape { materials: "floor" plane { } } }
nodes { shape { materials: "marbled" sphere { center { x: -1 y: .5 z: .1 } radius: .5 } } }
nodes { transform { steps { translate { x: .1 y: .4 } } steps { rotate { axis { y: 1 } angle: 25 } } } shape { materials: "wooden" box { min { x: -.4 y: -.4 z: -.4 } max { x: .4 y: .4 z: .4 } } } }
nodes { shape { materials: "rough" sphere { center { x: 1.1 y: .45 z: .2 } radius: .45 } } }
nodes { light { directional { direction { x: .5 y: -1 z: -.8 } } } }
)";

constexpr char kMirrors[] = R"(
settings { width: 160 height: 100 integrator { kind: "whitted" max_depth: 8 } }
cameras { world_from_camera { steps { look_at { eye { x: .4 y: 1.6 z: 5 } target { y: .7 } } } } perspective { field_of_view: 34 } }
background { gradient { sky { r: .35 g: .55 b: .95 } ground { r: .9 g: .85 b: .8 } } }
textures { name: "tiles" mapping: WORLD checker { odd { value { r: .2 g: .2 b: .2 } } even { value { r: .8 g: .8 b: .8 } } } }
materials { name: "floor" classic { diffuse { texture: "tiles" } reflectivity { value { r: .1 g: .1 b: .1 } } } }
materials { name: "mirror" classic { diffuse { value { } } reflectivity { value { r: .9 g: .88 b: .84 } } } }
materials { name: "glass" classic { diffuse { value { } } transparency { value: .95 } refractive_index: 1.5 } }
nodes { shape { materials: "floor" plane { } } }
nodes { shape { materials: "mirror" sphere { center { x: -1 y: .8 z: -.4 } radius: .8 } } }
nodes { shape { materials: "glass" sphere { center { x: .8 y: .6 z: .8 } radius: .6 } } }
nodes { light { directional { direction { x: -.5 y: -1 z: -.45 } } } }
)";

constexpr char kFurnace[] = R"(
settings { width: 32 height: 32 integrator { kind: "path" max_depth: 64 } }
cameras { world_from_camera { steps { translate { x: .3 y: .1 z: .2 } } } perspective { field_of_view: 60 } }
materials { name: "glowing" classic { diffuse { value { r: .5 g: .5 b: .5 } } emission { value { r: .5 g: .5 b: .5 } } } }
nodes { shape { materials: "glowing" sphere { } } }
)";

constexpr char kSphereLight[] = R"(
settings { width: 96 height: 96 integrator { kind: "path" } }
)" FROM_ABOVE R"(
materials { name: "floor" classic { diffuse { value { r: .8 g: .8 b: .8 } } } }
materials { name: "lamp" classic { diffuse { value { } } emission { value { r: 5 g: 5 b: 5 } } } }
nodes { shape { materials: "floor" rectangle { corner { x: -1.1 z: -1.1 } edge_u { z: 2.2 } edge_v { x: 2.2 } } } }
nodes { shape { materials: "lamp" sphere { center { x: 1.5 y: .8 z: .2 } radius: .4 } } }
)";

constexpr char kRectangleLight[] = R"(
settings { width: 96 height: 96 integrator { kind: "path" } }
)" FROM_ABOVE R"(
materials { name: "floor" classic { diffuse { value { r: .8 g: .8 b: .8 } } } }
materials { name: "lamp" classic { diffuse { value { } } emission { value { r: 5 g: 5 b: 5 } } } }
nodes { shape { materials: "floor" rectangle { corner { x: -1.1 z: -1.1 } edge_u { z: 2.2 } edge_v { x: 2.2 } } } }
nodes { shape { materials: "lamp" rectangle { corner { x: 1.2 y: .6 z: -.5 } edge_u { x: 1 } edge_v { z: .8 } } } }
)";

constexpr char kSkyWall[] = R"(
settings { width: 96 height: 96 integrator { kind: "path" } }
cameras { world_from_camera { steps { look_at { eye { x: 1.05 y: 5 } target { x: 1.05 } up { z: -1 } } } } orthographic { } }
background { solid { r: 1 g: 1 b: 1 } }
materials { name: "floor" classic { diffuse { value { r: .8 g: .8 b: .8 } } } }
materials { name: "black" classic { diffuse { value { } } } }
nodes { shape { materials: "floor" rectangle { corner { z: -1.1 } edge_u { z: 2.2 } edge_v { x: 2.2 } } } }
nodes { shape { materials: "black" rectangle { corner { z: -3000 } edge_u { z: 6000 } edge_v { y: 1 } } } }
)";

constexpr char kPlates[] = R"(
settings { width: 160 height: 100 integrator { kind: "path" } }
cameras { world_from_camera { steps { look_at { eye { y: 2 z: 15 } target { y: -1.2 z: 2.5 } } } } perspective { field_of_view: 24 } }
)";

constexpr char kGlossy[] = R"(
settings { width: 160 height: 100 integrator { kind: "path" max_depth: 16 } }
cameras { world_from_camera { steps { look_at { eye { y: 1.6 z: 6 } target { y: .5 } } } } perspective { field_of_view: 32 } }
background { gradient { sky { r: .25 g: .3 b: .4 } ground { r: .1 g: .1 b: .1 } } }
textures { name: "tiles" mapping: WORLD checker { odd { value { r: .2 g: .2 b: .2 } } even { value { r: .7 g: .7 b: .7 } } } transform { steps { scale { x: 2 z: 2 } } } }
materials { name: "floor" classic { diffuse { texture: "tiles" } } }
materials { name: "gold" conductor { eta { r: .18 g: .42 b: 1.37 } k { r: 3.42 g: 2.35 b: 1.77 } roughness { value: .3 } } }
materials { name: "steel" physical { base_color { value { r: .7 g: .7 b: .72 } } roughness { value: .5 } } }
materials { name: "plastic" physical { base_color { value { r: .05 g: .3 b: .7 } } metallic { value: 0 } roughness { value: .25 } } }
materials { name: "lamp" classic { diffuse { value { } } emission { value { r: 8 g: 8 b: 8 } } } }
nodes { shape { materials: "floor" plane { } } }
nodes { shape { materials: "gold" sphere { center { x: -1.3 y: .6 } radius: .6 } } }
nodes { shape { materials: "steel" sphere { center { y: .6 z: -.3 } radius: .6 } } }
nodes { shape { materials: "plastic" sphere { center { x: 1.3 y: .6 } radius: .6 } } }
nodes { shape { materials: "lamp" rectangle { corner { x: -1 y: 3 z: -1 } edge_u { x: 2 } edge_v { z: 2 } } } }
)";

constexpr char kCaustic[] = R"(
settings { width: 160 height: 100 integrator { kind: "path" max_depth: 16 } }
cameras { world_from_camera { steps { look_at { eye { y: 2 z: 5 } target { x: .2 y: .3 } } } } perspective { field_of_view: 32 } }
materials { name: "floor" classic { diffuse { value { r: .7 g: .7 b: .7 } } } }
materials { name: "glass" dielectric { } }
materials { name: "lamp" classic { diffuse { value { } } emission { value { r: 20 g: 20 b: 20 } } } }
nodes { shape { materials: "floor" plane { } } }
nodes { shape { materials: "glass" sphere { center { y: .6 } radius: .6 } } }
nodes { shape { materials: "lamp" sphere { center { x: -2.4 y: 3.2 z: .6 } radius: .5 } } }
)";

constexpr char kManyLights[] = R"(
settings { width: 160 height: 100 integrator { kind: "path" } }
cameras { world_from_camera { steps { look_at { eye { x: 1 y: 4 z: 9 } target { y: .2 } } } } perspective { field_of_view: 42 } }
materials { name: "floor" classic { diffuse { value { r: .7 g: .7 b: .7 } } } }
nodes { shape { materials: "floor" plane { } } }
)";

constexpr char kCornell[] = R"(
metadata { title: "Cornell box" }
settings { width: 128 height: 128 sampling { samples_per_pixel: 64 } integrator { kind: "path" max_depth: 64 } }
cameras {
  world_from_camera { steps { look_at { eye { y: -3.9 } target { } up { z: 1 } } } }
  perspective { field_of_view: 38.05121207513737 }
}
materials { name: "white" classic { diffuse { value { r: .73 g: .73 b: .73 } } } }
materials { name: "red" classic { diffuse { value { r: .65 g: .05 b: .05 } } } }
materials { name: "green" classic { diffuse { value { r: .12 g: .45 b: .15 } } } }
materials { name: "black" classic { diffuse { value { } } } }
materials {
  name: "lamp"
  classic { diffuse { value { } } emission { value { r: 15 g: 15 b: 15 } } }
  sides: BACK_MATERIAL
  back: "black"
}
nodes { name: "floor" shape { materials: "white" rectangle { corner { x: -1 y: -1 z: -1 } edge_u { x: 2 } edge_v { y: 2 } } } }
nodes { name: "ceiling" shape { materials: "white" rectangle { corner { x: -1 y: -1 z: 1 } edge_u { y: 2 } edge_v { x: 2 } } } }
nodes { name: "back" shape { materials: "white" rectangle { corner { x: -1 y: 1 z: -1 } edge_u { x: 2 } edge_v { z: 2 } } } }
nodes { name: "left" shape { materials: "red" rectangle { corner { x: -1 y: -1 z: -1 } edge_u { y: 2 } edge_v { z: 2 } } } }
nodes { name: "right" shape { materials: "green" rectangle { corner { x: 1 y: -1 z: -1 } edge_u { z: 2 } edge_v { y: 2 } } } }
nodes {
  name: "tall block"
  transform { steps { translate { x: -.35 y: .3 z: -1 } } steps { rotate { axis { z: 1 } angle: 17.188733853924695 } } }
  shape { materials: "white" box { min { x: -.3 y: -.3 } max { x: .3 y: .3 z: 1.2 } } }
}
nodes {
  name: "short block"
  transform { steps { translate { x: .35 y: -.3 z: -1 } } steps { rotate { axis { z: 1 } angle: -17.188733853924695 } } }
  shape { materials: "white" box { min { x: -.3 y: -.3 } max { x: .3 y: .3 z: .6 } } }
}
nodes { name: "lamp" shape { materials: "lamp" rectangle { corner { x: -.25 y: -.25 z: .99 } edge_u { y: .5 } edge_v { x: .5 } } } }
)";

/// Four plates, the smoother the farther away, that mirror four lamps of about the same power.
std::string plates() {
  std::string text = kPlates;
  text +=
      "materials { name: \"floor\" classic { diffuse { value { r: .4 g: .4 b: .4 } } } }\n"
      "nodes { shape { materials: \"floor\" plane { offset: -4.2 } } }\n"
      "nodes { shape { materials: \"floor\" plane { normal { z: 1 } offset: -5 } } }\n";
  constexpr double kRoughness[] = {.08, .16, .28, .45}, kRadius[] = {.05, .15, .4, .9};
  constexpr double kHeight[] = {-1.15, -2.1, -2.85, -3.4}, kDepth[] = {-1.6, .4, 2.5, 4.6};
  constexpr double kTilt[] = {40, 27, 18, 11};
  for (int i = 0; i < 4; ++i) {
    text += fmt::format(
        "materials {{ name: \"plate{0}\" physical {{ base_color {{ value {{ r: .8 g: .8 b: .8 }} "
        "}} "
        "roughness {{ value: {1} }} }} }}\n"
        "nodes {{ transform {{ steps {{ translate {{ y: {2} z: {3} }} }} steps {{ rotate {{ axis "
        "{{ x: 1 }} angle: {4} }} }} }} shape {{ materials: \"plate{0}\" rectangle {{ corner {{ x: "
        "-4 z: -.9 }} edge_u {{ z: 1.8 }} edge_v {{ x: 8 }} }} }} }}\n"
        "materials {{ name: \"lamp{0}\" classic {{ diffuse {{ value {{ }} }} emission {{ value {{ "
        "r: "
        "{5} g: {5} b: {5} }} }} }} }}\n"
        "nodes {{ shape {{ materials: \"lamp{0}\" sphere {{ center {{ x: {6} y: .6 z: -1 }} "
        "radius: "
        "{7} }} }} }}\n",
        i, kRoughness[i], kHeight[i], kDepth[i], kTilt[i], .4 / (kRadius[i] * kRadius[i]),
        -3.75 + 2.5 * i, kRadius[i]);
  }
  return text;
}

/// A field of balls through a lens that is sharp in the middle.
std::string lens() {
  std::string text = R"(
settings { width: 160 height: 100 integrator { kind: "whitted" } }
cameras { world_from_camera { steps { look_at { eye { x: 1 y: 1.4 z: 6 } target { y: .3 } } } } perspective { field_of_view: 34 } lens { radius_x: .12 radius_y: .12 focal_distance: 6.2 } }
background { gradient { sky { r: .4 g: .5 b: .7 } ground { r: .3 g: .3 b: .3 } } }
textures { name: "tiles" mapping: WORLD checker { odd { value { r: .2 g: .2 b: .2 } } even { value { r: .8 g: .8 b: .8 } } } }
materials { name: "floor" classic { diffuse { texture: "tiles" } } }
materials { name: "ball" classic { diffuse { value { r: .8 g: .35 b: .15 } } specular { value { r: .6 g: .6 b: .6 } } } }
nodes { shape { materials: "floor" plane { } } }
nodes { light { directional { direction { x: -.5 y: -1 z: -.6 } } } }
)";
  for (int row = -4; row <= 3; ++row)
    for (int column = -2; column <= 2; ++column)
      text += fmt::format(
          "nodes {{ shape {{ materials: \"ball\" sphere {{ center {{ x: {} y: .3 z: {} }} radius: "
          ".3 "
          "}} }} }}\n",
          column, 1.2 * row);
  return text;
}

/// A hundred small lamps of many colours over boxes.
std::string many_lights() {
  std::string text = kManyLights;
  Random random(1);
  for (int i = 0; i < 100; ++i) {
    const double x = 8 * random.uniform() - 4, z = 8 * random.uniform() - 4;
    const double y = .3 + 1.5 * random.uniform(), strength = 1 + 5 * random.uniform();
    const double red = random.uniform(), green = random.uniform();
    text += fmt::format(
        "materials {{ name: \"lamp{0}\" classic {{ diffuse {{ value {{ }} }} emission {{ value {{ "
        "r: "
        "{1} g: {2} b: {3} }} }} }} }}\n"
        "nodes {{ shape {{ materials: \"lamp{0}\" sphere {{ center {{ x: {4} y: {5} z: {6} }} "
        "radius: "
        ".12 }} }} }}\n",
        i, strength * red, strength * green, strength * (1 - .5 * (red + green)), x, y, z);
  }
  for (int row = 0; row < 5; ++row)
    for (int column = 0; column < 5; ++column)
      text += fmt::format(
          "nodes {{ shape {{ materials: \"floor\" box {{ min {{ x: {0} z: {1} }} max {{ x: {2} y: "
          "{3} "
          "z: {4} }} }} }} }}\n",
          -4 + 1.6 * column, -4 + 1.6 * row, -3.5 + 1.6 * column,
          .2 + .1 * ((5 * row + column) % 7), -3.5 + 1.6 * row);
  return text;
}

struct Recipe {
  const char* name;
  const char* about;
  std::string (*text)();
};

template <const char* text>
std::string fixed() {
  return text;
}

constexpr Recipe kRecipes[] = {
    {"edge", "one straight edge and nothing else", fixed<kEdge>},
    {"checker", "a chequered floor up to the horizon", fixed<kChecker>},
    {"textured", "marble, wood and bumps in sunlight", fixed<kTextured>},
    {"lens", "balls out of focus", lens},
    {"mirrors", "a mirror and a glass ball", fixed<kMirrors>},
    {"cornell", "the Cornell box: colours bleed from wall to wall", fixed<kCornell>},
    {"furnace", "inside a ball that glows, half of it reflected", fixed<kFurnace>},
    {"sphere-light", "a floor under a round lamp", fixed<kSphereLight>},
    {"rectangle-light", "a floor under a square lamp", fixed<kRectangleLight>},
    {"sky-wall", "a floor before a black wall under a white sky", fixed<kSkyWall>},
    {"plates", "four glossy plates mirror four lamps (after Veach and Guibas 1995)", plates},
    {"glossy", "brushed metal and plastic under a lamp and a sky", fixed<kGlossy>},
    {"caustic", "light through a glass ball", fixed<kCaustic>},
    {"many-lights", "a hundred small lamps", many_lights},
};

}  // namespace

const std::vector<std::string>& accuracy_scene_names() {
  static const std::vector<std::string> names = [] {
    std::vector<std::string> out;
    for (const Recipe& recipe : kRecipes) out.emplace_back(recipe.name);
    return out;
  }();
  return names;
}

AccuracyScene make_accuracy_scene(std::string_view name) {
  for (const Recipe& recipe : kRecipes) {
    if (name != recipe.name) continue;
    SceneWithBlobs decoded =
        decode_scene(recipe.text(), SceneEncoding::text, fmt::format("the scene '{}'", name));
    AccuracyScene out{recipe.name, recipe.about, {}};
    out.loaded.scene = std::move(decoded.scene);
    // The lamp and its edges: pixels x 194 to 318 and y 44 to 90 of 512.
    if (name == "cornell") out.left_out = {{194. / 512, 44. / 512, 319. / 512, 91. / 512}};
    // The lamps themselves: their edges would be most of the error.
    if (name == "plates") out.left_out = {{0, 0, 1, .3}};
    return out;
  }
  const auto& names = accuracy_scene_names();
  throw usage_error(fmt::format("unknown scene '{}'; expected one of {}{}", name,
                                fmt::join(names, ", "), suggestion(name, names)));
}

}  // namespace tessera
