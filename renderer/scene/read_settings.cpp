#include "renderer/scene/read_settings.h"

#include <fmt/format.h>

#include <algorithm>
#include <cstdint>
#include <string_view>
#include <utility>

#include "base/error.h"
#include "renderer/accel/make_accelerator.h"
#include "renderer/film/tile.h"
#include "renderer/scene/check.h"

namespace tessera {

namespace {

const Where kSettings{.kind = "settings"};

IntegratorKind integrator_kind(const std::string& name) {
  if (name == "whitted") return IntegratorKind::whitted;
  if (name == "path") return IntegratorKind::path;
  return IntegratorKind::automatic;
}

View view_of(const std::string& name) {
  constexpr std::pair<const char*, View> kViews[] = {{"normals", View::normals},
                                                     {"depth", View::depth},
                                                     {"albedo", View::albedo},
                                                     {"ids", View::ids},
                                                     {"cost", View::cost}};
  for (const auto& [view_name, view] : kViews) {
    if (name == view_name) return view;
  }
  return View::none;
}

/// The first number that there is, held against 1 to `most`.
uint32_t choose(std::string_view name, uint32_t frame, bool in_scene, uint32_t scene,
                uint32_t fallback, uint32_t most) {
  const uint32_t value = frame != 0 ? frame : in_scene ? scene : fallback;
  checked(kSettings, name, value, {.min = 1, .max = static_cast<double>(most)});
  return value;
}

/// The first name that there is, held against those that there are.
std::string choose(std::string_view field, const std::string& frame, const std::string& scene,
                   const std::vector<std::string>& names) {
  const std::string& name = !frame.empty() ? frame : !scene.empty() ? scene : names.front();
  if (std::find(names.begin(), names.end(), name) == names.end()) {
    fail_value(kSettings, field, fmt::format("'{}'", name),
               fmt::format("one of {}{}", fmt::join(names, ", "), suggestion(name, names)));
  }
  return name;
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
  out.samples_per_pixel = frame.samples_per_pixel();
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
  static const std::vector<std::string> names{"auto",  "whitted", "path", "normals",
                                              "depth", "albedo",  "ids",  "cost"};
  return names;
}

v1::FrameSettings complete(v1::FrameSettings frame, const v1::Settings& in) {
  frame.set_width(choose("width", frame.width(), in.has_width(), in.width(), kDefaultFrameWidth,
                         kMaxFrameSide));
  frame.set_height(choose("height", frame.height(), in.has_height(), in.height(),
                          kDefaultFrameHeight, kMaxFrameSide));
  if (int64_t{frame.width()} * frame.height() > kMaxFramePixels) {
    fail_value(kSettings, "the frame", fmt::format("{}x{} pixels", frame.width(), frame.height()),
               fmt::format("at most {} in all", kMaxFramePixels));
  }
  const v1::Sampling& sampling = in.sampling();
  frame.set_samples_per_pixel(choose("sampling.samples_per_pixel", frame.samples_per_pixel(),
                                     sampling.has_samples_per_pixel(), sampling.samples_per_pixel(),
                                     1, kMaxSamplesPerPixel));
  frame.set_integrator(
      choose("integrator.kind", frame.integrator(), in.integrator().kind(), integrator_names()));
  frame.set_accelerator(
      choose("accelerator", frame.accelerator(), in.accelerator(), available_accelerators()));
  return frame;
}

RenderSettings read_settings(const v1::Settings& in, const v1::FrameSettings& asked) {
  const v1::FrameSettings frame = complete(asked, in);
  RenderSettings out;
  out.width = static_cast<int>(frame.width());
  out.height = static_cast<int>(frame.height());
  out.time = checked(kSettings, "time", frame.time());
  out.accelerator = *parse_accelerator(frame.accelerator());
  const v1::IntegratorSettings& integrator = in.integrator();
  out.integrator = integrator_kind(frame.integrator());
  out.view = view_of(frame.integrator());
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
