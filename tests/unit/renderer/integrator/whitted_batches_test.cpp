#include "renderer/integrator/whitted_batches.h"

#include <fmt/format.h>
#include <gtest/gtest.h>

#include <cmath>
#include <string>
#include <vector>

#include "renderer/integrator/whitted_surfaces.h"
#include "renderer/scene/scene_builder.h"
#include "tests/uniform_numbers.h"
#include "tests/unit/renderer/integrator/random_scene.h"
#include "tests/unit/renderer/scene_text.h"

namespace tessera {
namespace {

/// A random scene: shapes of all kinds that stand where they are or are moved, lights of all kinds,
/// before backgrounds of one ray at a time and panoramas. Of two seeds, one has simple materials
/// alone, which rays are followed in vectors for; the other has glass, alpha and fog as well.
class AnyScene : RandomScene {
 public:
  explicit AnyScene(uint32_t seed) : RandomScene(seed), is_simple_(seed % 4 < 2) {
    text_ = fmt::format(
        "settings {{ integrator {{ kind: 'whitted' max_depth: {} background_at_max_depth: {} {} "
        "}} }} ",
        pick(0, 5), chance(.5),
        // Shadows of glass keep all of a scene from vectors.
        !is_simple_ && chance(.5) ? "shadows: SHADOWS_OFF" : "");
    if (chance(.5))
      add_panorama();
    else
      text_ += chance(.5) ? "background { solid { r: .2 g: .3 b: .4 } } "
                          : "background { gradient { sky { r: .1 b: .9 } ground { r: .3 } } } ";
    text_ += fmt::format("cameras {{ near_distance: {:.17g} far_distance: {:.17g} }} ",
                         size_ * random_.between(0, .2), size_ * random_.between(.5, 4));
    for (int i = 0; i < 5; ++i) add_material(i);
    if (!is_simple_ && chance(.2))
      text_ += fmt::format("fog {{ visibility_range: {:.17g} color {{ {} }} }} ", 5 * size_, rgb());
    const int lights = pick(0, 5), planes = pick(0, 6), others = pick(1, 12);
    for (int i = 0; i < lights; ++i) add_light();
    for (int i = 0; i < planes; ++i) add_plane();
    for (int i = 0; i < others; ++i) add_solid();
    // So many that they are sorted out by place.
    const int lamps = chance(.3) ? pick(4, 40) : 0;
    for (int i = 0; i < lamps; ++i) add_lamp();
  }
  const std::string& text() const { return text_; }
  const BlobStore& blobs() const { return blobs_; }
  /// Where the camera's rays begin and end.
  void set_bounds(std::vector<Ray>& rays) {
    const double first = chance(.3) ? size_ * random_.between(0, .5) : 0;
    const double last = chance(.3) ? size_ * random_.between(.5, 4) : rays[0].t_max;
    for (Ray& ray : rays) ray.t_min = first, ray.t_max = last;
  }
  using RandomScene::beam;
  Ray ray() {
    const auto place = [&] { return Point3{} + vec(random_.between(0, 1) < .05 ? 1e3 : 1); };
    const Point3 from = place();
    return {from, normalize(place() - from)};
  }

