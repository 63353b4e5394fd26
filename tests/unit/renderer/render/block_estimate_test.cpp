#include "renderer/render/block_estimate.h"

#include <fmt/format.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdlib>
#include <iostream>
#include <string>
#include <vector>

#include "renderer/scene/light_by_chance.h"
#include "renderer/scene/scene_builder.h"
#include "scenes/formats/read_scene.h"
#include "scenes/generate/accuracy_scenes.h"
#include "tests/source_folder.h"
#include "tests/unit/renderer/scene_text.h"

namespace tessera {
namespace {

// Turned boxes of one colour before a black background, straight through or through a lens that
// blurs them over several pixels.
std::string boxes(const std::string& camera) {
  std::string text = "cameras { perspective { field_of_view: 28 } " + camera +
                     " world_from_camera { steps { translate { z: 4 } } } } "
                     "background { solid {} } "
                     "materials { name: 'm' unlit { color { value { r: .8 g: .8 b: .8 } } } } ";
  for (int i = 0; i < 7; ++i) {
    text += fmt::format(
        "nodes {{ transform {{ steps {{ translate {{ x: {} y: {} z: {} }} }} "
        "steps {{ rotate {{ axis {{ z: 1 }} angle: {} }} }} }} shape {{ materials: 'm' "
        "box {{ min {{ x: -.25 y: -.04 z: -.1 }} max {{ x: .25 y: .04 z: 0 }} }} }} }} ",
        0.6 * std::sin(2.4 * i), 0.6 * std::cos(2.4 * i), 0.05 * i, 29 + 41 * i);
  }
  return text;
}

// A ball on a ground between a lamp and a coloured wall: soft shadows, edges, light from all sides.
constexpr char kRoom[] = R"(
  settings { integrator { kind: 'path' } }
  cameras { world_from_camera { steps { look_at { eye { x: .4 y: 1.2 z: 4 } target { y: .4 } } } }
            perspective { field_of_view: 34 } }
  materials { name: 'white' classic { diffuse { value { r: .7 g: .7 b: .7 } } } }
  materials { name: 'red' classic { diffuse { value { r: .6 g: .1 b: .1 } } } }
  materials { name: 'lamp' classic { emission { value { r: 6 g: 6 b: 6 } } } }
  nodes { shape { materials: 'white' plane { } } }
  nodes { shape { materials: 'red' rectangle { corner { x: -1 z: -1 } edge_u { z: 3 } edge_v { y: 2 } } } }
  nodes { shape { materials: 'white' sphere { center { y: .5 } radius: .5 } } }
  nodes { shape { materials: 'lamp' rectangle { corner { x: -.5 y: 2.5 z: -.5 } edge_u { x: 1 } edge_v { z: 1 } } } }
)";

// Balls of many sizes on a ground, in the sun or, by paths, under a sky.
std::string balls(const std::string& settings, const std::string& camera,
                  const std::string& light) {
  std::string text = settings + "cameras { " + camera +
                     " perspective { field_of_view: 40 } world_from_camera { steps { look_at { "
                     "eye { x: 1 y: 2 z: 5 } target { y: .3 } } } } } " +
                     light +
                     "materials { name: 'a' classic { diffuse { value { r: .2 g: .5 b: .3 } } } } "
                     "materials { name: 'b' classic { diffuse { value { r: .6 g: .5 b: .4 } } } } "
                     "nodes { shape { materials: 'b' plane {} } } ";
  for (int i = 0; i < 14; ++i) {
    const double away = 1.7 * std::sqrt(i / 14.0);
    text += fmt::format(
        "nodes {{ shape {{ materials: '{}' sphere {{ center {{ x: {} y: {} z: {} }} "
        "radius: {} }} }} }} ",
        i % 3 == 0 ? 'a' : 'b', away * std::sin(2.4 * i), 0.2 + 0.1 * (i % 4),
        away * std::cos(2.4 * i), 0.1 + 0.03 * (i % 5));
  }
  return text;
}

// A glass ball and a mirror under point lights: most of what varies is smooth.
constexpr char kGlass[] = R"(
  cameras { perspective { field_of_view: 45 }
            world_from_camera { steps { look_at { eye { x: 1 y: 2 z: 6 } target { y: .5 } } } } }
  background { solid { r: .05 g: .1 b: .2 } }
  materials { name: 'floor' classic { diffuse { value { r: .7 g: .6 b: .5 } } } }
  materials { name: 'glass' classic { transparency { value: .9 } refractive_index: 1.5 } }
  materials { name: 'mirror' classic { reflectivity { value { r: .8 g: .7 b: .6 } } } }
  nodes { light { point { position { x: 2 y: 3 z: 2 } } intensity: 6 } }
  nodes { light { point { position { x: -2 y: 4 z: 1 } } intensity: 4 } }
  nodes { shape { materials: 'floor' plane {} } }
  nodes { transform { steps { translate { y: 1 z: 1 } } } shape { materials: 'glass' sphere {} } }
  nodes { shape { materials: 'mirror' box { min { x: -3 z: -2 } max { x: -1.5 y: 2 z: -1 } } } }
)";

