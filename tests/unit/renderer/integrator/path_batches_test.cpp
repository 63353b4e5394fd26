#include "renderer/integrator/path_batches.h"

#include <fmt/format.h>
#include <gtest/gtest.h>

#include <cmath>
#include <string>
#include <vector>

#include "renderer/scene/scene_builder.h"
#include "tests/uniform_numbers.h"
#include "tests/unit/renderer/integrator/random_scene.h"
#include "tests/unit/renderer/scene_text.h"

namespace tessera {
namespace {

/// A random scene that paths are followed through in batches: shapes of all kinds where they are or
/// moved, materials that scatter evenly or otherwise, textured or not, glass, alpha and what
/// absorbs or neither, lights with and without an extent, before backgrounds that are sampled or
/// not.
class PathScene : RandomScene {
 public:
  PathScene(uint32_t seed, bool has_lens) : RandomScene(seed), passes_(seed % 3 == 1) {
    const char* const patterns[] = {"OWEN_SOBOL", "INDEPENDENT", "BLUE_NOISE"};
    is_even_ = chance(.4);
    is_textured_ = !is_even_ && chance(.5);
    text_ = fmt::format(
        "settings {{ sampling {{ pattern: {} samples_per_pixel: 256 seed: {} "
        "target_error: {} }} integrator {{ kind: 'path' max_depth: {} }} }} ",
        patterns[pick(0, 3)], seed, chance(.3) ? .01 : 0, chance(.2) ? pick(0, 3) : 64);
    text_ += fmt::format("cameras {{ near_distance: {:.17g} {} }} ", size_ * random_.between(0, .1),
                         has_lens ? "lens { radius_x: .1 focal_distance: 1 samples: 3 }" : "");
    const int sky = pick(0, 5);
    if (sky == 3) text_ += panorama();
    if (sky == 0) text_ += "background { gradient { sky { r: .1 b: .9 } ground { r: .3 } } } ";
    if (sky == 1) text_ += "background { solid { r: .2 g: .3 b: .4 } } ";
    if (sky == 2) text_ += "background { sun_and_sky { sun_direction { x: 1 y: 2 z: .5 } } } ";
    if (is_textured_) {
      text_ += fmt::format(
          "textures {{ name: 'checks' mapping: OBJECT checker {{ odd {{ value {{ {} }} }} even {{ "
          "value {{ {} }} }} }} transform {{ steps {{ scale {{ x: {:.17g} y: {:.17g} z: {:.17g} }} "
          "}} }} }} textures {{ name: 'noise' noise {{ frequency: 3 octaves: 4 }} }} ",
          rgb(), rgb(), 9 / size_, 9 / size_, 9 / size_);
    }
    for (int i = 0; i < kMaterials; ++i) add_material(i);
    for (int i = pick(-2, 3); i > 0; --i) add_light();
    for (int i = pick(2, 14); i > 0; --i) add_shape();
  }
  const std::string& text() const { return text_; }
  bool is_even() const { return is_even_; }
  std::shared_ptr<const Scene> build(const char* accelerator = "bvh") const {
    v1::FrameSettings frame = frame_of(16, 16);
    frame.set_accelerator(accelerator);
    return build_scene(parse_scene(text_), blobs_, frame, 1, {}, {});
  }
  using RandomScene::beam;
  Ray ray() {
    const Point3 from = Point3{} + vec(2), to = Point3{} + vec(.7);
    return {from, normalize(to - from)};
  }
  SampleKey key() { return {pick(0, 2000), pick(0, 2000), static_cast<uint32_t>(pick(0, 200))}; }

