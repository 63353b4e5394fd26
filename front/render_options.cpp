#include "front/render_options.h"

#include <fmt/format.h>

#include <algorithm>
#include <numeric>
#include <utility>

#include "base/error.h"
#include "base/file.h"
#include "base/plural.h"
#include "front/located.h"
#include "front/placement.h"
#include "front/read_options.h"
#include "image/animation_file.h"
#include "image/image_file.h"
#include "renderer/accel/make_accelerator.h"
#include "renderer/denoise/denoiser.h"
#include "renderer/scene/read_camera.h"
#include "renderer/scene/read_settings.h"
#include "scenes/import/standard_view.h"

namespace tessera {
namespace {

/// "a, b or c; note [a]" for a help text.
std::string choices(const std::vector<std::string>& names, std::string_view note) {
  return fmt::format("{} or {}{} [{}]", fmt::join(names.begin(), names.end() - 1, ", "),
                     names.back(), note, names.front());
}

void add_output_file_option(OptionList& list, RenderOptions& options) {
  OptionGroup(list, "Picture")
      .add("-o,--output", "FILE",
           "Where to write the picture; the ending names the format. '-' is standard output, as "
           "PNG, "
           "'-.exr' as EXR and so on. May be given more than once [SCENE's name with .png, in the "
           "current folder]",
           [&options](const std::string& path) { options.outputs.emplace_back(path); })
      .repeats = true;
}

/// "NAME" or "NAME:RADIUS".
void assign_filter(RenderOptions& options, const std::string& text) {
  const size_t colon = text.find(':');
  options.filter = parse_choice("--filter", text.substr(0, colon), pixel_filter_names());
  options.filter_radius = 0;
  if (colon == std::string::npos) return;
  const double radius = parse_number("--filter NAME:RADIUS", text.substr(colon + 1));
  if (!(radius > 0 && radius <= kMaxFilterRadius)) {
    throw usage_error(fmt::format("--filter: '{}'; expected a radius above 0, at most {} pixels",
                                  text, kMaxFilterRadius));
  }
  options.filter_radius = radius;
}

void add_sampling_options(OptionList& list, RenderOptions& options) {
  OptionGroup group(list, "Samples");
  group
      .add("--spp", "N",
           fmt::format("Samples per pixel; with --target-error the most [the scene's, or 1: a "
                       "quick look, with jagged edges; with --target-error {}]",
                       kDefaultMostSamples),
           [&options](const std::string& text) {
             options.samples_per_pixel =
                 static_cast<uint32_t>(parse_whole("--spp", text, 1, kMaxSamplesPerPixel));
           })
      .most = kMaxSamplesPerPixel;
  group.add(
      "--target-error", "E",
      "Sample each block of 4x4 pixels until its estimated standard error is below E, 1 being "
      "display white; 0: all samples everywhere [the scene's, or 0]",
      [&options](const std::string& text) {
        options.target_error = parse_number("--target-error", text);
        if (!(*options.target_error >= 0)) {
          throw usage_error(
              fmt::format("--target-error: {}; expected 0 or above", *options.target_error));
        }
      });
  group.add("--min-spp", "N",
            fmt::format("With --target-error: never stop before N samples [the scene's, or {}]",
                        kDefaultMinSamples),
            [&options](const std::string& text) {
              options.min_samples =
                  static_cast<uint32_t>(parse_whole("--min-spp", text, 1, kMaxSamplesPerPixel));
            });
  group
      .add("--filter", "NAME[:RADIUS]",
           fmt::format(
               "{}: how samples weigh about a pixel's centre; RADIUS in pixels: .5, 1, 1.5, 2, 2 "
               "if left out [the scene's, or box]",
               fmt::join(pixel_filter_names(), ", ")),
           [&options](const std::string& text) { assign_filter(options, text); })
      .choices = pixel_filter_names();
  group
      .add("--pattern", "NAME",
           fmt::format("{}: how samples are spread; blue-noise evens their error out over the "
                       "picture [the scene's, or owen-sobol; center for one sample]",
                       fmt::join(sample_pattern_names(), ", ")),
           [&options](const std::string& text) {
             options.pattern = parse_choice("--pattern", text, sample_pattern_names());
           })
      .choices = sample_pattern_names();
  group.add("--seed", "N", "Seed of the sample pattern [the scene's, or 0]",
            [&options](const std::string& text) {
              options.seed = static_cast<uint32_t>(parse_whole("--seed", text, 0, UINT32_MAX));
            });
}

void check_one_animation(bool has_other) {
  if (has_other)
    throw usage_error("--turntable: has frames of its own; expected no --frames beside it");
}

void add_picture_options(OptionList& list, RenderOptions& options) {
  OptionGroup group(list, "Picture");
  group.add("--size", "WxH",
            fmt::format("Width and height in pixels [the scene's, or {}x{}]", kDefaultFrameWidth,
                        kDefaultFrameHeight),
            [&options](const std::string& text) { options.size = parse_size("--size", text); });
  group.add("--crop", "X0,Y0,X1,Y1",
            "Only these pixels of the frame, from X0,Y0 up to before X1,Y1",
            [&options](const std::string& text) { options.crop = parse_crop("--crop", text); });
  group.add(
      "--camera", "CAMERA",
      "Which of the scene's cameras, by name, description or number from 1; auto: one that sees "
      "everything, as where there is none [the first]",
      [&options](const std::string& text) { options.camera = text; });
  group
      .add("--view", "VIEW",
           fmt::format("{}: in place of the scene's cameras one that sees everything from there",
                       fmt::join(standard_view_names(), ", ")),
           [&options](const std::string& text) {
             options.view = parse_choice("--view", text, standard_view_names());
           })
      .choices = standard_view_names();
  group.add_flag("--pinhole", "Leave out the camera's lens: everything is in focus",
                 options.pinhole);
  group.add_flag("--frame-all",
                 "Move the camera, without turning it, until everything just fits the picture",
                 options.frame_all);
  group
      .add("--aovs", "LIST",
           fmt::format("Channels beside light in pictures of the format EXR: some of {}, or all",
                       fmt::join(aov_names(), ",")),
           [&options](const std::string& text) { options.aovs = parse_aovs("--aovs", text); })
      .choices = aov_names();
  group.add_flag("--transparent-background",
                 "Leave the background out where the camera sees it, in pictures of formats with "
                 "alpha, as PNG and EXR; lights and mirrors keep it",
                 options.transparent_background);
  group.add("--time", "T", "The instant to render, in seconds [the scene's]",
            [&options](const std::string& text) { options.time = parse_number("--time", text); });
  group.add(
      "--frames", "FRAMES",
      "Frames of the animation, such as 0-23, 1-100x5 or 1,5,10-20, each to NAME.NNNN.png, or all "
      "to one .gif or .apng, at the instants that its frame rate gives: not with --time",
      [&options](const std::string& text) {
        check_one_animation(options.turntable.has_value());
        options.frames = parse_frames("--frames", text);
      });
  group
      .add("--turntable", "N",
           "N frames around everything, numbered from 0, from --view or else from iso: written as "
           "those of --frames are",
           [&options](const std::string& text) {
             check_one_animation(options.frames.has_value());
             options.turntable =
                 static_cast<int>(parse_whole("--turntable", text, 1, kMostJobFrames));
             options.frames.emplace(static_cast<size_t>(*options.turntable));
             std::iota(options.frames->begin(), options.frames->end(), 0);
           })
      .most = kMostJobFrames;
}

void add_tracing_options(OptionList& list, RenderOptions& options) {
  OptionGroup group(list, "Tracing");
  group.add("--accel", "KIND", choices(available_accelerators(), "; none changes a pixel"),
            [&options](const std::string& text) {
              options.accelerator = parse_choice("--accel", text, available_accelerators());
            });
  group
      .add("--integrator", "KIND",
           choices(integrator_names(),
                   "; all but the first three show what is there instead of light, or how it was "
                   "found"),
           [&options](const std::string& text) {
             options.integrator = parse_choice("--integrator", text, integrator_names());
           })
      .choices = integrator_names();
  group
      .add("--max-depth", "N",
           "Most bounces in a row; a mirror shows one [the scene's, or 8; path: 64]",
           [&options](const std::string& text) {
             options.max_depth =
                 static_cast<uint32_t>(parse_whole("--max-depth", text, 0, kMaxDepth));
           })
      .most = kMaxDepth;
  group
      .add("--shadows", "KIND",
           fmt::format("{}: whether lights cast them; by-light: those that say so [the scene's, "
                       "or {}]",
                       fmt::join(shadows_names(), ", "), shadows_names().front()),
           [&options](const std::string& text) {
             const std::vector<std::string>& names = shadows_names();
             const std::string name = parse_choice("--shadows", text, names);
             options.shadows = static_cast<v1::IntegratorSettings::Shadows>(
                 std::find(names.begin(), names.end(), name) - names.begin());
           })
      .choices = shadows_names();
}

void add_tile_option(OptionList& list, RenderOptions& options) {
  OptionGroup(list, "Who does the work")
      .add("--tile", "N", "Pixels a side of a tile [chosen from the frame and the workers]",
           [&options](const std::string& text) {
             options.tile_size = static_cast<int>(parse_whole("--tile", text, 1, kMaxFrameSide));
           });
}

void add_farm_options(OptionList& list, RenderOptions& options) {
  OptionGroup group(list, "Who does the work");
  group
      .add("--workers", "N",
           "Worker processes on this machine; 0: trace with threads in this process [one a core]",
           [&options](const std::string& text) {
             options.workers = static_cast<int>(parse_whole("--workers", text, 0, kMaxWorkers));
           })
      .most = kMaxWorkers;
  group.add("--threads", "N", "Threads of each worker [1; with --workers 0 one a core]",
            [&options](const std::string& text) {
              options.threads = static_cast<int>(parse_whole("--threads", text, 1, kMaxThreads));
            });
  group.add(
      "--verify", "SHARE",
      "The share of tiles that a second worker traces too, such as 1%; where two differ a third "
      "judges, and who was wrong is set aside [0%]",
      [&options](const std::string& text) { options.verify = parse_share("--verify", text); });
  add_connection_options(list, options.connection, "Who does the work");
  group.add_flag(
      "--resume",
      "Keep finished tiles in OUT.tiles until the pictures are written, and go on from those "
      "that an interrupted run has left there",
      options.resume);
}

void add_report_options(OptionList& list, RenderOptions& options) {
  OptionGroup group(list, "Report");
  group.add("--trace", "FILE.json",
            "Write which worker traced what when, for Perfetto or chrome://tracing; with --frames "
            "one a frame, numbered as the pictures are",
            [&options](const std::string& text) { options.trace = text; });
  group.add_text("--tev", "HOST:PORT", "Show what is traced in the image viewer tev there",
                 options.tev);
  group.add(
      "--stats", "FILE.json",
      "Write what was done, counted and timed, as one JSON object; with --frames one a frame, "
      "to FILE.NNNN.json. '-': standard output, where nothing else is printed then",
      [&options](const std::string& text) { options.stats = text; });
  group.add_flag("--quiet", "Print nothing but errors", options.quiet);
}

double frame_time(const RenderOptions& options, const v1::Settings& settings,
                  std::optional<int> frame) {
  const double rate = scene_frame_rate(options.scene, settings);
  if (options.time) return *options.time;
  if (!frame) return settings.time();
  return *frame / rate;
}

/// Those that may contradict the scene or each other, as they were typed.
std::string choices_made(const RenderOptions& options) {
  std::string out;
  const auto add = [&out](const char* name, const auto& value) {
    if (value) out += fmt::format("{}{} {}", out.empty() ? "" : " ", name, *value);
  };
  add("--spp", options.samples_per_pixel);
  add("--pattern", options.pattern);
  add("--target-error", options.target_error);
  add("--integrator", options.integrator);
  add("--accel", options.accelerator);
  return out;
}

bool can_be_rendered(const v1::Settings& settings) {
  try {
    read_settings(settings, {});
    return true;
  } catch (const Error&) {
    return false;
  }
}

/// `asked` completed. What the scene by itself is not to blame for is the options' fault.
v1::FrameSettings checked_settings(const RenderOptions& options, const v1::Settings& settings,
                                   const v1::FrameSettings& asked) {
  try {
    read_settings(settings, asked);
    return complete(asked, settings);
  } catch (const Error& error) {
    const std::string choices = choices_made(options);
    if (choices.empty() || !can_be_rendered(settings)) throw located(options.scene, error.what());
    throw usage_error(fmt::format("{}: {}", choices, error.what()));
  }
}

}  // namespace

void add_scene_options(OptionList& list, RenderOptions& options) {
  add_place_option(list, options.reading.placements);
  add_picture_options(list, options);
  add_sampling_options(list, options);
  add_output_options(list, options.output);
  add_tracing_options(list, options);
  add_read_options(list, options.reading);
  add_tile_option(list, options);
}

void add_render_options(OptionList& list, RenderOptions& options) {
  add_output_file_option(list, options);
  OptionGroup group(list, "Picture");
  group.add_flag(
      "--denoise",
      "Smooth noise away, and what is finer than it: more like the truth where samples are "
      "few, but no longer free of bias",
      options.denoise);
  group.add_flag(
      "--progressive",
      "Write the picture after 1, 4, 16 ... samples a pixel too, each in place of the one "
      "before; takes up to a third longer, for the same last picture",
      options.progressive);
  group.add(
      "--fps", "N",
      fmt::format("Frames a second that a .gif or .apng of --frames shows [the scene's, or {}]",
                  kDefaultFramesPerSecond),
      [&options](const std::string& text) {
        options.frames_per_second = parse_frame_rate("--fps", text);
      });
  add_scene_options(list, options);
  add_farm_options(list, options);
  add_report_options(list, options);
}

std::vector<std::filesystem::path> picture_paths(const RenderOptions& options) {
  if (!options.outputs.empty()) return options.outputs;
  return {std::filesystem::path(options.scene).stem().concat(".png")};
}

AovSet picture_aovs(const RenderOptions& options) {
  return options.transparent_background ? options.aovs.with(Aov::alpha) : options.aovs;
}

std::filesystem::path kept_tiles_path(const RenderOptions& options) {
  return output_place(picture_paths(options).front()).string() + ".tiles";
}

bool stats_to_standard_output(const RenderOptions& options) { return options.stats == "-"; }

int64_t pictures_to_standard_output(const RenderOptions& options) {
  return std::count_if(options.outputs.begin(), options.outputs.end(), is_standard_output);
}

bool writes_standard_output(const RenderOptions& options) {
  return stats_to_standard_output(options) || pictures_to_standard_output(options) > 0;
}

std::filesystem::path numbered_path(const std::filesystem::path& path, int frame) {
  std::filesystem::path numbered = path;
  return numbered.replace_extension(fmt::format(".{:04}{}", frame, path.extension().string()));
}

std::filesystem::path frame_path(const std::filesystem::path& path, std::optional<int> frame) {
  if (!frame || holds_frames(path)) return path;
  if (is_standard_output(path)) {
    throw usage_error(fmt::format(
        "--output: '{}' is one file; expected '-.apng' or '-.gif', which hold all frames",
        path.string()));
  }
  return numbered_path(path, *frame);
}

double scene_frame_rate(const std::string& scene_file, const v1::Settings& settings) {
  const double rate =
      settings.frames().has_per_second() ? settings.frames().per_second() : kDefaultFramesPerSecond;
  if (rate > 0) return rate;
  throw located(scene_file,
                fmt::format("settings: frames.per_second is {}; expected above 0", rate));
}

double parse_frame_rate(std::string_view option, std::string_view text) {
  const double rate = parse_number(option, text);
  if (rate > 0) return rate;
  throw usage_error(fmt::format("{}: {}; expected above 0", option, text));
}

void check_camera(const std::string& name, const v1::Scene& scene) {
  if (find_camera(scene, name)) return;
  if (scene.cameras_size() == 0)
    throw usage_error(
        fmt::format("--camera: '{}'; expected none, as the scene has no camera", name));
  // What each answers to: one without a name or description to its number.
  std::vector<std::string> names;
  for (const v1::Camera& camera : scene.cameras())
    names.push_back(!camera.name().empty()          ? camera.name()
                    : !camera.description().empty() ? camera.description()
                                                    : std::to_string(names.size() + 1));
  throw usage_error(fmt::format("--camera: '{}' is not in the scene, which has {}: {}{}", name,
                                counted(scene.cameras_size(), "camera"), fmt::join(names, ", "),
                                suggestion(name, names)));
}

v1::FrameSettings frame_settings(const RenderOptions& options, const v1::Scene& scene,
                                 std::optional<int> frame) {
  const v1::Settings& settings = scene.settings();
  v1::FrameSettings asked;
  if (options.size) {
    asked.set_width(static_cast<uint32_t>(options.size->width));
    asked.set_height(static_cast<uint32_t>(options.size->height));
  }
  asked.set_samples_per_pixel(options.samples_per_pixel.value_or(0));
  if (options.target_error) asked.set_target_error(*options.target_error);
  asked.set_min_samples(options.min_samples.value_or(0));
  asked.set_pattern(options.pattern.value_or(""));
  asked.set_pixel_filter(options.filter.value_or(""));
  asked.set_filter_radius(options.filter_radius);
  asked.set_seed(options.seed.value_or(settings.sampling().seed()));
  asked.set_integrator(options.integrator.value_or(""));
  AovSet looked_at = options.denoise ? denoising_aovs() : AovSet();
  if (options.output.auto_exposure) looked_at = looked_at.with(Aov::depth);
  asked.set_aovs(picture_aovs(options).bits() | looked_at.bits());
  asked.set_accelerator(options.accelerator.value_or(""));
  if (options.camera) check_camera(*options.camera, scene);
  asked.set_camera(options.camera.value_or(""));
  asked.set_time(frame_time(options, settings, frame));
  asked = checked_settings(options, settings, asked);
  if (options.min_samples && asked.target_error() == 0) {
    throw usage_error("--min-spp: is for --target-error; expected that beside it, above 0");
  }
  if (options.min_samples && *options.min_samples > asked.samples_per_pixel()) {
    throw usage_error(
        fmt::format("--min-spp: {}; expected at most {}, the most samples, or more "
                    "--spp",
                    *options.min_samples, asked.samples_per_pixel()));
  }
  return asked;
}

void check_instant(const RenderOptions& options, bool is_frame) {
  if (!options.time || !is_frame) return;
  throw usage_error(fmt::format("--time: a frame{} has its own instant; expected one of the two",
                                options.turntable ? " of --turntable"
                                : options.frames  ? " of --frames"
                                                  : ""));
}

void check_verify(double verify, int workers) {
  if (verify == 0 || workers >= 2) return;
  throw usage_error("--verify: needs a second worker; expected --workers 2 or more");
}

void check_shows_light(std::string_view option, const v1::FrameSettings& frame) {
  if (shows_light(frame.integrator())) return;
  throw usage_error(
      fmt::format("{}: is for light; expected --integrator auto, whitted or path beside it, not {}",
                  option, frame.integrator()));
}

PixelRect crop_window(const RenderOptions& options, const v1::FrameSettings& frame) {
  const PixelRect whole{0, 0, static_cast<int>(frame.width()), static_cast<int>(frame.height())};
  if (!options.crop) return whole;
  if (!whole.contains(*options.crop)) {
    const PixelRect& crop = *options.crop;
    throw usage_error(fmt::format("--crop: {},{},{},{}; expected a part of the frame, 0,0,{},{}",
                                  crop.x0, crop.y0, crop.x1, crop.y1, whole.x1, whole.y1));
  }
  return *options.crop;
}

}  // namespace tessera
