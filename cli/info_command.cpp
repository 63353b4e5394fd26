#include <fmt/format.h>

#include <CLI/CLI.hpp>
#include <algorithm>
#include <memory>
#include <nlohmann/json.hpp>
#include <thread>

#include "base/digest.h"
#include "cli/command_line.h"
#include "cli/picture_warnings.h"
#include "cli/plural.h"
#include "cli/render_options.h"
#include "cli/say.h"
#include "proto/wire/scene_codec.h"
#include "renderer/render/tile_renderer.h"
#include "scenes/formats/read_scene.h"
#include "scenes/formats/scene_summary.h"

namespace tessera {
namespace {

struct InfoOptions {
  std::string scene;
  bool json = false;
};

struct SceneInfo {
  std::string digest;
  uint64_t blob_bytes = 0;
  v1::FrameSettings frame;
  SceneSummary summary;
  std::vector<std::string> cameras;
  std::vector<std::string> warnings;
};

/// Builds what a render would trace: whatever is wrong with the scene beyond its syntax shows here.
void check_builds(const std::string& path, const LoadedScene& loaded,
                  const v1::FrameSettings& frame) {
  try {
    const int threads = static_cast<int>(std::max(1u, std::thread::hardware_concurrency()));
    make_tile_renderer(loaded.scene, loaded.blobs, frame, threads);
  } catch (const Error& error) {
    throw scene_error({path}, error.what(), "");
  }
}

SceneInfo inspect(const std::string& path) {
  RenderOptions options;
  options.scene = path;
  const LoadedScene loaded = read_scene(path);
  SceneInfo info{.digest = Digest::of(serialize_scene(loaded.scene)).hex(),
                 .frame = frame_settings(options, loaded.scene, std::nullopt),
                 .summary = summarize(loaded.scene, loaded.blobs),
                 .cameras = {},
                 .warnings = loaded.warnings};
  check_builds(path, loaded, info.frame);
  for (const auto& [digest, data] : loaded.blobs.all()) info.blob_bytes += data->size();
  for (const std::string& warning : picture_warnings(options, loaded)) {
    info.warnings.push_back(warning);
  }
  for (const v1::Camera& camera : loaded.scene.cameras()) info.cameras.push_back(camera.name());
  return info;
}

void print_json(const SceneInfo& info) {
  nlohmann::json counts = nlohmann::json::object();
  for (const auto& [what, count] : info.summary.counts) counts[what] = count;
  const nlohmann::json result{{"scene", info.digest},
                              {"width", info.frame.width()},
                              {"height", info.frame.height()},
                              {"samples_per_pixel", info.frame.samples_per_pixel()},
                              {"blob_bytes", info.blob_bytes},
                              {"counts", counts},
                              {"cameras", info.cameras},
                              {"unused", info.summary.unused},
                              {"undefined", info.summary.undefined},
                              {"warnings", info.warnings}};
  say("{}\n", result.dump(2));
}

void print_list(const char* title, const std::vector<std::string>& lines) {
  for (const std::string& line : lines) say("{:<20} {}\n", title, line);
}

void print_text(const SceneInfo& info) {
  say("{:<20} {}\n", "digest", info.digest);
  say("{:<20} {}x{}, {} per pixel\n", "picture", info.frame.width(), info.frame.height(),
      counted(info.frame.samples_per_pixel(), "sample"));
  say("{:<20} {}\n", "bytes of blobs", info.blob_bytes);
  for (const auto& [what, count] : info.summary.counts) say("{:<20} {}\n", what, count);
  for (size_t i = 0; i < info.cameras.size(); ++i) {
    say("{:<20} '{}'{}\n", "camera", info.cameras[i], i == 0 ? " (the default)" : "");
  }
  print_list("unused", info.summary.unused);
  print_list("undefined", info.summary.undefined);
  print_list("warning", info.warnings);
}

ExitCode info(const InfoOptions& options) {
  const SceneInfo found = inspect(options.scene);
  options.json ? print_json(found) : print_text(found);
  if (found.summary.undefined.empty()) return ExitCode::done;
  throw scene_error(fmt::format("{}: {} names are used but not defined: {}", options.scene,
                                found.summary.undefined.size(),
                                fmt::join(found.summary.undefined, ", ")));
}

}  // namespace

void add_info_command(CLI::App& app, Action& action) {
  auto options = std::make_shared<InfoOptions>();
  CLI::App* command = app.add_subcommand("info", "Check a scene and tell what it holds");
  command->footer(
      "Renders nothing. Exit code 1, with the place, where the scene is wrong.\n"
      "Examples:\n"
      "  tessera info room.x3d\n"
      "  tessera info room.x3d --json | jq .unused");
  command->add_option("SCENE", options->scene, "The scene file")->required()->type_name("FILE");
  command->add_flag("--json", options->json, "Print one JSON object");
  command->callback([options, &action] { action = [options] { return info(*options); }; });
}

}  // namespace tessera