// A closed cell with a small lamp and a metal ball, by paths: of its light a part is rare.
std::string cell(const std::string& camera) {
  return "settings { integrator { kind: 'path' } } cameras { " + camera + R"(
    perspective { field_of_view: 60 }
    world_from_camera { steps { look_at { eye { x: 1.2 y: 1.3 z: 1.7 } target { x: -.2 y: .7 } } } } }
  materials { name: 'white' classic { diffuse { value { r: .7 g: .65 b: .6 } } } }
  materials { name: 'metal' classic { reflectivity { value { r: .9 g: .8 b: .5 } } } }
  materials { name: 'lamp' classic { emission { value { r: 60 g: 60 b: 60 } } } }
  nodes { shape { materials: 'white' box { min { x: -2 z: -2 } max { x: 2 y: 2.5 z: 2 } } } }
  nodes { shape { materials: 'metal' sphere { center { x: -.2 y: .6 z: -.2 } radius: .6 } } }
  nodes { shape { materials: 'lamp' sphere { center { x: .9 y: 2.1 z: -.9 } radius: .1 } } }
)";
}

constexpr char kSun[] =
    "background { solid { r: .1 g: .15 b: .3 } } "
    "nodes { light { directional { direction { x: -.5 y: -1 z: -.3 } } } } ";
constexpr char kSky[] =
    "background { gradient { sky { r: .5 g: .8 b: 1.2 } ground { r: .3 g: .25 b: .2 } } } ";
constexpr char kPaths[] = "settings { integrator { kind: 'path' } } ";
constexpr char kCellLens[] = "lens { radius_x: .05 radius_y: .05 focal_distance: 2.5 } ";
constexpr char kNarrowLens[] = "lens { radius_x: .1 radius_y: .1 focal_distance: 4 } ";
constexpr char kLens[] = "lens { radius_x: .3 radius_y: .3 focal_distance: 2.6 }";
constexpr int kFrame = 24, kSide = kBlockSide;
constexpr uint32_t kFirstLook = 16;

struct Calibration {
  double claimed = 0, real = 0;    ///< sums of squares over blocks
  double pixels = 0, covered = 0;  ///< that vary; in their 95 % intervals
  double ratio() const { return std::sqrt(claimed / real); }
  double coverage() const { return 100 * covered / pixels; }
};

/// Draws independent pictures as with --target-error and holds what is claimed of them, whenever
/// they are looked at, against a picture of many samples.
class Experiment {
 public:
  Experiment(LoadedScene loaded, const std::string& pattern, uint32_t most, uint32_t reference)
      : loaded_(std::move(loaded)), pattern_(pattern), most_(most) {
    const auto tracer = renderer(frame_for(1u << 20, "owen-sobol", reference));
    reference_ = render_rect(*tracer, kRect, reference).values;
  }