 private:
  static constexpr int kMaterials = 6;
  void add_material(int number) {
    const int model = is_even_ ? 0 : pick(0, 5);
    text_ += fmt::format("materials {{ name: 'm{}' ", number);
    if ((passes_ || number == kMaterials - 1) && chance(.5))
      text_ += "sides: FRONT_ONLY ";  // in solids made of others it would be alpha
    else if (number > 0 && chance(.2))
      text_ += fmt::format("sides: BACK_MATERIAL back: 'm{}' ", pick(0, number));
    const bool is_textured = is_textured_ && chance(.6);
    const auto value = [&](const char* texture, std::string constant) {
      return is_textured && chance(.6) ? fmt::format("texture: '{}'", texture)
                                       : fmt::format("value {{ {} }}", constant);
    };
    if (is_textured && chance(.3)) text_ += "bump { texture: 'noise' value: .1 } ";
    if (passes_ && chance(.3))
      text_ += is_textured ? "opacity { texture: 'noise' } " : "opacity { value: .4 } ";
    const auto absorption = [&] {
      return passes_ && chance(.5) ? fmt::format("absorption {{ {} }} ", rgb(9 / size_)) : "";
    };
    if (model == 4) {
      text_ += fmt::format(
          "dielectric {{ refractive_index: {:.2f} roughness {{ value: {:.2f} }} "
          "thin: {} {} }} ",
          random_.between(1, 2), chance(.5) ? 0 : random_.between(0, 1), chance(.2), absorption());
    } else if (model == 3) {
      text_ += fmt::format("conductor {{ eta {{ {} }} k {{ {} }} roughness {{ value: {:.2f} }} }} ",
                           rgb(2), rgb(4), chance(.3) ? 0 : random_.between(0, 1));
    } else if (model == 2) {
      text_ += fmt::format(
          "physical {{ base_color {{ {} }} metallic {{ value: {} }} roughness {{ "
          "value: {:.2f} }} clearcoat {{ value: {} }} transmission {{ value: {} }} }} ",
          value("checks", rgb()), pick(0, 2), random_.between(0, 1), chance(.3) ? 1 : 0,
          chance(.2) ? .5 : 0);
    } else {
      // Above 1 too, which is bounded.
      text_ += fmt::format("classic {{ diffuse {{ {} }} ",
                           value("checks", chance(.1) ? "" : rgb(chance(.2) ? 1.5 : 1)));
      if (chance(.2)) text_ += "flat: true ";
      if (chance(.2)) text_ += fmt::format("emission {{ {} }} ", value("noise", rgb(9)));
      if (model == 1) text_ += fmt::format("specular {{ {} }} ", value("noise", rgb(.5)));
      if (model == 1 && chance(.5))
        text_ += fmt::format("reflectivity {{ value {{ {} }} }} ", rgb(.5));
      if (passes_ && chance(.4))
        text_ += fmt::format("transparency {{ value: {:.2f} }} transmission: {} ",
                             random_.between(0, 1), chance(.5) ? "STRAIGHT" : "REFRACT");
      text_ += absorption();
      text_ += "} ";
    }
    text_ += "} ";
  }
  void add_light() {
    text_ += fmt::format("nodes {{ light {{ color {{ {} }} ", rgb());
    if (chance(.5))
      text_ += fmt::format("directional {{ direction {{ {} }} }} }} }} ", xyz(vec()));
    else
      text_ += fmt::format("point {{ position {{ {} }} }} }} }} ", xyz(vec()));
  }
  std::string rectangle() {
    Vec3 u{size_ * random_.between(.2, 2), 0, 0}, v{0, size_ * random_.between(.2, 2), 0};
    if (chance(.3)) std::swap(u.x, u.z);
    if (chance(.3)) u = vec(), v = vec();
    return fmt::format("rectangle {{ corner {{ {} }} edge_u {{ {} }} edge_v {{ {} }} }}",
                       xyz(vec()), xyz(u), xyz(v));
  }
  std::string panorama() {
    std::vector<float> values;
    for (int i = 0; i < 3 * 16 * 8; ++i)
      values.push_back(static_cast<float>(std::pow(random_.between(0, 1), 8)));
    return fmt::format(
        "textures {{ name: 'sky' image {{ width: 16 height: 8 channels: 3 bits: 32 {} }} }} "
        "background {{ panorama {{ texture: 'sky' angle: {} {} }} }} ",
        blob("texels", values), pick(0, 360), chance(.5) ? "mapping: CYLINDRICAL_EQUAL_AREA" : "");
  }
  std::string tetrahedron() {
    std::string text = "mesh { closed: true inline_triangles: [0,2,1, 0,1,3, 0,3,2, 1,2,3] ";
    for (const Vec3& p : {Vec3{}, Vec3{1, 0, 0}, Vec3{0, 1, 0}, Vec3{0, 0, 1}})
      for (int axis = 0; axis < 3; ++axis)
        text += fmt::format("inline_positions: {:.9g} ", size_ * .6 * p[axis]);
    return text + (chance(.6) ? colors(4, !passes_) : "") + "}";
  }
  /// Of one or two.
  std::string combined() {
    const auto operand = [&](const std::string& of) {
      return fmt::format("operands {{ shape {{ materials: 'm{}' {} }} }} ", pick(0, kMaterials - 1),
                         of);
    };
    std::string text = "csg { operation: UNION " + operand(tetrahedron());
    if (chance(.5)) text += operand(solid());
    return text + "}";
  }
  std::string solid() {
    if (chance(.4)) {
      const Vec3 corner = vec(.7), extent = abs(vec(.5));
      return fmt::format("box {{ min {{ {} }} max {{ {} }} }}", xyz(corner), xyz(corner + extent));
    }
    return fmt::format("sphere {{ center {{ {} }} radius: {:.17g} }}", xyz(vec(.7)),
                       size_ * random_.between(.05, .4));
  }
  void add_shape() {
    text_ += "nodes { ";
    if (chance(.4))
      text_ += fmt::format(
          "transform {{ steps {{ translate {{ {} }} }} steps {{ rotate {{ axis {{ {} }} angle: {} "
          "}} }} steps {{ scale {{ x: 1 y: {} z: 1 }} }} }} ",
          xyz(vec(.3)), xyz(vec()), pick(0, 360), chance(.5) ? -2 : 1);
    const int kind = pick(0, 7);
    if (kind == 6) {
      text_ += fmt::format("shape {{ {} }} }} ", combined());
      return;
    }
    text_ += fmt::format("shape {{ materials: 'm{}' {} }} }} ", pick(0, kMaterials),
                         kind < 2   ? rectangle()
                         : kind < 4 ? mesh(!passes_)
                                    : solid());
  }

