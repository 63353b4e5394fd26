#include "cli/render_options.h"

#include <fmt/format.h>

#include <CLI/CLI.hpp>
#include <array>

#include "base/error.h"

namespace tessera {
namespace {

constexpr uint32_t kDefaultWidth = 960;
constexpr uint32_t kDefaultHeight = 540;
constexpr double kDefaultFramesPerSecond = 24;
constexpr int64_t kMaxSamplesPerPixel = int64_t{1} << 20;
constexpr int64_t kMaxWorkers = 1024;
constexpr int64_t kMaxThreads = 1024;

const std::array<std::string, 5> kAccelerators{"bvh", "octree", "nonuniform-octree", "embree",
                                               "linear"};
const std::array<std::string, 2> kBuiltAccelerators{"bvh", "linear"};
const std::array<std::string, 3> kIntegrators{"auto", "whitted", "path"};
const std::array<std::string, 2> kBuiltIntegrators{"auto", "whitted"};

/// A name of the contract that this version does not build yet is told apart from a slip of the
/// pen.
std::string built_choice(std::string_view option, const std::string& text,
                         std::span<const std::string> names, std::span<const std::string> built) {
  parse_choice(option, text, names);
  for (const std::string& name : built) {
    if (name == text) return text;
  }
  throw usage_error(fmt::format("{}: '{}' does not exist yet in this version; there are {}", option,
                                text, fmt::join(built, ", ")));
}

void add_picture_options(CLI::App& command, RenderOptions& options) {
  command
      .add_option_function<std::vector<std::string>>(
          "-o,--output",
          [&options](const std::vector<std::string>& paths) {
            options.outputs.assign(paths.begin(), paths.end());
          },
          "Where to write the picture; the ending names the format. May be given more than once "
          "[SCENE's name with .png, in the current folder]")
      ->type_name("FILE")
      ->allow_extra_args(false)
      ->group("Picture");
  const auto add = [&](const char* name, const char* type, const char* text, auto assign) {
    command.add_option_function<std::string>(name, assign, text)->type_name(type)->group("Picture");
  };
  add("--size", "WxH", "Width and height in pixels [the scene's, or 960x540]",
      [&options](const std::string& text) { options.size = parse_size("--size", text); });
  add("--spp", "N", "Samples per pixel [the scene's, or 1]", [&options](const std::string& text) {
    options.samples_per_pixel =
        static_cast<uint32_t>(parse_whole("--spp", text, 1, kMaxSamplesPerPixel));
  });
  add("--seed", "N", "Seed of the sample pattern [the scene's, or 0]",
      [&options](const std::string& text) {
        options.seed = static_cast<uint32_t>(parse_whole("--seed", text, 0, UINT32_MAX));
      });
  add("--crop", "X0,Y0,X1,Y1", "Only these pixels of the frame, from X0,Y0 up to before X1,Y1",
      [&options](const std::string& text) { options.crop = parse_crop("--crop", text); });
  add("--camera", "NAME", "Which of the scene's cameras [the first]",
      [&options](const std::string& text) { options.camera = text; });
  command
      .add_flag("--pinhole", options.pinhole, "Leave out the camera's lens: everything is in focus")
      ->group("Picture");
  add("--time", "T", "The instant to render, in seconds [the scene's]",
      [&options](const std::string& text) { options.time = parse_number("--time", text); });
  add("--frames", "A-B", "Frames A to B of the animation, each to NAME.NNNN.png",
      [&options](const std::string& text) { options.frames = parse_frames("--frames", text); });
}

void add_tracing_options(CLI::App& command, RenderOptions& options) {
  const auto add = [&](const char* name, const char* type, const char* text, auto assign) {
    command.add_option_function<std::string>(name, assign, text)->type_name(type)->group("Tracing");
  };
  add("--accel", "KIND",
      "bvh, octree, nonuniform-octree, embree or linear; none changes a pixel [bvh]",
      [&options](const std::string& text) {
        options.accelerator = built_choice("--accel", text, kAccelerators, kBuiltAccelerators);
      });
  add("--integrator", "KIND", "auto, whitted or path [auto]", [&options](const std::string& text) {
    options.integrator = built_choice("--integrator", text, kIntegrators, kBuiltIntegrators);
  });
}

void add_farm_options(CLI::App& command, RenderOptions& options) {
  const auto add = [&](const char* name, const char* type, const char* text, auto assign) {
    command.add_option_function<std::string>(name, assign, text)
        ->type_name(type)
        ->group("Who does the work");
  };
  add("--workers", "N",
      "Worker processes on this machine; 0: trace with threads in this process [one a core]",
      [&options](const std::string& text) {
        options.workers = static_cast<int>(parse_whole("--workers", text, 0, kMaxWorkers));
      });
  add("--threads", "N", "Threads of each worker [1; with --workers 0 one a core]",
      [&options](const std::string& text) {
        options.threads = static_cast<int>(parse_whole("--threads", text, 1, kMaxThreads));
      });
  add("--tile", "N", "Pixels a side of a tile [chosen from the frame and the workers]",
      [&options](const std::string& text) {
        options.tile_size = static_cast<int>(parse_whole("--tile", text, 1, kMaxFrameSide));
      });
  add("--connect", "ENDPOINT", "Let the farm of a running 'tessera serve' do it, tcp://HOST:PORT",
      [&options](const std::string& text) { options.connect = text; });
  command.add_flag("--resume", options.resume, "Take up an interrupted render of the same picture")
      ->group("Who does the work");
}

void add_report_options(CLI::App& command, RenderOptions& options) {
  command
      .add_option_function<std::string>(
          "--stats", [&options](const std::string& text) { options.stats = text; },
          "Write what was done, counted and timed, as one JSON object")
      ->type_name("FILE.json")
      ->group("Report");
  command.add_flag("--quiet", options.quiet, "Print nothing but errors")->group("Report");
}

/// The default where the scene leaves a number out; else the number, held against its range.
int64_t ranged_setting(const char* what, bool present, int64_t value, int64_t fallback,
                       int64_t most) {
  if (!present) return fallback;
  if (value < 1 || value > most) {
    throw scene_error(fmt::format("settings: {} is {}; expected 1 to {}", what, value, most));
  }
  return value;
}

void check_camera(const std::string& name, const v1::Scene& scene) {
  std::vector<std::string> names;
  for (const v1::Camera& camera : scene.cameras()) {
    if (camera.name() == name) return;
    if (!camera.name().empty()) names.push_back(camera.name());
  }
  throw usage_error(
      fmt::format("--camera: '{}' is not in the scene, which has {}{}", name,
                  names.empty() ? "no named camera" : fmt::format("{}", fmt::join(names, ", ")),
                  suggestion(name, names)));
}

double frame_time(const RenderOptions& options, const v1::Settings& settings,
                  std::optional<int> frame) {
  if (options.time) return *options.time;
  if (!frame) return settings.time();
  const double rate =
      settings.frames().has_per_second() ? settings.frames().per_second() : kDefaultFramesPerSecond;
  if (!(rate > 0)) throw scene_error(fmt::format("settings: {} frames per second", rate));
  return *frame / rate;
}

}  // namespace

void add_render_options(CLI::App& command, RenderOptions& options) {
  command.add_option("SCENE", options.scene, "The scene file; 'tessera info' tells what it holds")
      ->required()
      ->type_name("FILE");
  add_picture_options(command, options);
  add_tracing_options(command, options);
  add_farm_options(command, options);
  add_report_options(command, options);
}

std::vector<std::filesystem::path> picture_paths(const RenderOptions& options) {
  if (!options.outputs.empty()) return options.outputs;
  return {std::filesystem::path(options.scene).stem().concat(".png")};
}

std::filesystem::path numbered_path(const std::filesystem::path& path, int frame) {
  std::filesystem::path numbered = path;
  return numbered.replace_extension(fmt::format(".{:04}{}", frame, path.extension().string()));
}

v1::FrameSettings frame_settings(const RenderOptions& options, const v1::Scene& scene,
                                 std::optional<int> frame) {
  const v1::Settings& settings = scene.settings();
  const v1::Sampling& sampling = settings.sampling();
  v1::FrameSettings result;
  if (options.size) {
    result.set_width(static_cast<uint32_t>(options.size->width));
    result.set_height(static_cast<uint32_t>(options.size->height));
  } else {
    const int64_t width = ranged_setting("width", settings.has_width(), settings.width(),
                                         kDefaultWidth, kMaxFrameSide);
    const int64_t height = ranged_setting("height", settings.has_height(), settings.height(),
                                          kDefaultHeight, kMaxFrameSide);
    if (width * height > kMaxFramePixels) {
      throw scene_error(
          fmt::format("settings: {}x{} are more than {} pixels", width, height, kMaxFramePixels));
    }
    result.set_width(static_cast<uint32_t>(width));
    result.set_height(static_cast<uint32_t>(height));
  }
  result.set_samples_per_pixel(options.samples_per_pixel.value_or(
      static_cast<uint32_t>(ranged_setting("samples_per_pixel", sampling.has_samples_per_pixel(),
                                           sampling.samples_per_pixel(), 1, kMaxSamplesPerPixel))));
  result.set_seed(options.seed.value_or(sampling.seed()));
  const v1::IntegratorSettings& integrator = settings.integrator();
  result.set_integrator(
      options.integrator.value_or(integrator.has_kind() ? integrator.kind() : "auto"));
  result.set_accelerator(
      options.accelerator.value_or(settings.has_accelerator() ? settings.accelerator() : "bvh"));
  if (options.camera) check_camera(*options.camera, scene);
  result.set_camera(options.camera.value_or(""));
  result.set_time(frame_time(options, settings, frame));
  return result;
}

PixelRect crop_window(const RenderOptions& options, const v1::FrameSettings& frame) {
  const PixelRect whole{0, 0, static_cast<int>(frame.width()), static_cast<int>(frame.height())};
  if (!options.crop) return whole;
  if (!whole.contains(*options.crop)) {
    throw usage_error(fmt::format("--crop: reaches beyond the frame of {}x{} pixels", frame.width(),
                                  frame.height()));
  }
  return *options.crop;
}

}  // namespace tessera