  /// Of the looks from the first on, over `seeds` pictures.
  std::vector<Calibration> run(uint32_t seeds) {
    std::vector<std::vector<Look>> looks(seeds);
    std::vector<bool> varies(kPixels);
    for (uint32_t seed = 0; seed < seeds; ++seed) looks[seed] = draw(seed, varies);
    std::vector<Calibration> results(looks.front().size());
    for (const std::vector<Look>& of_seed : looks) {
      for (size_t look = 0; look < results.size(); ++look)
        count(of_seed[look], varies, results[look]);
    }
    return results;
  }

 private:
  static constexpr PixelRect kRect{0, 0, kFrame, kFrame};
  static constexpr size_t kPixels = size_t{kFrame} * kFrame;

  static size_t block_of(size_t i) {
    return i / kFrame / kSide * (kFrame / kSide) + i % kFrame / kSide;
  }
  static int place_of(size_t i) {
    return static_cast<int>(i / kFrame % kSide * kSide + i % kFrame % kSide);
  }

  struct Look {
    std::vector<double> means, standard_errors;
    double claimed = 0;  ///< summed over the pixels: the blocks' square
  };

  v1::FrameSettings frame_for(uint32_t seed, const std::string& pattern, uint32_t samples) const {
    v1::FrameSettings frame = frame_of(kFrame, kFrame);
    frame.clear_accelerator();
    frame.set_samples_per_pixel(samples);
    frame.set_seed(seed);
    frame.set_pattern(pattern);
    // So that textures are filtered alike in all of them; never met.
    frame.set_target_error(1e-9);
    frame.set_min_samples(kFirstLook);
    return frame;
  }

  std::shared_ptr<const TileRenderer> renderer(const v1::FrameSettings& frame) const {
    return make_tile_renderer(loaded_.scene, loaded_.blobs, frame, 1);
  }

  std::vector<Look> draw(uint32_t seed, std::vector<bool>& varies) {
    const v1::FrameSettings wanted = frame_for(seed, pattern_, most_);
    const auto tracer = renderer(wanted);
    const double by_chance = light_by_chance(*build_scene(loaded_.scene, loaded_.blobs, wanted, 1));
    std::vector<double> sums(kPixels);
    std::vector<BlockEstimate> blocks(
        kPixels / (kSide * kSide),
        {kSide * kSide, pattern_ != "independent", 1, kFirstLook, true, by_chance});
    std::vector<float> first;
    std::vector<Look> looks;
    for (uint32_t n = 0; n < most_; ++n) {
      const std::vector<float> values = render_rect(*tracer, kRect, 1, n).values;
      if (n == 0) first = values;
      for (size_t i = 0; i < kPixels; ++i) {
        const float v = values[3 * i];
        sums[i] += v;
        blocks[block_of(i)].add(place_of(i), {v, v, v});
        if (v != first[3 * i]) varies[i] = true;
      }
      const uint32_t done = n + 1;
      if (done >= kFirstLook && (done & n) == 0) looks.push_back(look_at(done, sums, blocks));
    }
    return looks;
  }

  static Look look_at(uint32_t done, const std::vector<double>& sums,
                      std::vector<BlockEstimate>& blocks) {
    Look look;
    for (BlockEstimate& block : blocks) {
      block.look(done);
      look.claimed += block.standard_error() * block.standard_error() * kSide * kSide;
    }
    for (size_t i = 0; i < kPixels; ++i) {
      look.means.push_back(sums[i] / done);
      look.standard_errors.push_back(
          blocks[block_of(i)].standard_errors()[static_cast<size_t>(place_of(i))]);
    }
    return look;
  }

  void count(const Look& look, const std::vector<bool>& varies, Calibration& result) const {
    result.claimed += look.claimed;
    for (size_t i = 0; i < kPixels; ++i) {
      const double error = look.means[i] - reference_[3 * i];
      result.real += error * error;
      if (!varies[i]) continue;
      ++result.pixels;
      if (std::abs(error) <= 1.96 * look.standard_errors[i]) ++result.covered;
    }
  }