  bool passes_, is_even_, is_textured_;
  std::string text_;
};

/// A scene in which each surface scatters by itself, by BSDF, as in fog, of which nothing is seen.
std::shared_ptr<const Scene> without_lanes(std::shared_ptr<const Scene> scene) {
  // Nobody else has it, and it was not made const.
  Fog& fog = std::const_pointer_cast<Scene>(scene)->fog;
  if (fog.kind == FogKind::none) fog = {FogKind::exponential, kWhite, 1e300};
  return scene;
}

using Counts = std::vector<uint64_t>;
Counts counts_of(const TraceCounters& c, const Scene& scene) {
  Counts counts{c.rays_primary,  c.rays_reflection, c.rays_refraction,       c.hits,
                c.lights_culled, c.paths_cut,       c.texture_points_skipped};
  // A light whose texture is black spares batches the shadow ray.
  if (scene.inputs.empty()) counts.push_back(c.rays_shadow);
  return counts;
}

/// 400 random scenes, an eighth of them in each test.
class RandomPathBatches : public testing::TestWithParam<uint32_t> {};
INSTANTIATE_TEST_SUITE_P(Seeds, RandomPathBatches, testing::Range(0u, 8u));

TEST_P(RandomPathBatches, FollowEachPathAsItIsFollowedAlone) {
  constexpr uint32_t kScenes = 50;
  uint64_t with_alpha = 0, refracted = 0, even = 0, sampled = 0, hits = 0, shadows = 0, ended = 0;
  for (uint32_t seed = kScenes * GetParam(); seed < kScenes * (GetParam() + 1); ++seed) {
    const bool has_lens = seed % 5 == 0;
    PathScene random(seed, has_lens);
    const auto scene = random.build(seed % 3 == 0 ? "linear" : "bvh");
    const auto integrator =
        make_integrator(without_lanes(random.build(seed % 3 == 0 ? "linear" : "bvh")));
    with_alpha += scene->features.alpha;
    even += random.is_even();
    sampled += scene->environment != nullptr;
    std::vector<Ray> rays(1 + seed % BatchTracer::kMost);
    std::vector<SampleKey> keys(rays.size());
    for (Ray& ray : rays) ray = random.ray();
    if (seed % 2 == 0) rays = random.beam(rays.size());
    for (SampleKey& key : keys) key = random.key();
    std::vector<Color> expected(rays.size());
    TraceState state;
    for (size_t i = 0; i < rays.size(); ++i) {
      state.cone = scene->cones.of(has_lens ? keys[i].sample / 3 : keys[i].sample);
      expected[i] = integrator->radiance(rays[i], keys[i], state);
    }
    hits += state.counters.hits;
    refracted += state.counters.rays_refraction;
    shadows += state.counters.rays_shadow;
    ended += state.counters.roulette_ends;
    for (const BvhKernels& code : all_kernels()) {
      SCOPED_TRACE(fmt::format("seed {}, {}", seed, code.name));
      const auto rows = make_path_batches(*scene, code.name);
      std::vector<Color> found(rays.size());
      TraceState together;
      rows->radiances(rays, keys, found, together);
      for (size_t i = 0; i < rays.size(); ++i)
        ASSERT_EQ(found[i], expected[i]) << i << "\n" << random.text();
      EXPECT_EQ(counts_of(together.counters, *scene), counts_of(state.counters, *scene));
    }
  }
  EXPECT_GT(with_alpha, 10u);
  EXPECT_GT(refracted, 125u);
  EXPECT_GT(even, 12u);
  EXPECT_GT(sampled, 6u);
  EXPECT_GT(hits, 1'250u);
  EXPECT_GT(shadows, 300u);
  EXPECT_GT(ended, 37u);
}

TEST(PathBatches, SendsRaysThroughRasterPointsAsTheCameraDoes) {
  for (uint32_t seed = 0; seed < 40; ++seed) {
    const PathScene random(seed, false);
    const auto scene = random.build();
    const auto integrator = make_integrator(scene);
    const Camera& camera = *scene->camera;
    std::vector<SampleKey> keys;
    std::vector<Sampler::RasterSample> points;
    std::vector<Color> expected;
    TraceState state;
    for (int i = 0; i < 61; ++i) {
      keys.push_back({i % 16, i / 4, static_cast<uint32_t>(i % 7)});
      points.push_back(
          scene->sampler->raster_sample(keys.back().x, keys.back().y, keys.back().sample));
      const Vec2& at = points.back().point;
      state.cone = scene->cones.of(keys.back().sample);
      expected.push_back(integrator->radiance(camera.ray(at.x, at.y), keys.back(), state));
    }
    for (const BvhKernels& code : all_kernels()) {
      const auto rows = make_path_batches(*scene, code.name);
      std::vector<Color> found(points.size());
      TraceState together;
      rows->radiances(*camera.pinhole(), points, keys, found, together);
      EXPECT_EQ(found, expected) << seed << " " << code.name;
    }
  }
}

/// Expects of a batch of rays what each finds alone, which is returned.
template <typename MakeRay>
std::vector<Color> expect_same_alone(const std::string& text, const MakeRay& make_ray) {
  const auto build = [&] {
    return build_scene(parse_scene(text), {}, frame_of(16, 16), 1, {}, {});
  };
  const auto scene = build();
  const auto integrator = make_integrator(without_lanes(build()));
  std::vector<Ray> rays(BatchTracer::kMost);
  std::vector<SampleKey> keys(rays.size());
  std::vector<Color> expected(rays.size()), found(rays.size());
  TraceState state;
  for (size_t i = 0; i < rays.size(); ++i) {
    rays[i] = make_ray();
    keys[i] = {static_cast<int>(i), 0, 0};
    expected[i] = integrator->radiance(rays[i], keys[i], state);
  }
  for (const BvhKernels& code : all_kernels()) {
    make_path_batches(*scene, code.name)->radiances(rays, keys, found, state);
    EXPECT_EQ(found, expected) << code.name;
  }
  return expected;
}

TEST(PathBatches, TakesNormalsThatAreTheFacetsForThese) {
  // -0 equals 0, but a transform may keep one and not the other.
  const std::string text =
      "settings { integrator { kind: 'path' } } cameras {} background { solid { r: 1 g: 1 b: 1 } } "
      "nodes { transform { steps { scale { x: 2 y: 2 z: 2 } } } shape { mesh { inline_positions: "
      "[0, -1, -1, 0, 0, 1, 0, 1, -1] inline_triangles: [0, 1, 2] inline_normals: [-1, -0, -0, -1, "
      "-0, "
      "-0, -1, -0, -0] } } } nodes { shape { rectangle { corner { x: -1 y: -2 z: -2 } edge_u { z: "
      "4 } edge_v { y: 4 } } } }";
  UniformNumbers random(1);
  expect_same_alone(text, [&] {
    return Ray{{-0.5, random.between(-1, 1), random.between(-1, 1)}, {1, 0, 0}};
  });
}

TEST(PathBatches, TakesWhatFillsSolidsThatScatterEvenlyAsSinglePathsDo) {
  const std::string text =
      "settings { integrator { kind: 'path' } } cameras {} materials { name: 'a' classic { diffuse "
      "{ value { r: .5 g: .5 b: .5 } } emission { value { r: 1 g: 1 b: 1 } } absorption { r: 1 g: "
      "1 b: 1 } } } nodes { shape { materials: 'a' sphere { radius: 2 } } }";
  expect_same_alone(text, [] { return Ray{{0, 0, 0}, {0, 0, -1}}; });
}

TEST(PathBatches, LightsWhatIsBehindVeilsByLampsAlone) {
  const std::string text =
      "settings { integrator { kind: 'path' } } cameras {} materials { name: 'lamp' classic { "
      "emission { value { r: 9 g: 9 b: 9 } } } } materials { name: 'veil' opacity { value: .4 } "
      "classic {} } nodes { shape { rectangle { corner { x: -2 y: -2 z: -3 } edge_u { x: 4 } "
      "edge_v { y: 4 } } } } nodes { shape { materials: 'veil' rectangle { corner { x: -9 y: -9 z: "
      "1 } "
      "edge_u { x: 18 } edge_v { y: 18 } } } } nodes { shape { materials: 'lamp' rectangle { "
      "corner { x: -1 y: -1 z: 2 } edge_u { y: 2 } edge_v { x: 2 } } } }";
  UniformNumbers random(3);
  const std::vector<Color> alone = expect_same_alone(text, [&] {
    const Vec3 to{random.between(-1, 1), random.between(-1, 1), -3};
    return Ray{{0, 0, 0}, normalize(to)};
  });
  for (const Color& light : alone) EXPECT_GT(light.r, 0);
}

/// A red sphere 12 before the camera, which emits; with more in the scene.
std::string red_sphere_with(const std::string& camera, const std::string& rest) {
  return fmt::format(
      "settings {{ integrator {{ kind: 'path' }} }} cameras {{ {} }} materials {{ name: 'red' "
      "classic {{ diffuse {{ value {{}} }} emission {{ value {{ r: 2 }} }} }} }} nodes {{ shape {{ "
      "materials: 'red' sphere {{ center {{ z: -13 }} }} }} }} {}",
      camera, rest);
}
Color seen_straight_ahead(const std::string& text) {
  return expect_same_alone(text, [] { return Ray{{0, 0, 0}, {0, 0, -1}}; })[0];
}

TEST(PathBatches, DimsWhatIsSeenInFog) {
  const Color seen = seen_straight_ahead(
      red_sphere_with("", "fog { kind: LINEAR visibility_range: 16 color { r: 1 g: 1 b: 1 } }"));
  EXPECT_DOUBLE_EQ(seen.r, 2 * .25 + .75);
  EXPECT_DOUBLE_EQ(seen.g, .75);
}

TEST(PathBatches, SeesThroughWhatIsPassedAsFarAsTheCameraDoes) {
  const std::string nothing =
      "materials { name: 'veil' opacity { value: 0 } classic {} } nodes { shape { materials: "
      "'veil' rectangle { corner { x: -1 y: -1 z: -5 } edge_u { x: 2 } edge_v { y: 2 } } } }";
  const auto camera = [](double far) { return Ray{{0, 0, 0}, {0, 0, -1}, 0, far}; };
  const std::string text = red_sphere_with("far_distance: 20", nothing);
  EXPECT_EQ(expect_same_alone(text, [&] { return camera(11.5); })[0].r, 0);
  EXPECT_EQ(expect_same_alone(text, [&] { return camera(12.5); })[0].r, 2);
}

}  // namespace
}  // namespace tessera
