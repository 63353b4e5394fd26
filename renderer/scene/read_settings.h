#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include "proto/tessera/v1/farm.pb.h"
#include "proto/tessera/v1/scene.pb.h"
#include "renderer/math/color.h"
#include "renderer/sampler/sampler.h"

namespace tessera {

/// What traces a frame.
enum class IntegratorKind { whitted, normals, depth };

/// The names of --integrator; the first is the default.
const std::vector<std::string>& integrator_names();

/// The scene's settings with the frame's over them: all that tracing asks.
struct RenderSettings {
  int width = 960, height = 540;
  double time = 0;
  IntegratorKind integrator = IntegratorKind::whitted;
  uint32_t max_depth = 8;
  v1::IntegratorSettings::Shadows shadows = v1::IntegratorSettings::SHADOWS_ON;
  bool background_at_max_depth = false;
  Color ambient = kBlack;
  SamplerSettings sampler;
};

/// Recursion deeper than this is refused.
inline constexpr uint32_t kMaxDepth = 10000;

/// A width, height or sample count of 0 in `frame`, or an empty name, means the scene's.
RenderSettings read_settings(const v1::Settings& settings, const v1::FrameSettings& frame);

}  // namespace tessera