 private:
  void add_panorama() {
    const int width = pick(1, 9), height = pick(1, 9);
    std::vector<std::byte> texels(size_t{3} * static_cast<size_t>(width * height));
    for (std::byte& texel : texels) texel = static_cast<std::byte>(pick(0, 256));
    text_ += fmt::format(
        "textures {{ name: 'around' image {{ texels {{ digest: '{}' }} width: {} height: {} "
        "channels: 3 bits: 8 }} }} background {{ panorama {{ texture: 'around' mapping: {} ",
        blobs_.put(std::move(texels)).hex(), width, height,
        chance(.5) ? "EQUIRECTANGULAR" : "CYLINDRICAL_EQUAL_AREA");
    if (chance(.7)) text_ += fmt::format("angle: {:.17g} ", random_.between(-360, 360));
    if (chance(.5)) text_ += "intensity: 1.7 ";
    text_ += "} ";
    if (chance(.7))
      text_ +=
          fmt::format("orientation {{ steps {{ rotate {{ axis {{ {} }} angle: {:.17g} }} }} }} ",
                      xyz(vec()), random_.between(-180, 180));
    text_ += "} ";
  }
  void add_material(int number) {
    const char* const models[] = {"LAMBERT", "SIGNED", "HALF_LAMBERT"};
    text_ += fmt::format(
        "materials {{ name: 'm{}' {} classic {{ diffuse_model: {} diffuse {{ value {{ {} }} }} "
        "ambient {{ value {{ {} }} }}",
        number, chance(.05) ? "sides: FRONT_ONLY" : "", models[pick(0, 3)], rgb(), rgb());
    if (chance(.3)) text_ += fmt::format(" specular {{ value {{ {} }} }}", rgb());
    if (chance(.5)) text_ += fmt::format(" reflectivity {{ value {{ {} }} }}", rgb());
    if (!is_simple_ && chance(.4)) {
      text_ += fmt::format(" transparency {{ value: {:.3f} }}", random_.between(0, 1));
      if (chance(.6)) text_ += " transmission: REFRACT refractive_index: 1.5";
      if (chance(.5)) text_ += fmt::format(" absorption {{ {} }}", rgb(1 / size_));
    }
    if (!is_simple_ && chance(.2)) text_ += " flat: true";
    if (!is_simple_ && chance(.2)) text_ += " grain: .5";
    text_ += " } } ";
  }
  void add_light() {
    text_ += fmt::format("nodes {{ light {{ color {{ {} }} ", rgb());
    if (chance(.3))
      text_ += fmt::format("shadow_distance: {:.17g} ", size_ * random_.between(0, 2));
    if (chance(.5)) text_ += "ambient_intensity: .2 ";
    if (chance(.3)) {
      text_ += fmt::format("directional {{ direction {{ {} }} }} }} }} ", xyz(vec()));
      return;
    }
    if (chance(.2)) {
      text_ +=
          fmt::format("cylinder {{ position {{ {} }} direction {{ {} }} beam_radius: {:.17g} }} ",
                      xyz(vec()), xyz(vec()), size_ * random_.between(0, 1));
    } else if (chance(.3)) {
      text_ +=
          fmt::format("spot {{ position {{ {} }} direction {{ {} }} beam_width: {} cut_off: {} }} ",
                      xyz(vec()), xyz(vec()), pick(0, 60), pick(60, 180));
    } else {
      text_ += fmt::format("point {{ position {{ {} }} }} ", xyz(vec()));
    }
    if (chance(.3)) text_ += fmt::format("radius: {:.17g} ", size_ * random_.between(0, 3));
    if (chance(.6))
      text_ += fmt::format("attenuation {{ scale: 2 {}: 1 {} }} ",
                           chance(.5) ? "quadratic" : "linear", chance(.5) ? "distance: PATH" : "");
    text_ += "} } ";
  }
  /// Of short reach.
  void add_lamp() {
    text_ += fmt::format(
        "nodes {{ light {{ {} color {{ {} }} radius: {:.17g} point {{ position {{ {} }} }} }} }} ",
        chance(.2) ? "scoped: true" : "", rgb(), size_ * random_.between(0, 1), xyz(vec()));
  }
  std::string material() { return fmt::format("materials: 'm{}'", pick(0, 5)); }
  void add_plane() {
    text_ += fmt::format("nodes {{ shape {{ {} plane {{ normal {{ {} }} offset: {:.17g} }} }} }} ",
                         material(), xyz(vec()), size_ * random_.between(-1, 1));
  }
  std::string solid() {
    if (chance(.6))
      return fmt::format("sphere {{ center {{ {} }} radius: {:.17g} }}", xyz(vec(.7)),
                         size_ * random_.between(.05, .5));
    const Vec3 corner = vec(.7), extent = abs(vec(.5));
    return fmt::format("box {{ min {{ {} }} max {{ {} }} }}", xyz(corner), xyz(corner + extent));
  }
  void add_solid() {
    const bool moved = chance(.3);
    text_ += fmt::format("nodes {{ {} shape {{ ",
                         moved ? fmt::format("transform {{ steps {{ translate {{ {} }} }} steps {{ "
                                             "scale {{ x: 1 y: -2 z: 1 }} }} }}",
                                             xyz(vec(.3)))
                               : "");
    if (chance(.3)) {
      text_ += fmt::format(
          "csg {{ operation: DIFFERENCE operands {{ shape {{ {} {} }} }} "
          "operands {{ shape {{ {} {} }} }} }}",
          material(), solid(), material(), solid());
    } else {
      text_ += material() + " " + (chance(.3) ? mesh(true) : solid());
    }
    text_ += " } } ";
  }

