#include <fmt/format.h>
#include <unistd.h>

#include <CLI/CLI.hpp>
#include <algorithm>
#include <bit>
#include <cstdlib>
#include <filesystem>
#include <memory>

#include "base/file.h"
#include "base/monotonic.h"
#include "base/process.h"
#include "bench/error/report.h"
#include "bench/error_bench.h"
#include "bench/error_render.h"
#include "cli/add_options.h"
#include "cli/bench/bench_commands.h"
#include "cli/progress_display.h"
#include "cli/say.h"
#include "front/option_values.h"
#include "front/texture_decoder.h"
#include "renderer/scene/read_settings.h"
#include "scenes/formats/read_scene.h"

namespace tessera {
namespace {

namespace fs = std::filesystem;

struct ErrorCommandOptions {
  std::vector<std::string> scenes, methods{"owen", "independent"}, references, peers;
  std::optional<FrameSize> size;
  std::optional<int> least_samples, most_samples, seeds, budget;
  int threads = 0;
  bool quick = false, cpu_time = false;
  std::string cache, json_file, csv_file, svg_folder;
};

/// Where this user's programs keep what they can make anew; empty where that is nowhere.
std::string usual_cache() {
  if (const char* folder = std::getenv("XDG_CACHE_HOME"); folder != nullptr && *folder != 0)
    return (fs::path(folder) / "tessera/references").string();
  if (const char* home = std::getenv("HOME"); home != nullptr && *home != 0)
    return (fs::path(home) / ".cache/tessera/references").string();
  return {};
}

AccuracyScene scene_named(const std::string& name) {
  const auto& known = accuracy_scene_names();
  const bool is_file = name.find_first_of("./") != std::string::npos;
  if (!is_file || std::find(known.begin(), known.end(), name) != known.end())
    return make_accuracy_scene(name);
  ReadOptions reading;
  reading.decode_texture = decode_texture;
  reading.decode_texture_bytes = decode_texture_bytes;
  AccuracyScene out{fs::path(name).stem().string(), name, read_scene(name, reading)};
  v1::Settings& settings = *out.loaded.scene.mutable_settings();
  const v1::FrameSettings frame = complete({}, settings);
  settings.set_width(frame.width());
  settings.set_height(frame.height());
  return out;
}

bool can_be_traced(const AccuracyScene& scene) {
  const auto& names = integrator_names();
  const std::string& kind = scene.loaded.scene.settings().integrator().kind();
  return kind.empty() || std::find(names.begin(), names.end(), kind) != names.end();
}

/// Those named; without any, all of our own that this program can trace.
std::vector<AccuracyScene> scenes_of(const ErrorCommandOptions& options) {
  std::vector<AccuracyScene> out;
  for (const std::string& name : options.scenes.empty() ? accuracy_scene_names() : options.scenes) {
    AccuracyScene scene = scene_named(name);
    if (options.scenes.empty() && !can_be_traced(scene)) {
      say_warning(fmt::format("left out {}: it wants the integrator '{}'", name,
                              scene.loaded.scene.settings().integrator().kind()));
      continue;
    }
    if (options.size) {
      scene.loaded.scene.mutable_settings()->set_width(static_cast<uint32_t>(options.size->width));
      scene.loaded.scene.mutable_settings()->set_height(
          static_cast<uint32_t>(options.size->height));
    }
    out.push_back(std::move(scene));
  }
  return out;
}

/// What cannot be read is no scene: it is the command line that is wrong.
Picture picture_of(const std::string& option, const std::string& file) {
  try {
    check_input_file(file, UINT64_MAX);
    return read_picture(file);
  } catch (const Error& error) {
    if (error.code() != ExitCode::bad_scene) throw;
    throw usage_error(fmt::format("{}: {}", option, error.what()));
  }
}

/// "NAME:SECONDS:SAMPLES:FILE"; only the file may have colons.
ErrorPeer read_peer(const std::string& text) {
  std::vector<std::string> parts;
  size_t start = 0;
  for (int i = 0; i < 3; ++i) {
    const size_t end = text.find(':', start);
    if (end == std::string::npos || end == start)
      throw usage_error(fmt::format("--peer: '{}'; expected NAME:SECONDS:SAMPLES:FILE", text));
    parts.push_back(text.substr(start, end - start));
    start = end + 1;
  }
  ErrorPeer out{parts[0], parse_number("--peer", parts[1]), parse_number("--peer", parts[2]), {}};
  if (!(out.seconds > 0) || !(out.samples > 0))
    throw usage_error(fmt::format("--peer: '{}'; expected seconds and samples above 0", text));
  out.picture = picture_of("--peer", text.substr(start));
  return out;
}

void parse_samples(const std::string& text, ErrorCommandOptions& options) {
  constexpr int64_t kMost = 65536;
  const size_t dash = text.find('-');
  const int64_t least = parse_whole("--samples", text.substr(0, dash), 1, kMost);
  const int64_t most =
      dash == std::string::npos
          ? least
          : parse_whole("--samples", std::string_view(text).substr(dash + 1), least, kMost);
  for (const int64_t value : {least, most})
    if (!std::has_single_bit(static_cast<uint64_t>(value)))
      throw usage_error(
          fmt::format("--samples: '{}'; expected powers of two, such as 1-4096", text));
  options.least_samples = static_cast<int>(least);
  options.most_samples = static_cast<int>(most);
}

/// A line on standard error that redraws itself on a terminal, and comes seldom elsewhere.
class Progress {
 public:
  explicit Progress(size_t scenes) : scenes_(scenes) {}
  ~Progress() { clear(); }
  Progress(const Progress&) = delete;
  Progress& operator=(const Progress&) = delete;

