#include "renderer/render/block_estimate.h"

#include <fmt/format.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <cstdlib>
#include <iostream>
#include <string>
#include <vector>

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

constexpr char kSun[] =
    "background { solid { r: .1 g: .15 b: .3 } } "
    "nodes { light { directional { direction { x: -.5 y: -1 z: -.3 } } } } ";
constexpr char kSky[] =
    "background { gradient { sky { r: .5 g: .8 b: 1.2 } ground { r: .3 g: .25 b: .2 } } } ";
constexpr char kPaths[] = "settings { integrator { kind: 'path' } } ";
constexpr char kNarrowLens[] = "lens { radius_x: .1 radius_y: .1 focal_distance: 4 } ";
constexpr char kLens[] = "lens { radius_x: .3 radius_y: .3 focal_distance: 2.6 }";
constexpr int kFrame = 24, kSide = kBlockSide;
constexpr uint32_t kFirstLook = 16;

struct Calibration {
  double claimed = 0, real = 0;    ///< sums of squares over blocks
  double pixels = 0, covered = 0;  ///< that vary; in their 95 % intervals
  double ratio() const { return std::sqrt(claimed / real); }
  double coverage() const { return covered / pixels; }
};

/// Draws `seeds` independent pictures of `samples` a pixel and holds what is claimed of them
/// against what a picture of `reference_samples` says.
class Experiment {
 public:
  Experiment(const std::string& text, const std::string& pattern, uint32_t reference_samples)
      : scene_(parse_scene(text)), pattern_(pattern) {
    const auto reference = renderer(1u << 20, "owen-sobol", reference_samples);
    reference_ = render_rect(*reference, kRect, reference_samples).values;
  }

  Calibration run(uint32_t samples, uint32_t seeds) {
    std::vector<std::vector<float>> means(seeds);
    std::vector<std::vector<BlockEstimate>> estimates(seeds);
    std::vector<bool> varies(kPixels);
    for (uint32_t seed = 0; seed < seeds; ++seed) {
      draw(samples, seed, means[seed], estimates[seed], varies);
    }
    Calibration result;
    for (uint32_t seed = 0; seed < seeds; ++seed) {
      for (const BlockEstimate& block : estimates[seed]) {
        result.claimed += block.standard_error() * block.standard_error() * kSide * kSide;
      }
      for (size_t i = 0; i < kPixels; ++i) {
        const double error = means[seed][i] - reference_[3 * i];
        result.real += error * error;
        if (!varies[i]) continue;
        const BlockEstimate& block = estimates[seed][block_of(i)];
        ++result.pixels;
        if (std::abs(error) <= 1.96 * block.standard_error(place_of(i))) ++result.covered;
      }
    }
    return result;
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

  std::shared_ptr<const TileRenderer> renderer(uint32_t seed, const std::string& pattern,
                                               uint32_t samples) {
    v1::FrameSettings frame = frame_of(kFrame, kFrame);
    frame.set_samples_per_pixel(samples);
    frame.set_seed(seed);
    frame.set_pattern(pattern);
    return make_tile_renderer(scene_, {}, frame, 1);
  }

  void draw(uint32_t samples, uint32_t seed, std::vector<float>& means,
            std::vector<BlockEstimate>& blocks, std::vector<bool>& varies) {
    const auto tracer = renderer(seed, pattern_, samples);
    means.assign(kPixels, 0);
    blocks.assign(kPixels / (kSide * kSide),
                  {kSide * kSide, pattern_ != "independent", 1, kFirstLook});
    std::vector<float> first;
    for (uint32_t n = 0; n < samples; ++n) {
      const std::vector<float> values = render_rect(*tracer, kRect, 1, n).values;
      if (n == 0) first = values;
      for (size_t i = 0; i < kPixels; ++i) {
        const float v = values[3 * i];
        means[i] += v / static_cast<float>(samples);
        blocks[block_of(i)].add(place_of(i), {v, v, v});
        if (v != first[3 * i]) varies[i] = true;
      }
      const uint32_t done = n + 1;
      if (done < kFirstLook || (done & n) != 0) continue;
      for (BlockEstimate& block : blocks) block.look(done);
    }
  }

  v1::Scene scene_;
  std::string pattern_;
  std::vector<float> reference_;
};

/// How often the experiments are repeated: TESSERA_SEEDS, or a few times.
uint32_t seeds() {
  const char* asked = std::getenv("TESSERA_SEEDS");
  return asked ? static_cast<uint32_t>(std::max(1, std::atoi(asked))) : 4;
}

/// Per cent of the intervals: 95, give or take 2.
struct Coverage {
  double least = 93, most = 97;
};

void expect_honest(const std::string& scene, const std::string& pattern,
                   const Coverage& expected = {}) {
  Experiment experiment(scene, pattern, seeds() > 4 ? 32768 : 4096);
  Calibration all;
  for (const uint32_t samples : {16u, 32u, 64u}) {
    const Calibration c = experiment.run(samples, seeds());
    std::cout << fmt::format("{:>11} {:4} samples: claimed/real {:.3f}, {:.2f} % of {} covered\n",
                             pattern, samples, c.ratio(), 100 * c.coverage(), c.pixels);
    EXPECT_GT(c.ratio(), 0.9);
    EXPECT_LT(c.ratio(), 1.35);
    all.pixels += c.pixels, all.covered += c.covered;
  }
  const double covered = 100 * all.coverage();
  // Four standard deviations, were all pixels of all seeds independent.
  const double chance = 4 * 100 * std::sqrt(0.95 * 0.05 / all.pixels);
  std::cout << fmt::format("{:>11} in all: {:.2f} %, by chance up to {:.2f} more or less\n",
                           pattern, covered, chance);
  EXPECT_GT(covered, expected.least - chance);
  EXPECT_LT(covered, expected.most + chance);
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
// The estimator was chosen without this one, and claims a little too much.
TEST(BlockEstimate, claims_too_much_rather_than_too_little_under_a_sky) {
  expect_honest(balls(kPaths, "", kSky), "owen-sobol", {93, 98.5});
}

}  // namespace
}  // namespace tessera
