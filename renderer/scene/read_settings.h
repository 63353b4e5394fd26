#pragma once

#include <algorithm>
#include <bit>
#include <cstdint>
#include <string>
#include <vector>

#include "proto/tessera/v1/farm.pb.h"
#include "proto/tessera/v1/scene.pb.h"
#include "renderer/accel/accelerator.h"
#include "renderer/film/aov.h"
#include "renderer/math/color.h"
#include "renderer/sampler/sampler.h"

namespace tessera {

/// What follows light; `automatic` until the scene has been looked at.
enum class IntegratorKind { automatic, whitted, path };
/// The counter of building where that was done: 1 for path, 0 for whitted.
inline constexpr char kAutoChosePath[] = "auto_chose_path";
/// What is shown instead of light.
enum class View { none, normals, depth, albedo, ids, wireframe, cost, samples, error };

/// The names of --integrator; the first is the default.
const std::vector<std::string>& integrator_names();
/// Whether a picture by that name shows light; the others are views.
bool shows_light(const std::string& integrator);

/// The names of --filter, in the order of PixelFilter and of v1::Sampling::Filter; the first is the
/// default.
const std::vector<std::string>& pixel_filter_names();

/// The names of --pattern, in the order of SamplePattern.
const std::vector<std::string>& sample_pattern_names();

/// The names of --shadows, in the order of v1::IntegratorSettings::Shadows; the first is the
/// default.
const std::vector<std::string>& shadows_names();

inline constexpr double kMaxFilterRadius = 16;  ///< pixels
inline constexpr uint32_t kDefaultFrameWidth = 960, kDefaultFrameHeight = 540;
inline constexpr uint32_t kMaxSamplesPerPixel = 1 << 20;
/// Adaptive sampling's bounds where nothing else is asked for.
inline constexpr uint32_t kDefaultMostSamples = 1024, kDefaultMinSamples = 16;
/// Recursion deeper than this is refused.
inline constexpr uint32_t kMaxDepth = 10000;

/// `frame` with what it leaves out, a number of 0 or an empty name, taken from the scene's settings
/// or else the default. Its seed, camera and time are as they were. Throws a scene error for what
/// is out of range or names nothing.
v1::FrameSettings complete(v1::FrameSettings frame, const v1::Settings& settings);

/// The scene's settings with the frame's over them: all that building and tracing ask.
struct RenderSettings {
  int width = 0, height = 0;
  double time = 0;
  AcceleratorKind accelerator = AcceleratorKind::bvh;
  IntegratorKind integrator = IntegratorKind::automatic;
  View view = View::none;
  /// Whether samples of a pixel differ by the lots that paths draw.
  bool draws_lots() const {
    const bool traces_light =
        view == View::none || view == View::cost || view == View::samples || view == View::error;
    return integrator == IntegratorKind::path && traces_light;
  }
  uint32_t max_depth = 8;
  v1::IntegratorSettings::Shadows shadows = v1::IntegratorSettings::SHADOWS_ON;
  bool background_at_max_depth = false;
  Color ambient = kBlack;
  SamplerSettings sampler;
  double target_error = 0;  ///< of adaptive sampling; 0: every pixel has every sample
  uint32_t min_samples = kDefaultMinSamples;
  /// How many samples adaptive sampling begins with: a power of two.
  uint32_t first_look() const { return std::bit_ceil(std::max(min_samples, 2u)); }
  AovSet aovs;
};

/// Completes `frame` first.
RenderSettings read_settings(const v1::Settings& settings, const v1::FrameSettings& frame);

}  // namespace tessera
