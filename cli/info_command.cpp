#include <fmt/format.h>

#include <CLI/CLI.hpp>
#include <cmath>
#include <memory>
#include <nlohmann/json.hpp>

#include "base/plural.h"
#include "base/process.h"
#include "cli/add_options.h"
#include "cli/command_line.h"
#include "cli/say.h"
#include "front/located.h"
#include "front/output_settings.h"
#include "front/picture_warnings.h"
#include "front/placement.h"
#include "front/read_options.h"
#include "front/render_options.h"
#include "front/standard_input.h"
#include "front/texture_decoder.h"
#include "proto/wire/scene_codec.h"
#include "renderer/scene/scene_builder.h"
#include "scenes/formats/read_scene.h"
#include "scenes/formats/scene_summary.h"

namespace tessera {
namespace {

struct InfoOptions {
  std::string scene;
  ReadOptions reading{.decode_texture = decode_texture,
                      .decode_texture_bytes = decode_texture_bytes};
  bool json = false;
};

struct SceneInfo {
  std::string digest;
  v1::FrameSettings frame;
  std::string integrator_chosen;  ///< what the frame's comes to
  uint32_t lens_samples = 0;      ///< rays of each sample; 0: there is no lens
  SceneSummary summary;
  Bounds3 bounds;  ///< of every surface, at the scene's instant
  std::vector<std::string> cameras, materials, textures;
  std::vector<std::string> warnings;
};

/// Reads and builds all that a render without options would trace and write: what is wrong with the
/// scene beyond its syntax shows here.
std::shared_ptr<const Scene> build(const std::string& path, const LoadedScene& loaded,
                                   const v1::FrameSettings& frame) {
  output_settings(path, loaded.scene.settings().output());
  try {
    return build_scene(loaded.scene, loaded.blobs, frame, core_count());
  } catch (const Error& error) {
    throw located(path, error.what());
  }
}

std::string chosen_integrator(const std::string& asked, const Scene& scene) {
  if (asked != "auto") return asked;
  return scene.settings.integrator == IntegratorKind::path ? "path" : "whitted";
}

template <typename Messages>
std::vector<std::string> names_of(const Messages& messages) {
  std::vector<std::string> names;
  for (const auto& message : messages) names.push_back(message.name());
  return names;
}

SceneInfo inspect(const InfoOptions& wanted) {
  const std::string& path = wanted.scene;
  RenderOptions options;
  options.scene = path;
  const LoadedScene loaded = read_scene(path, wanted.reading);
  SceneInfo info{.digest = scene_digest(loaded.scene),
                 .frame = frame_settings(options, loaded.scene, std::nullopt),
                 .integrator_chosen = {},
                 .summary = summarize(loaded.scene, loaded.blobs),
                 .bounds = {},
                 .cameras = names_of(loaded.scene.cameras()),
                 .materials = names_of(loaded.scene.materials()),
                 .textures = names_of(loaded.scene.textures()),
                 .warnings = loaded.warnings};
  info.summary.unused.insert(info.summary.unused.end(), loaded.unused.begin(), loaded.unused.end());
  const auto scene = build(path, loaded, info.frame);
  info.integrator_chosen = chosen_integrator(info.frame.integrator(), *scene);
  info.lens_samples = scene->camera->lens_samples();
  if (scene->surfaces) info.bounds = scene->surfaces->bounds();
  for (const std::string& warning : picture_warnings(options, loaded)) {
    info.warnings.push_back(warning);
  }
  for (const std::string& warning : located_mesh_warnings(scene->counters, options.scene)) {
    info.warnings.push_back(warning);
  }
  return info;
}

/// "lights, directional" as "lights_directional".
std::string json_key(const std::string& words) {
  std::string key;
  for (const char c : words) {
    if (c != ',') key += c == ' ' ? '_' : c;
  }
  return key;
}

bool is_empty(const Bounds3& box) { return !(box.min.x <= box.max.x); }

/// The corners; null for a number that is infinite, and for no surface at all.
nlohmann::json bounds_json(const Bounds3& box) {
  if (is_empty(box)) return nullptr;
  return {{"min", {box.min.x, box.min.y, box.min.z}}, {"max", {box.max.x, box.max.y, box.max.z}}};
}

std::string bounds_text(const Bounds3& box) {
  if (is_empty(box)) return "nothing is to be seen";
  // Bounds are rounded outward: what is the least number beside 0 was 0.
  const auto text = [](double v) { return fmt::format("{:.6g}", std::abs(v) < 1e-300 ? 0.0 : v); };
  return fmt::format("({}, {}, {}) to ({}, {}, {})", text(box.min.x), text(box.min.y),
                     text(box.min.z), text(box.max.x), text(box.max.y), text(box.max.z));
}

void print_json(const SceneInfo& info) {
  nlohmann::json counts = nlohmann::json::object();
  for (const auto& [what, count] : info.summary.counts) counts[json_key(what)] = count;
  const nlohmann::json result{{"scene", info.digest},
                              {"width", info.frame.width()},
                              {"height", info.frame.height()},
                              {"samples_per_pixel", info.frame.samples_per_pixel()},
                              {"lens_samples", info.lens_samples},
                              {"integrator", info.frame.integrator()},
                              {"integrator_chosen", info.integrator_chosen},
                              {"counts", counts},
                              {"bounds", bounds_json(info.bounds)},
                              {"cameras", info.cameras},
                              {"materials", info.materials},
                              {"textures", info.textures},
                              {"unused", info.summary.unused},
                              {"undefined", info.summary.undefined},
                              {"warnings", info.warnings}};
  // As ASCII, which no terminal takes for a command.
  say("{}\n", result.dump(2, ' ', true, nlohmann::json::error_handler_t::replace));
}

void print_list(const char* title, const std::vector<std::string>& lines) {
  for (const std::string& line : lines) say("{:<20} {}\n", title, printable(line));
}

void print_text(const SceneInfo& info) {
  say("{:<20} {}\n", "digest", info.digest);
  say("{:<20} {}x{}, {} per pixel{}\n", "picture", info.frame.width(), info.frame.height(),
      counted(info.frame.samples_per_pixel(), "sample"),
      info.lens_samples > 1 ? fmt::format(", each of {} rays through the lens", info.lens_samples)
                            : "");
  const bool is_auto = info.frame.integrator() == "auto";
  say("{:<20} {}{}\n", "integrator", info.integrator_chosen, is_auto ? ", chosen by auto" : "");
  for (const auto& [what, count] : info.summary.counts) say("{:<20} {}\n", what, count);
  say("{:<20} {}\n", "bounds", bounds_text(info.bounds));
  if (info.cameras.empty()) {
    say("{:<20} none: from (0, 0, 10) along -z, 45 degrees\n", "camera");
  }
  for (size_t i = 0; i < info.cameras.size(); ++i) {
    say("{:<20} '{}'{}\n", "camera", printable(info.cameras[i]), i == 0 ? " (the default)" : "");
  }
  print_list("material", info.materials);
  print_list("texture", info.textures);
  print_list("unused", info.summary.unused);
  print_list("undefined", info.summary.undefined);
  print_list("warning", info.warnings);
}

ExitCode info(const InfoOptions& options) {
  const SceneInfo found = inspect(options);
  options.json ? print_json(found) : print_text(found);
  if (found.summary.undefined.empty()) return ExitCode::done;
  const size_t count = found.summary.undefined.size();
  throw scene_error(fmt::format("{}: {} used but not defined: {}", options.scene,
                                counted(count, "name") + (count == 1 ? " is" : " are"),
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
  OptionList list;
  add_place_option(list, options->reading.placements);
  add_read_options(list, options->reading);
  add_options(*command, list);
  command->add_flag("--json", options->json, "Print one JSON object");
  command->callback([options, &action] {
    action = [options] {
      take_standard_input(options->scene, options->reading);
      return info(*options);
    };
  });
}

}  // namespace tessera
