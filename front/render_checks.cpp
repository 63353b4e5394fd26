#include "front/render_checks.h"

#include <fmt/format.h>

#include <algorithm>
#include <set>

#include "base/all_failures.h"
#include "base/error.h"
#include "base/file.h"
#include "base/process.h"
#include "image/image_file.h"
#include "scenes/formats/read_scene.h"

namespace tessera {
namespace {

/// Each file would silently replace the one before it.
void check_distinct(const RenderOptions& options) {
  std::set<std::filesystem::path> taken;
  const auto take = [&taken](const char* option, const std::filesystem::path& path) {
    if (taken.insert(output_place(path)).second) return;
    throw usage_error(fmt::format("{}: '{}' is given twice", option, path.string()));
  };
  for (const auto& path : picture_paths(options)) take("--output", path);
  if (options.stats && !stats_to_standard_output(options)) take("--stats", *options.stats);
  if (options.trace) take("--trace", *options.trace);
}

}  // namespace

void check_render_options(const RenderOptions& options) {
  const FarmConnection& farm = options.connection;
  const bool by_farm = !farm.endpoint.empty();
  if (!by_farm && !(farm.key_file.empty() && farm.server_key.empty())) {
    throw usage_error(fmt::format("{}: is for the farm of --connect; expected that beside it",
                                  farm.key_file.empty() ? "--server-key" : "--key"));
  }
  if (by_farm && (options.workers || options.threads)) {
    throw usage_error(fmt::format("{}: cannot be chosen with --connect, whose farm has its own",
                                  options.workers ? "--workers" : "--threads"));
  }
  if (options.verify && by_farm) {
    throw usage_error("--verify: is for the coordinator to choose; expected no --connect");
  }
  check_verify(options.verify.value_or(0), options.workers.value_or(core_count()));
  if (options.resume && by_farm) {
    throw usage_error("--resume: tiles are kept where the coordinator is; expected no --connect");
  }
  if (by_farm && (options.trace || !options.tev.empty())) {
    throw usage_error(fmt::format("{}: is told by the coordinator; expected no --connect",
                                  options.trace ? "--trace" : "--tev"));
  }
  if (!options.tev.empty() && options.workers == 0) {
    throw usage_error("--tev: shows what worker processes trace; expected --workers above 0");
  }
  check_instant(options, options.frames.has_value());
  if (options.frames_per_second && !options.frames) {
    throw usage_error("--fps: is for the frames of an animation; expected --frames beside it");
  }
  if (pictures_to_standard_output(options) == 0) return;
  if (pictures_to_standard_output(options) > 1 || stats_to_standard_output(options)) {
    throw usage_error("--output: standard output is given twice; expected one file there");
  }
  if (options.progressive || options.resume) {
    throw usage_error(fmt::format("{}: keeps what is done in files; expected no '-o -'",
                                  options.progressive ? "--progressive" : "--resume"));
  }
}

void check_outputs(const RenderOptions& options) {
  check_scene_format(options.scene, options.reading);
  const auto paths = picture_paths(options);
  if (!options.aovs.empty() && std::none_of(paths.begin(), paths.end(), holds_aovs)) {
    throw usage_error(fmt::format(
        "--aovs: '{}' has no room for them; expected an output of the format EXR: -o {}",
        paths.front().string(), paths.front().stem().concat(".exr").string()));
  }
  const auto first = [&options](const std::filesystem::path& path) {
    return frame_path(path, options.frames ? std::optional(options.frames->front()) : std::nullopt);
  };
  AllFailures failures;
  for (const auto& path : paths) {
    failures.attempt([&] {
      check_writable(first(path));
      check_not_input(first(path), options.scene, "--output");
    });
  }
  const auto check_report = [&](const std::filesystem::path& path, const char* option) {
    failures.attempt([&] {
      check_output_file(first(path), option);
      check_not_input(first(path), options.scene, option);
    });
  };
  if (options.stats && !stats_to_standard_output(options)) check_report(*options.stats, "--stats");
  if (options.trace) check_report(*options.trace, "--trace");
  failures.throw_if_any();
  check_distinct(options);
  // The scene has no say in these.
  const OutputSettings output = output_settings(options.scene, {}, options.output);
  for (const auto& path : paths) {
    check_bits(path, output);
    check_alpha(path, picture_aovs(options));
  }
  if (output.color_management) check_color_management(*output.color_management);
}

}  // namespace tessera
