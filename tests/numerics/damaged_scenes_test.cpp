// N16, N19: whole scenes with damaged numbers, and mirrors that face each other.

#include <cmath>

#include "base/error.h"
#include "tests/numerics/support.h"
#include "tests/unit/renderer/scene_text.h"

namespace tessera::numerics {
namespace {

/// Every kind of shape and light, and of transforms two.
constexpr char kScene[] = R"(
  settings { sampling { samples_per_pixel: 1 } integrator { max_depth: 4 } }
  cameras { orthographic { min_x: -3 max_x: 3 }
            world_from_camera { steps { translate { z: 10 } } } near_distance: .1 far_distance: 100 }
  fog { color { r: .1 } visibility_range: 400 kind: EXPONENTIAL }
  materials { name: 'a' classic { diffuse { value { r: .5 g: .25 b: .125 } } reflectivity { value { r: .1 } }
              specular { value { g: 1 } } shininess { value: 20 } } }
  materials { name: 'b' classic { emission { value { r: .5 g: .25 b: .125 } } transparency { value: .5 }
              refractive_index: 1.5 absorption { r: .1 g: .1 b: .1 } } }
  materials { name: 'c' unlit { color { value { r: .75 g: .5 b: .25 } } } }
  nodes { light { point { position { x: 3 y: 3 z: 9 } } intensity: 10 attenuation { quadratic: 1 } } }
  nodes { light { spot { position { y: 4 z: 4 } direction { y: -1 z: -1 } beam_width: 10 cut_off: 40 } } }
  nodes { light { directional { direction { y: -1 z: -1 } } } }
  nodes { shape { materials: 'c' sphere { center { x: -2 } radius: .9 } } }
  nodes { transform { steps { translate { x: 2 } } steps { rotate { axis { x: 1 y: .5 } angle: 20 } }
                      steps { scale { x: .3 y: .3 z: .3 } } }
    children { shape { materials: 'a' sphere { center { x: 1 y: 2 } radius: .7 } } }
    children { shape { materials: 'b' box { min { x: -2 y: -2 z: -2 } max { x: -1 y: -1 z: -1 } } } }
    children { shape { materials: 'a' cylinder { radius: .5 height: 1.5 } } }
    children { shape { materials: 'a' cone { radius: .5 height: 1.5 } }
            transform { steps { matrix { rows: [1, 0, .2, 1.5, 0, 1, 0, -1, 0, .1, 1, 0] } } } }
    children { shape { materials: 'a' torus { major_radius: 1.5 minor_radius: .2 } } }
    children { shape { materials: 'b' disc { center { y: -2 } normal { y: 1 z: 1 } radius: .8 inner_radius: .1 } } }
    children { shape { materials: 'a' rectangle { corner { x: 1 y: -2 z: 1 } edge_u { x: 1 } edge_v { y: 1 z: .1 } } } }
    children { shape { materials: 'a' polygon { points { x: -2 y: 1 } points { x: -1 y: 1 } points { x: -1.5 y: 2 } } } }
    children { shape { materials: 'a' csg { operation: DIFFERENCE
              operands { shape { box {} } } operands { shape { sphere { radius: 1.2 } } } } }
            transform { steps { translate { z: -3 } } } }
    children { shape { materials: 'a' mesh { inline_positions: [0,0,2, 1,0,2, 0,1,2, 1,1,2.5]
                                          inline_triangles: [0,1,2, 1,3,2] } } }
  })";

using google::protobuf::FieldDescriptor;

/// A number somewhere in a message.
struct Place {
  google::protobuf::Message* message;
  const FieldDescriptor* field;
  int index;  ///< of a repeated field
};

void find_numbers(google::protobuf::Message& message, std::vector<Place>& places) {
  const auto& reflection = *message.GetReflection();
  std::vector<const FieldDescriptor*> fields;
  reflection.ListFields(message, &fields);
  for (const FieldDescriptor* field : fields) {
    const int count = field->is_repeated() ? reflection.FieldSize(message, field) : 1;
    for (int i = 0; i < count; ++i) {
      const auto type = field->cpp_type();
      if (type == FieldDescriptor::CPPTYPE_MESSAGE)
        find_numbers(field->is_repeated() ? *reflection.MutableRepeatedMessage(&message, field, i)
                                          : *reflection.MutableMessage(&message, field),
                     places);
      if (type == FieldDescriptor::CPPTYPE_DOUBLE || type == FieldDescriptor::CPPTYPE_FLOAT)
        places.push_back({&message, field, i});
    }
  }
}

void set(const Place& place, double value) {
  const auto& reflection = *place.message->GetReflection();
  const bool is_double = place.field->cpp_type() == FieldDescriptor::CPPTYPE_DOUBLE;
  if (place.field->is_repeated()) {
    if (is_double)
      reflection.SetRepeatedDouble(place.message, place.field, place.index, value);
    else
      reflection.SetRepeatedFloat(place.message, place.field, place.index,
                                  static_cast<float>(value));
  } else if (is_double) {
    reflection.SetDouble(place.message, place.field, value);
  } else {
    reflection.SetFloat(place.message, place.field, static_cast<float>(value));
  }
}

constexpr int kWidth = 30, kHeight = 10;

std::vector<float> picture(const v1::Scene& scene, const std::string& accelerator) {
  v1::FrameSettings frame = frame_of(kWidth, kHeight);
  frame.set_accelerator(accelerator);
  const auto renderer = make_tile_renderer(scene, {}, frame, 1);
  return render_rect(*renderer, {0, 0, kWidth, kHeight}).values;
}

TEST(N16, DamagedScenesAreRefusedOrTracedAndNothingSpreads) {
  const double odd[] = {std::nan(""), HUGE_VAL, -HUGE_VAL, 1e308, -1e308, 0, 1e-310, -1};
  const v1::Scene good = parse_scene(kScene);
  const std::vector<float> expected = picture(good, "bvh");
  const char* accelerators[] = {"bvh", "octree", "nonuniform-octree"};
  int traced = 0, refused = 0;
  for (uint64_t seed = 1; seed <= 8; ++seed) {
    Random random(16, seed);
    for (int64_t i = 0; i < ray_count(10'000 * 10 / 8); ++i) {
      v1::Scene scene = good;
      std::vector<Place> places;
      find_numbers(scene, places);
      std::string changed;
      for (int k = 0; k <= random.below(2); ++k) {
        const double value = odd[random.below(8)];
        const Place& place = places[random.below(places.size())];
        set(place, value);
        changed += " " + place.field->full_name() + " = " + std::to_string(value);
      }
      const auto damage = [&] {
        return "seed " + std::to_string(seed) + " at " + std::to_string(i) + ": " + changed;
      };
      try {
        const auto values = picture(scene, "linear");
        for (const float value : values) ASSERT_TRUE(std::isfinite(value)) << damage();
        EXPECT_EQ(picture(scene, accelerators[random.below(3)]), values) << damage();
        ++traced;
      } catch (const Error&) {
        ++refused;
      }
    }
  }
  EXPECT_GT(traced, 100);
  EXPECT_GT(refused, 100);
  EXPECT_EQ(picture(good, "bvh"), expected);
}

constexpr uint32_t kBounces = 10'000;
constexpr double kShare = 0.9995;

void* render_mirror_box(void* result) {
  auto& tile = *static_cast<TilePixels*>(result);
  const v1::Scene scene = parse_scene(R"(
    settings { integrator { max_depth: 10000 } }
    cameras { world_from_camera { steps { translate { x: .1 y: .2 z: .3 } } } }
    materials { name: 'm' classic { diffuse { value {} } emission { value { r: 1 g: .5 b: .25 } }
                reflectivity { value { r: .9995 g: .9995 b: .9995 } } } }
    nodes { shape { materials: 'm' box { min { x: -1 y: -1.25 z: -2 } max { x: 1 y: 1 z: 1.5 } } } })");
  tile = render_rect(*make_tile_renderer(scene, {}, frame_of(2, 2), 1), {0, 0, 2, 2});
  return nullptr;
}

TEST(N19, ABoxOfMirrorsTenThousandDeepUnderASmallStack) {
  TilePixels tile;
  ASSERT_NO_FATAL_FAILURE(numerics::run_on_small_stack(render_mirror_box, &tile));
  // Were one bounce to leave the box, its sum would end there.
  double sum = 0, share = 1;
  for (uint32_t i = 0; i <= kBounces; ++i, share *= kShare) sum += share;
  ASSERT_EQ(tile.values.size(), 12u);
  for (size_t i = 0; i < 12; ++i)
    EXPECT_FLOAT_EQ(tile.values[i], static_cast<float>(std::ldexp(sum, -static_cast<int>(i % 3))));
  EXPECT_EQ(tile.counters["rays_reflection"], 4u * kBounces);
}

}  // namespace
}  // namespace tessera::numerics