  void show(size_t scene, const std::string& name, const std::string& what, double share) {
    const Time now = monotonic_now();
    if (now - last_ < std::chrono::milliseconds(is_terminal_ ? 200 : 15'000)) return;
    last_ = now;
    const double done = (static_cast<double>(scene) + share) / static_cast<double>(scenes_);
    const double elapsed = to_seconds(now - start_);
    const std::string left =
        done > .01 ? fmt::format(", ETA {}", duration_text(elapsed * (1 - done) / done)) : "";
    say(stderr, "{}{} ({} of {}): {}{}{}", is_terminal_ ? "\r\x1b[K" : "", name, scene + 1, scenes_,
        what, left, is_terminal_ ? "" : "\n");
    is_drawn_ = is_terminal_;
  }
  void clear() {
    if (is_drawn_) say(stderr, "\r\x1b[K");
    is_drawn_ = false;
  }

 private:
  size_t scenes_;
  bool is_terminal_ = isatty(STDERR_FILENO) != 0, is_drawn_ = false;
  Time start_ = monotonic_now(), last_ = start_;
};

ErrorBenchOptions bench_options(const ErrorCommandOptions& options) {
  ErrorBenchOptions out;
  for (const std::string& method : options.methods)
    out.methods.push_back(parse_error_method(method));
  out.least_samples = options.least_samples.value_or(1);
  out.most_samples = options.most_samples.value_or(options.quick ? 64 : 4096);
  out.seeds = options.seeds.value_or(options.quick ? 8 : 32);
  out.threads = options.threads > 0 ? options.threads : core_count();
  out.cpu_time = options.cpu_time;
  // Their error has to be a fifth of the last row's: that is 25 / 2 times the samples.
  constexpr int kLeastReference = 256, kMostReference = 65536;
  out.reference_samples = std::clamp(16 * out.most_samples, kLeastReference, kMostReference);
  out.cache_folder = options.cache.empty() ? usual_cache() : options.cache;
  for (const std::string& file : options.references)
    out.given_reference.push_back(picture_of("--reference", file));
  for (const std::string& peer : options.peers) out.peers.push_back(read_peer(peer));
  return out;
}

void check_options(const ErrorCommandOptions& options) {
  if (!options.json_file.empty()) check_output_file(options.json_file, "--json");
  if (!options.csv_file.empty()) check_output_file(options.csv_file, "--csv");
  if (!options.svg_folder.empty()) {
    std::error_code failed;
    fs::create_directories(options.svg_folder, failed);
    if (!fs::is_directory(options.svg_folder))
      throw usage_error(fmt::format("--svg: '{}' is no folder, and cannot be made one: {}",
                                    options.svg_folder, failed.message()));
  }
  if (options.scenes.size() != 1 && !(options.references.empty() && options.peers.empty()))
    throw usage_error("--reference and --peer are pictures of one scene; expected one SCENE");
  if (options.references.size() > 2)
    throw usage_error("--reference: expected one picture, or two that know nothing of each other");
}

ExitCode bench_error_command(const ErrorCommandOptions& options) {
  check_options(options);
  ErrorBenchOptions bench = bench_options(options);
  const std::vector<AccuracyScene> scenes = scenes_of(options);
  const double budget = options.budget.value_or(options.quick ? 150 : 1500);
  const Time start = monotonic_now();
  Progress progress(scenes.size());
  std::vector<SceneErrors> all;
  for (size_t i = 0; i < scenes.size(); ++i) {
    // What earlier scenes left over is shared by those that come.
    if (budget > 0)
      bench.budget_seconds = std::max(1.0, budget - to_seconds(monotonic_now() - start)) /
                             static_cast<double>(scenes.size() - i);
    bench.on_progress = [&](const std::string& what, double share) {
      progress.show(i, scenes[i].name, what, share);
    };
    all.push_back(bench_error(scenes[i], bench));
    progress.clear();
    say("{}", error_table(all.back()));
    flush_output();  // before the next scene's progress, where both go to one file
    if (!options.svg_folder.empty()) {
      const fs::path folder = options.svg_folder;
      const std::string name = scenes[i].name + (options.peers.empty() ? "" : "-peers");
      write_output_file((folder / (name + ".svg")).string(), error_svg(all.back()));
      if (options.peers.empty())
        write_output_file((folder / (name + "-efficiency.svg")).string(),
                          efficiency_svg(all.back()));
    }
  }
  say("\n{}", error_summary(all));
  if (!options.json_file.empty()) write_output_file(options.json_file, error_json(all));
  if (!options.csv_file.empty()) write_output_file(options.csv_file, error_csv(all));
  return ExitCode::done;
}

void add_run_options(CLI::App& command, ErrorCommandOptions& options) {
  command
      .add_option("--methods", options.methods,
                  "Words with + between: integrator, sample pattern (owen, independent, "
                  "centered-grid ...), filter, adaptive, accelerator [owen independent]")
      ->type_name("METHOD");
  command
      .add_option_function<std::string>(
          "--samples", [&options](const std::string& text) { parse_samples(text, options); },
          "Per pixel, by powers of two [1-4096]")
      ->type_name("A-B");
  add_whole(command, "--seeds", 2, 10'000, "Pictures of each method and number of samples [32]",
            std::function([&options](int64_t n) { options.seeds = static_cast<int>(n); }));
  add_whole(command, "--threads", 1, 1024, "Threads that render [all]", options.threads);
  command.add_flag("--quick", options.quick, "--samples 1-64 --seeds 8 --budget 150");
  command.add_flag("--cpu-time", options.cpu_time,
                   "Seconds are processor time over threads: for a machine with other work");
  command
      .add_option_function<std::string>(
          "--size",
          [&options](const std::string& text) { options.size = parse_size("--size", text); },
          "Width and height in pixels [the scene's]")
      ->type_name("WxH");
  add_whole(command, "--budget", 0, 10'000'000,
            "Seconds for all: last rows get fewer seeds, or are left out; 0: no bound [1500]",
            std::function([&options](int64_t n) { options.budget = static_cast<int>(n); }));
}

}  // namespace

void add_error_bench(CLI::App& bench, Action& action) {
  auto options = std::make_shared<ErrorCommandOptions>();
  CLI::App* command = bench.add_subcommand("error", "Error against time");
  command->add_option(
      "SCENE", options->scenes,
      fmt::format("{}, or files [all of ours]", fmt::join(accuracy_scene_names(), ", ")));
  command->footer(
      "Each scene is rendered by each method under many seeds, in turns, and held against a "
      "closed\n"
      "form or two converged pictures, which are kept for the next time. Bands are of 95 %, by\n"
      "bootstrap over seeds; docs/accuracy.md tells what the columns mean.\n"
      "Examples:\n"
      "  tessera bench error --quick\n"
      "  tessera bench error cornell --methods owen independent owen+tent --json cornell.json\n"
      "  tessera bench error cornell --size 512x512 --peer cycles:10.4:64:cycles.exr --svg .");
  add_run_options(*command, *options);
  command
      ->add_option("--reference", options->references,
                   "The truth as a picture, or as two that are independent")
      ->type_name("FILE");
  command->add_option("--peer", options->peers, "A picture of another renderer, and its time")
      ->type_name("NAME:SECONDS:SAMPLES:FILE");
  command
      ->add_option("--cache", options->cache,
                   "Where converged pictures are kept [~/.cache/tessera/references]")
      ->type_name("DIR");
  command->add_option("--json", options->json_file, "Write the rows as JSON too")
      ->type_name("FILE");
  command->add_option("--csv", options->csv_file, "Write the rows as CSV too")->type_name("FILE");
  command
      ->add_option("--svg", options->svg_folder,
                   "Plot each scene into this folder; with peers as SCENE-peers.svg")
      ->type_name("DIR");
  command->callback(
      [options, &action] { action = [options] { return bench_error_command(*options); }; });
}

}  // namespace tessera
