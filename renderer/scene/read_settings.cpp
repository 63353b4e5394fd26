#include "renderer/scene/read_settings.h"

#include <fmt/format.h>

#include <array>
#include <vector>

#include "base/error.h"
#include "renderer/film/tile.h"
#include "renderer/scene/check.h"

namespace tessera {

namespace {

const Where kSettings{.kind = "settings"};

IntegratorKind read_integrator(const std::string& name) {
  if (name.empty() || name == "auto" || name == "whitted") return IntegratorKind::whitted;
  if (name == "normals") return IntegratorKind::normals;
  if (name == "depth") return IntegratorKind::depth;
  const std::vector<std::string>& known = integrator_names();
  throw scene_error(fmt::format("there is no integrator '{}'; expected one of {}{}", name,
                                fmt::join(known, ", "), suggestion(name, known)));
}

int read_side(std::string_view name, uint32_t frame, bool in_scene, uint32_t scene, int fallback) {
  const uint32_t side = frame != 0 ? frame : in_scene ? scene : static_cast<uint32_t>(fallback);
  return static_cast<int>(checked(kSettings, name, side, {.min = 1, .max = kMaxFrameSide}));
}

SamplePattern read_pattern(v1::Sampling::Pattern pattern, uint32_t samples) {
  switch (pattern) {
    case v1::Sampling::CENTER:
      return SamplePattern::center;
    case v1::Sampling::OWEN_SOBOL:
      return SamplePattern::owen_sobol;
    case v1::Sampling::CENTERED_GRID:
      return SamplePattern::centered_grid;
    case v1::Sampling::CORNER_GRID:
      return SamplePattern::corner_grid;
    case v1::Sampling::INDEPENDENT:
      return SamplePattern::independent;
    default:
      return samples == 1 ? SamplePattern::center : SamplePattern::owen_sobol;
  }
}

void check_square(uint32_t samples) {
  uint32_t side = 1;
  while (side * side < samples) ++side;
  if (side * side != samples) {
    fail_value(kSettings, "sampling.samples_per_pixel", std::to_string(samples),
               fmt::format("a square number for a grid; {} and {} are near",
                           (side - 1) * (side - 1), side * side));
  }
}

SamplerSettings read_sampling(const v1::Sampling& in, const v1::FrameSettings& frame) {
  SamplerSettings out;
  out.samples_per_pixel = frame.samples_per_pixel() != 0 ? frame.samples_per_pixel()
                          : in.has_samples_per_pixel()   ? in.samples_per_pixel()
                                                         : 1;
  checked(kSettings, "sampling.samples_per_pixel", out.samples_per_pixel,
          {.min = 1, .max = 1 << 20});
  out.seed = frame.seed();
  out.pattern = read_pattern(in.pattern(), out.samples_per_pixel);
  if (out.pattern == SamplePattern::centered_grid || out.pattern == SamplePattern::corner_grid) {
    check_square(out.samples_per_pixel);
  }
  switch (in.filter()) {
    case v1::Sampling::BOX:
      out.filter_radius = 0.5;
      break;
    case v1::Sampling::TENT:
      out.filter = PixelFilter::tent;
      out.filter_radius = 1;
      break;
    default:
      fail_unsupported(kSettings,
                       fmt::format("pixel filter {}", v1::Sampling::Filter_Name(in.filter())));
  }
  if (in.has_filter_radius()) {
    out.filter_radius = checked(kSettings, "sampling.filter_radius", in.filter_radius(),
                                {.min = 0, .max = 16, .above_min = true});
  }
  if (in.has_target_error()) fail_unsupported(kSettings, "sampling.target_error");
  return out;
}

}  // namespace

const std::vector<std::string>& integrator_names() {
  static const std::vector<std::string> names{"auto", "whitted", "normals", "depth"};
  return names;
}

RenderSettings read_settings(const v1::Settings& in, const v1::FrameSettings& frame) {
  RenderSettings out;
  out.width = read_side("width", frame.width(), in.has_width(), in.width(), out.width);
  out.height = read_side("height", frame.height(), in.has_height(), in.height(), out.height);
  if (int64_t{out.width} * out.height > kMaxFramePixels) {
    fail_value(kSettings, "the frame", fmt::format("{}x{} pixels", out.width, out.height),
               fmt::format("at most {} in all", kMaxFramePixels));
  }
  out.time = checked(kSettings, "time", frame.time());
  const v1::IntegratorSettings& integrator = in.integrator();
  out.integrator =
      read_integrator(frame.integrator().empty() ? integrator.kind() : frame.integrator());
  if (integrator.has_max_depth()) {
    checked(kSettings, "integrator.max_depth", integrator.max_depth(),
            {.min = 0, .max = kMaxDepth});
    out.max_depth = integrator.max_depth();
  }
  out.shadows = integrator.shadows();
  out.background_at_max_depth = integrator.background_at_max_depth();
  out.ambient = checked(kSettings, "integrator.ambient", integrator.ambient());
  out.sampler = read_sampling(in.sampling(), frame);
  return out;
}

}  // namespace tessera