  LoadedScene loaded_;
  std::string pattern_;
  uint32_t most_;
  std::vector<float> reference_;
};

/// How often the experiments are repeated: TESSERA_SEEDS, or a few times.
constexpr uint32_t kFewSeeds = 4;
uint32_t seeds() {
  const char* asked = std::getenv("TESSERA_SEEDS");
  return asked ? static_cast<uint32_t>(std::max(1, std::atoi(asked))) : kFewSeeds;
}
bool takes_its_time() { return seeds() > kFewSeeds; }

/// Per cent of the intervals: 95, give or take 2.
constexpr double kLeastCovered = 93, kMostCovered = 97;

/// At one number of samples it drifts further: docs/notes/sampling_measured.md says where and why.
constexpr double kLeastCoveredAtOnce = 90, kMostCoveredAtOnce = 98;
/// Four standard deviations, were all pixels of all seeds independent.
double by_chance(const Calibration& of) { return 4 * 100 * std::sqrt(0.95 * 0.05 / of.pixels); }

/// What is found at each look.
std::vector<Calibration> expect_covered(LoadedScene loaded, const std::string& pattern) {
  Experiment experiment(std::move(loaded), pattern, takes_its_time() ? 256 : 64,
                        takes_its_time() ? 8192 : 2048);
  const std::vector<Calibration> looks = experiment.run(seeds());
  Calibration all;
  uint32_t samples = kFirstLook;
  for (const Calibration& look : looks) {
    std::cout << fmt::format("{:>11} {:4} samples: claimed/real {:.3f}, {:.2f} % of {} covered\n",
                             pattern, samples, look.ratio(), look.coverage(), look.pixels);
    all.pixels += look.pixels, all.covered += look.covered;
    EXPECT_GT(look.coverage(), kLeastCoveredAtOnce - by_chance(look)) << samples;
    EXPECT_LT(look.coverage(), kMostCoveredAtOnce + by_chance(look)) << samples;
    samples *= 2;
  }
  const double chance = by_chance(all);
  std::cout << fmt::format("{:>11} in all: {:.2f} %, by chance up to {:.2f} more or less\n",
                           pattern, all.coverage(), chance);
  EXPECT_GT(all.coverage(), kLeastCovered - chance);
  EXPECT_LT(all.coverage(), kMostCovered + chance);
  return looks;
}
void expect_covered(const std::string& scene, const std::string& pattern) {
  expect_covered(LoadedScene{parse_scene(scene), {}}, pattern);
}
/// And what is claimed of blocks, which tells where samples go: of the first three looks.
void expect_honest(const std::string& scene, const std::string& pattern) {
  const auto looks = expect_covered(LoadedScene{parse_scene(scene), {}}, pattern);
  for (size_t look = 0; look < 3; ++look) {
    EXPECT_GT(looks.at(look).ratio(), 0.9);
    EXPECT_LT(looks.at(look).ratio(), 1.35);
  }
}

/// A block of 4 samples a pixel, of which those of `varying` pixels are 0 and `most` in turn.
double most_taken_off(int varying, double most) {
  BlockEstimate block(kSide * kSide, false, 1, 4);
  for (int pixel = 0; pixel < kSide * kSide; ++pixel) {
    for (int sample = 0; sample < 4; ++sample) {
      const double v = pixel < varying && sample % 2 ? most : 0;
      block.add(pixel, {v, v, v});
    }
  }
  block.look(4);
  return block.most_taken_off();
}