  bool is_simple_;
  std::string text_;
};

std::shared_ptr<const Scene> built(const AnyScene& scene, const std::string& accelerator) {
  v1::FrameSettings frame = frame_of(16, 16);
  frame.set_accelerator(accelerator);
  return build_scene(parse_scene(scene.text()), scene.blobs(), frame, 1);
}

using Counts = std::vector<uint64_t>;
Counts counts_of(const TraceCounters& c) {
  return {c.rays_primary,        c.rays_shadow,      c.rays_reflection, c.rays_refraction, c.hits,
          c.shadow_rays_skipped, c.branches_skipped, c.lights_culled,   c.paths_cut};
}

TEST(WhittedBatches, FollowsEachRayAsItIsFollowedAlone) {
  uint64_t simple = 0, panoramas = 0, sorted_out = 0, hits = 0, reflections = 0, shadows = 0;
  uint64_t culled = 0, refractions = 0, branched = 0;
  for (uint32_t seed = 0; seed < 600; ++seed) {
    AnyScene random(seed);
    const auto scene = built(random, seed % 3 == 0 ? "linear" : "bvh");
    simple += WhittedSurfaces(*scene).are_simple();
    panoramas += scene->background.is_plain_panorama();
    const auto full = with_every_feature(built(random, "linear"));
    const auto one_by_one = make_integrator(full);
    std::vector<Ray> rays(1 + seed % BatchTracer::kMost);
    std::vector<SampleKey> keys(rays.size());
    for (size_t i = 0; i < keys.size(); ++i) keys[i] = {static_cast<int>(i), 0, 0};
    for (Ray& ray : rays) ray = random.ray();
    if (seed % 2 == 0) rays = random.beam(rays.size());
    random.set_bounds(rays);
    std::vector<Color> expected(rays.size());
    TraceState state;
    for (size_t i = 0; i < rays.size(); ++i)
      expected[i] = one_by_one->radiance(rays[i], keys[i], state);
    hits += state.counters.hits;
    reflections += state.counters.rays_reflection;
    refractions += state.counters.rays_refraction;
    branched += !waiting_segments().empty();
    shadows += state.counters.rays_shadow;
    sorted_out += !scene->global_lights.is_everywhere();
    culled += state.counters.lights_culled;
    for (const BvhKernels& code : all_kernels()) {
      SCOPED_TRACE(fmt::format("seed {}, {}", seed, code.name));
      std::vector<Color> found(rays.size());
      TraceState together;
      make_whitted_batches(*scene, code.name)->radiances(rays, keys, found, together);
      for (size_t i = 0; i < rays.size(); ++i) ASSERT_EQ(found[i], expected[i]) << i;
      EXPECT_EQ(counts_of(together.counters), counts_of(state.counters));
    }
  }
  EXPECT_GT(simple, 150u);
  EXPECT_LT(simple, 300u);
  EXPECT_GT(panoramas, 150u);
  EXPECT_GT(hits, 10'000u);
  EXPECT_GT(reflections, 2'000u);
  EXPECT_GT(refractions, 2'000u);
  EXPECT_GT(branched, 50u);
  EXPECT_GT(shadows, 10'000u);
  EXPECT_GT(sorted_out, 50u);
  EXPECT_GT(culled, 10'000u);
}

TEST(WhittedBatches, SeesIntoBoxesThatBallsAreCutOutOf) {
  // Through the hole, on whichever side it is, to the other wall; others make boxes worth a batch.
  std::string text =
      "settings { integrator { kind: 'whitted' } } cameras {} nodes { light { directional { "
      "direction { x: .3 y: -.2 z: -1 } } } } nodes { shape { csg { operation: DIFFERENCE operands "
      "{ "
      "shape { box { min { x: -1 y: -1 z: -1 } max { x: 1 y: 1 z: 1 } } } } operands { shape { "
      "sphere { center { z: 1 } radius: .8 } } } } } } ";
  for (int i = 0; i < 4; ++i)
    text += fmt::format("nodes {{ shape {{ sphere {{ center {{ x: {} }} }} }} }} ", 5 + 3 * i);
  const auto scene = build_scene(parse_scene(text), {}, frame_of(16, 16), 1);
  const auto integrator = make_integrator(scene);
  UniformNumbers random(2);
  std::vector<Ray> rays(BatchTracer::kMost);
  for (size_t i = 0; i < rays.size(); ++i) {
    const double side = i % 2 == 0 ? 1 : -1;
    const Point3 from{random.between(-.5, .5), random.between(-.5, .5), 3 * side};
    const Point3 to{random.between(-.5, .5), random.between(-.5, .5), 0};
    rays[i] = {from, normalize(to - from)};
  }
  const std::vector<SampleKey> keys(rays.size());
  std::vector<Color> expected(rays.size()), found(rays.size());
  TraceState state;
  for (size_t i = 0; i < rays.size(); ++i) expected[i] = integrator->radiance(rays[i], {}, state);
  EXPECT_EQ(state.counters.hits, rays.size());
  for (const BvhKernels& code : all_kernels()) {
    make_whitted_batches(*scene, code.name)->radiances(rays, keys, found, state);
    EXPECT_EQ(found, expected) << code.name;
  }
}

TEST(WhittedBatches, PassesBacksThatAreMetByTheLastDigit) {
  const auto description = parse_scene(
      "settings { integrator { kind: 'whitted' } } cameras {} background { solid { r: 1 } } nodes "
      "{ "
      "light { directional { direction { y: -1 } } } } materials { name: 'm' sides: FRONT_ONLY "
      "classic {} } nodes { shape { materials: 'm' sphere { center { x: .5 y: .25 } radius: .75 } "
      "} }");
  const auto scene = build_scene(description, {}, frame_of(16, 16), 1);
  const auto one_by_one =
      make_integrator(with_every_feature(build_scene(description, {}, frame_of(16, 16), 1)));
  UniformNumbers random(3);
  uint64_t passed = 0;
  for (int i = 0; i < 20; ++i) {
    std::vector<Ray> rays(BatchTracer::kMost);
    const std::vector<SampleKey> keys(rays.size());
    std::vector<Color> expected(rays.size()), found(rays.size());
    TraceState alone;
    for (size_t j = 0; j < rays.size(); ++j) {
      rays[j] = {{random.between(-9, -1), 1, 0}, {1, 0, 0}};  // which touches the ball
      expected[j] = one_by_one->radiance(rays[j], keys[j], alone);
    }
    passed += alone.counters.rays_refraction;
    for (const BvhKernels& code : all_kernels()) {
      TraceState together;
      make_whitted_batches(*scene, code.name)->radiances(rays, keys, found, together);
      ASSERT_EQ(found, expected) << code.name;
      ASSERT_EQ(counts_of(together.counters), counts_of(alone.counters)) << code.name;
    }
  }
  EXPECT_GT(passed, 10u);
}

TEST(WhittedBatches, SendsRaysThroughRasterPointsAsTheCameraDoes) {
  for (uint32_t seed = 0; seed < 60; ++seed) {
    AnyScene random(seed);
    const auto scene = built(random, "bvh");
    const auto integrator = make_integrator(scene);
    const Camera& camera = *scene->camera;
    std::vector<Sampler::RasterSample> points;
    for (int i = 0; i < 61; ++i) {
      const int column = i % 16, row = i / 4;
      points.push_back({{column + .25, row + .75}, false});
    }
    std::vector<Color> expected;
    TraceState state;
    for (const auto& [point, negative] : points)
      expected.push_back(integrator->radiance(camera.ray(point.x, point.y), {}, state));
    for (const BvhKernels& code : all_kernels()) {
      const auto tracer = make_whitted_batches(*scene, code.name);
      std::vector<Color> found(points.size());
      TraceState together;
      const std::vector<SampleKey> keys(points.size());
      tracer->radiances(*camera.pinhole(), points, keys, found, together);
      EXPECT_EQ(found, expected) << code.name;
      EXPECT_EQ(counts_of(together.counters), counts_of(state.counters)) << code.name;
    }
  }
}

}  // namespace
}  // namespace tessera
