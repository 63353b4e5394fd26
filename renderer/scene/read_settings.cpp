#include "renderer/scene/read_settings.h"

#include <fmt/format.h>

#include <algorithm>
#include <cstdint>
#include <string_view>
#include <utility>

#include "base/choice.h"
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
  constexpr std::pair<const char*, View> kViews[] = {
      {"normals", View::normals}, {"depth", View::depth},         {"albedo", View::albedo},
      {"ids", View::ids},         {"wireframe", View::wireframe}, {"cost", View::cost},
      {"samples", View::samples}, {"error", View::error}};
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
  if (const auto known = find_choice(names, name)) return *known;
  fail_value(kSettings, field, fmt::format("'{}'", name),
             fmt::format("one of {}{}", fmt::join(names, ", "), suggestion(name, names)));
}

/// Where the name is in the list, which has it.
template <typename Enum>
Enum named(const std::vector<std::string>& names, const std::string& name) {
  return static_cast<Enum>(std::find(names.begin(), names.end(), name) - names.begin());
}

/// The name of a number of the scene; the first of `names` stands for `first`.
std::string name_of(std::string_view field, int number, int first,
                    const std::vector<std::string>& names) {
  const auto place = static_cast<size_t>(number - first);
  if (number >= first && place < names.size()) return names[place];
  fail_value(kSettings, field, std::to_string(number),
             fmt::format("one of {}", fmt::join(names, ", ")));
}

void complete_pattern(v1::FrameSettings& frame, const v1::Sampling& in) {
  const std::vector<std::string>& names = sample_pattern_names();
  std::string scene;
  if (frame.pattern().empty()) {
    scene = in.pattern() != v1::Sampling::PATTERN_DEFAULT
                ? name_of("sampling.pattern", in.pattern(), v1::Sampling::CENTER, names)
            : frame.samples_per_pixel() == 1 ? names[0]
                                             : names[1];
  }
  frame.set_pattern(choose("sampling.pattern", frame.pattern(), scene, names));
}

void check_square(uint32_t samples) {
  uint32_t side = 1;
  while (side * side < samples) ++side;
  if (side * side != samples) {
    fail_value(kSettings, "sampling.samples_per_pixel", std::to_string(samples),
               fmt::format("a square number for a grid, as {} and {}, or --pattern owen-sobol",
                           (side - 1) * (side - 1), side * side));
  }
}

/// The frame's filter and its radius, or the scene's. A filter named without a radius has its own.
void complete_filter(v1::FrameSettings& frame, const v1::Sampling& in) {
  const std::vector<std::string>& names = pixel_filter_names();
  const bool of_scene = frame.pixel_filter().empty();
  const std::string scene =
      of_scene ? name_of("sampling.filter", in.filter(), v1::Sampling::BOX, names) : "";
  frame.set_pixel_filter(choose("sampling.filter", frame.pixel_filter(), scene, names));
  const double own = default_radius(named<PixelFilter>(names, frame.pixel_filter()));
  if (frame.filter_radius() == 0) {
    frame.set_filter_radius(of_scene && in.has_filter_radius() ? in.filter_radius() : own);
  }
  checked(kSettings, "sampling.filter_radius", frame.filter_radius(),
          {.min = 0, .max = kMaxFilterRadius, .above_min = true});
}

void complete_adaptive(v1::FrameSettings& frame, const v1::Sampling& in) {
  if (!frame.has_target_error()) frame.set_target_error(in.target_error());
  checked(kSettings, "sampling.target_error", frame.target_error(), {.min = 0});
  frame.set_min_samples(choose("sampling.min_samples", frame.min_samples(), in.min_samples() != 0,
                               in.min_samples(), kDefaultMinSamples, kMaxSamplesPerPixel));
}

/// What the scene says of it, as far as it is for this frame: a number of samples for all pixels
/// alike, and a pattern of such a number, say nothing of a frame that is to have as many as it
/// takes.
v1::Sampling sampling_for(const v1::FrameSettings& frame, v1::Sampling scene) {
  if (!(frame.target_error() > 0) || scene.target_error() > 0) return scene;
  scene.clear_samples_per_pixel();
  const auto pattern = scene.pattern();
  if (pattern == v1::Sampling::CENTER || pattern == v1::Sampling::CENTERED_GRID ||
      pattern == v1::Sampling::CORNER_GRID) {
    scene.clear_pattern();
  }
  return scene;
}

SamplerSettings read_sampler(const v1::FrameSettings& frame) {
  SamplerSettings out;
  out.samples_per_pixel = frame.samples_per_pixel();
  out.seed = frame.seed();
  out.pattern = named<SamplePattern>(sample_pattern_names(), frame.pattern());
  const bool grid =
      out.pattern == SamplePattern::centered_grid || out.pattern == SamplePattern::corner_grid;
  if (grid) check_square(out.samples_per_pixel);
  // The first samples of a grid are no sample of the pixel.
  if (grid && frame.target_error() > 0) {
    fail_value(kSettings, "sampling.pattern", fmt::format("'{}'", frame.pattern()),
               "owen-sobol, independent or blue-noise with a target error");
  }
  out.filter = named<PixelFilter>(pixel_filter_names(), frame.pixel_filter());
  out.filter_radius = frame.filter_radius();
  return out;
}

}  // namespace

const std::vector<std::string>& integrator_names() {
  static const std::vector<std::string> names{"auto",  "whitted", "path", "normals",
                                              "depth", "albedo",  "ids",  "wireframe",
                                              "cost",  "samples", "error"};
  return names;
}

bool shows_light(const std::string& integrator) { return view_of(integrator) == View::none; }

const std::vector<std::string>& sample_pattern_names() {
  static const std::vector<std::string> names{"center",      "owen-sobol",  "centered-grid",
                                              "corner-grid", "independent", "blue-noise"};
  return names;
}

const std::vector<std::string>& pixel_filter_names() {
  static const std::vector<std::string> names{"box", "tent", "gaussian", "mitchell",
                                              "blackman-harris"};
  return names;
}

const std::vector<std::string>& shadows_names() {
  static const std::vector<std::string> names{"on", "by-light", "off"};
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
  const v1::Sampling sampling = sampling_for(frame, in.sampling());
  complete_adaptive(frame, sampling);
  frame.set_samples_per_pixel(choose("sampling.samples_per_pixel", frame.samples_per_pixel(),
                                     sampling.has_samples_per_pixel(), sampling.samples_per_pixel(),
                                     frame.target_error() > 0 ? kDefaultMostSamples : 1,
                                     kMaxSamplesPerPixel));
  complete_pattern(frame, sampling);
  complete_filter(frame, sampling);
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
  if (out.view == View::cost && out.accelerator == AcceleratorKind::embree) {
    fail_value(kSettings, "accelerator", "'embree'",
               "another where the integrator is 'cost': what Embree visits depends on the machine");
  }
  if (integrator.has_max_depth()) {
    checked(kSettings, "integrator.max_depth", integrator.max_depth(),
            {.min = 0, .max = kMaxDepth});
    out.max_depth = integrator.max_depth();
  }
  out.shadows = integrator.shadows();
  out.background_at_max_depth = integrator.background_at_max_depth();
  out.ambient = checked(kSettings, "integrator.ambient", integrator.ambient());
  out.sampler = read_sampler(frame);
  out.target_error = frame.target_error();
  out.min_samples = frame.min_samples();
  out.aovs = AovSet(frame.aovs());
  return out;
}

}  // namespace tessera