// The same variance of a block is less sure where one pixel has it than where all have: the root
// of one of f degrees of freedom deviates by 1 / sqrt(2 f).
TEST(BlockEstimate, doubts_what_few_pixels_say) {
  const double unseen = 1 / (64.0 * 16 * 4 * 4), variance = 1 / 3.0 / 4 / 16;
  const auto expected = [&](double freedom) {
    return std::sqrt(variance * std::pow(1 + 2 / std::sqrt(2 * freedom), 2) + unseen);
  };
  EXPECT_NEAR(most_taken_off(1, 1), expected(3), 1e-12);
  EXPECT_NEAR(most_taken_off(16, 0.25), expected(3 * 16), 1e-12);
}

/// Of 16 independent samples a pixel, `most` of pixel i in `every`-th ones and 0 in the others.
template <typename Most>
std::array<double, BlockEstimate::kMaxPixels> standard_errors(int every, Most most) {
  BlockEstimate block(kSide * kSide, false, 1, 16, true);
  for (int pixel = 0; pixel < kSide * kSide; ++pixel) {
    for (int sample = 0; sample < 16; ++sample) {
      const double v = sample % every == 0 ? most(pixel) : 0;
      block.add(pixel, {v, v, v});
    }
  }
  block.look(16);
  return block.standard_errors();
}

// Four pixels of sixteen met a light once: all have an even chance to, for what these samples know.
TEST(BlockEstimate, takes_what_few_samples_met_for_the_whole_blocks) {
  const auto errors = standard_errors(16, [](int pixel) { return pixel % 4 == 0 ? 1.0 : 0.0; });
  EXPECT_NEAR(errors[1], errors[0], 0.01 * errors[0]);
  const double variance = 1.0 / 16 / 4;
  EXPECT_GT(errors[0], std::sqrt(variance / 16));
  EXPECT_LT(errors[0], 1.3 * std::sqrt(variance / 16));
}

// Of the same spread, in all of a pixel's samples: then it is the pixel's own.
TEST(BlockEstimate, leaves_pixels_that_vary_unlike_their_own) {
  const auto errors = standard_errors(2, [](int pixel) { return pixel % 4 == 0 ? 1.0 : 0.5; });
  const double own = 0.5 / std::sqrt(15);
  EXPECT_GT(errors[0], 0.9 * own);
  EXPECT_LT(errors[0], 1.15 * own);
  EXPECT_LT(errors[1], 0.7 * errors[0]);
}

// To see that something varies a little is no reason to believe that less is hidden.
TEST(BlockEstimate, claims_no_less_where_a_pixel_begins_to_vary) {
  const auto alike = standard_errors(2, [](int) { return 0.0; });
  const auto varying = standard_errors(2, [](int pixel) { return pixel == 0 ? 1e-9 : 0.0; });
  for (size_t i = 0; i < alike.size(); ++i) {
    EXPECT_GT(alike[i], 0);
    EXPECT_GE(varying[i], alike[i]) << i;
  }
}

// What met nothing may hide what is as bright as light that only chance finds, by a third of
// display white at most.
TEST(BlockEstimate, claims_more_where_chance_finds_bright_light) {
  const auto hidden = [](double by_chance) {
    BlockEstimate block(kSide * kSide, false, 1, 16, true, by_chance);
    for (int pixel = 0; pixel < kSide * kSide; ++pixel) {
      for (int sample = 0; sample < 16; ++sample) block.add(pixel, kWhite);
    }
    block.look(16);
    EXPECT_NEAR(block.standard_error(), 1 / (32.0 * 16), 1e-12) << "samples go where they went";
    return block.standard_errors()[5];
  };
  EXPECT_NEAR(hidden(1), 1 / (32.0 * 16), 1e-12);
  EXPECT_NEAR(hidden(5), 5 / (32.0 * 16), 1e-12);
  EXPECT_NEAR(hidden(1e5), 16 / 3.0 / (32 * 16), 1e-12);
}

