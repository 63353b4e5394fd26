#pragma once

#include <cstdint>
#include <filesystem>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "front/farm_connection.h"
#include "front/option_list.h"
#include "front/option_values.h"
#include "front/output_settings.h"
#include "proto/tessera/v1/farm.pb.h"
#include "proto/tessera/v1/scene.pb.h"
#include "renderer/film/aov.h"
#include "scenes/import/loaded_scene.h"

namespace tessera {

inline constexpr int64_t kMaxWorkers = 1024;
inline constexpr int64_t kMaxThreads = 1024;

/// What `tessera render` was asked for. What is absent comes from the scene or from this machine.
struct RenderOptions {
  std::string scene;
  std::vector<std::filesystem::path> outputs;
  std::optional<FrameSize> size;
  std::optional<uint32_t> samples_per_pixel;
  std::optional<double> target_error;
  std::optional<uint32_t> min_samples;
  std::optional<std::string> pattern;
  std::optional<std::string> filter;
  double filter_radius = 0;  ///< pixels; 0: the filter's own
  std::optional<uint32_t> seed;
  std::optional<std::string> accelerator;
  std::optional<std::string> integrator;
  std::optional<uint32_t> max_depth;
  std::optional<v1::IntegratorSettings::Shadows> shadows;
  AovSet aovs;  ///< asked for in pictures, beside alpha
  bool transparent_background = false;
  bool denoise = false;
  bool progressive = false;
  std::optional<PixelRect> crop;
  std::optional<FrameNumbers> frames;
  std::optional<double> frames_per_second;  ///< of files that hold all frames; > 0
  std::optional<double> time;
  std::optional<std::string> camera;
  std::optional<std::string> view;  ///< one of standard_view_names(), in place of cameras
  std::optional<int> turntable;     ///< so many frames around what there is: those of `frames`
  bool pinhole = false;
  bool frame_all = false;
  ReadOptions reading{};
  OutputOptions output;

  std::optional<int> workers;
  std::optional<int> threads;
  int tile_size = 0;
  std::optional<double> verify;
  FarmConnection connection;  ///< no endpoint: this machine does it

  std::optional<std::filesystem::path> stats;
  std::optional<std::filesystem::path> trace;  ///< the timeline
  std::string tev;                             ///< where the viewer is; empty: none
  bool quiet = false;
  bool resume = false;
};

/// The options of `render`; `options` must outlive the parsing.
void add_render_options(OptionList& list, RenderOptions& options);

/// Those of them that say what to render, for a command that leaves it to others.
void add_scene_options(OptionList& list, RenderOptions& options);

/// Where the pictures go: the outputs asked for, or the scene's name with .png in the current
/// folder.
std::vector<std::filesystem::path> picture_paths(const RenderOptions& options);

/// What pictures hold beside light.
AovSet picture_aovs(const RenderOptions& options);

/// Where --resume keeps finished tiles: beside the first picture.
std::filesystem::path kept_tiles_path(const RenderOptions& options);

/// "--stats -"
bool stats_to_standard_output(const RenderOptions& options);
/// How many of the outputs are standard output.
int64_t pictures_to_standard_output(const RenderOptions& options);
/// Whether standard output takes one of them, so that nothing else is printed there.
bool writes_standard_output(const RenderOptions& options);

/// "dir/name.png" for frame 7 is "dir/name.0007.png".
std::filesystem::path numbered_path(const std::filesystem::path& path, int frame);
/// Where the picture of a frame goes that was asked for at `path`: to a numbered file, unless one
/// file holds them all. Nothing: it is no frame of an animation. Throws usage_error for frames that
/// would be files of their own in standard output.
std::filesystem::path frame_path(const std::filesystem::path& path, std::optional<int> frame);

/// How many frames a second the animation has, as the scene says. Throws scene_error where that is
/// not above 0.
double scene_frame_rate(const std::string& scene_file, const v1::Settings& settings);
/// A rate of frames, above 0, as the option of that name is typed.
double parse_frame_rate(std::string_view option, std::string_view text);
inline constexpr double kDefaultFramesPerSecond = 24;

/// What the pixels depend on beside the scene: its settings with the options laid over them.
/// `frame` is the number of the animation's frame, if one is rendered. Throws usage_error for an
/// option that does not fit the scene, scene_error for settings of the scene out of their range.
v1::FrameSettings frame_settings(const RenderOptions& options, const v1::Scene& scene,
                                 std::optional<int> frame);

/// Throws usage_error where the scene has no camera of that name.
void check_camera(const std::string& name, const v1::Scene& scene);

/// Throws usage_error where --time is beside a frame, which has its own instant.
void check_instant(const RenderOptions& options, bool is_frame);

/// Throws usage_error where tiles are to be traced twice and so many workers are but one.
void check_verify(double verify, int workers);

/// Throws usage_error where the option is for light and the frame shows a view in its place.
void check_shows_light(std::string_view option, const v1::FrameSettings& frame);

/// The part of the frame to render. Throws usage_error where the crop reaches beyond it.
PixelRect crop_window(const RenderOptions& options, const v1::FrameSettings& frame);

}  // namespace tessera