TEST(BlockEstimate, is_honest_on_hard_edges) { expect_honest(boxes(""), "owen-sobol"); }
TEST(BlockEstimate, is_honest_on_blurred_edges) { expect_honest(boxes(kLens), "owen-sobol"); }
TEST(BlockEstimate, is_honest_on_blurred_edges_of_independent_samples) {
  expect_honest(boxes(kLens), "independent");
}
TEST(BlockEstimate, is_honest_of_paths) { expect_honest(kRoom, "owen-sobol"); }
TEST(BlockEstimate, is_honest_of_paths_of_independent_samples) {
  expect_honest(kRoom, "independent");
}
TEST(BlockEstimate, is_honest_in_the_sun) { expect_honest(balls("", "", kSun), "owen-sobol"); }
TEST(BlockEstimate, is_honest_in_the_sun_through_a_lens) {
  expect_honest(balls("", kNarrowLens, kSun), "owen-sobol");
}
TEST(BlockEstimate, is_honest_under_a_sky) { expect_honest(balls(kPaths, "", kSky), "owen-sobol"); }
TEST(BlockEstimate, is_honest_under_a_sky_of_independent_samples) {
  expect_honest(balls(kPaths, "", kSky), "independent");
}
TEST(BlockEstimate, covers_smooth_pixels) { expect_covered(kGlass, "owen-sobol"); }
TEST(BlockEstimate, covers_rare_light) { expect_covered(cell(""), "owen-sobol"); }

/// Of scenes/samples by its file's name, of make_accuracy_scene(), or the cell above.
struct Picture {
  std::string scene, pattern;
};
void PrintTo(const Picture& picture, std::ostream* out) {
  *out << picture.scene << ", " << picture.pattern;
}

LoadedScene load(const std::string& scene) {
  if (scene == "cell") return {parse_scene(cell("")), {}};
  if (scene == "cell through a lens") return {parse_scene(cell(kCellLens)), {}};
  if (scene.find('.') == std::string::npos) return make_accuracy_scene(scene).loaded;
  return read_scene(source_folder() + "/scenes/samples/" + scene);
}

/// They take minutes: there with TESSERA_SEEDS alone.
std::vector<Picture> where_there_is_time(std::vector<Picture> pictures) {
  return takes_its_time() ? pictures : std::vector<Picture>{};
}

class BlockEstimateOf : public testing::TestWithParam<Picture> {};
GTEST_ALLOW_UNINSTANTIATED_PARAMETERIZED_TEST(BlockEstimateOf);

TEST_P(BlockEstimateOf, is_covered) {
  const Picture& picture = GetParam();
  std::cout << picture.scene << '\n';
  expect_covered(load(picture.scene), picture.pattern);
}

// Looked at while the estimator was made.
INSTANTIATE_TEST_SUITE_P(
    Known, BlockEstimateOf,
    testing::ValuesIn(where_there_is_time(
        {Picture{"cell through a lens", "owen-sobol"}, Picture{"cell", "independent"},
         Picture{"daylight.tessera", "owen-sobol"}, Picture{"knot.tessera", "blue-noise"},
         Picture{"pavilion.crt", "owen-sobol"}, Picture{"plates", "owen-sobol"},
         Picture{"caustic", "owen-sobol"}, Picture{"rectangle-light", "blue-noise"}})));
// Chosen before, and first looked at when its first form was done.
INSTANTIATE_TEST_SUITE_P(
    New, BlockEstimateOf,
    testing::ValuesIn(where_there_is_time(
        {Picture{"still_life.tessera", "owen-sobol"}, Picture{"still_life.tessera", "independent"},
         Picture{"cornell.tessera", "owen-sobol"}, Picture{"cornell.tessera", "blue-noise"},
         Picture{"cornell.tessera", "independent"}, Picture{"chess.crt", "owen-sobol"},
         Picture{"lanterns.tessera", "owen-sobol"}, Picture{"stage.tessera", "owen-sobol"},
         Picture{"glossy", "owen-sobol"}, Picture{"lens", "owen-sobol"},
         Picture{"many-lights", "independent"}, Picture{"sky-wall", "owen-sobol"}})));

}  // namespace
}  // namespace tessera
