#include <fmt/format.h>

#include <CLI/CLI.hpp>
#include <algorithm>
#include <chrono>
#include <memory>
#include <nlohmann/json.hpp>
#include <utility>

#include "base/all_failures.h"
#include "base/cancellation.h"
#include "base/file.h"
#include "base/log.h"
#include "base/plural.h"
#include "base/process.h"
#include "cli/add_options.h"
#include "cli/command_line.h"
#include "cli/interrupt.h"
#include "cli/progress_display.h"
#include "cli/say.h"
#include "coordinator/store/sqlite_tile_store.h"
#include "coordinator/web/chrome_trace.h"
#include "front/animation_files.h"
#include "front/load_frame.h"
#include "front/output_settings.h"
#include "front/picture.h"
#include "front/picture_warnings.h"
#include "front/render_checks.h"
#include "front/render_frame.h"
#include "front/render_options.h"
#include "front/standard_input.h"
#include "front/tracing_farm.h"
#include "image/image_file.h"

namespace tessera {
namespace {

constexpr char kFooter[] =
    "Examples:\n"
    "  tessera render bunny.obj                                bunny.png, on every core\n"
    "  tessera render room.x3d -o room.png -o room.exr --size 1920x1080 --spp 64\n"
    "  tessera render room.x3d --crop 400,300,528,428          a detail, the same pixels\n"
    "  tessera render walk.crt --frames 0-47 -o walk.gif       an animation; .apng loses nothing\n"
    "  tessera render room.x3d --workers 0 --threads 4 --stats room.json\n"
    "  tessera render room.x3d --spp 4096 --resume             may be killed and started again\n"
    "  tessera render room.x3d --connect tcp://127.0.0.1:7117  on the farm of 'tessera serve'\n"
    "The picture is the same to the last bit for any --workers, --threads, --tile and --accel.\n"
    "Ctrl-C stops cleanly (exit code 4); a second one at once.";

using Clock = std::chrono::steady_clock;

/// A frame of fewer samples may be done before its remaining time could be told.
constexpr uint64_t kFewSamples = uint64_t{1} << 24;
constexpr double kSecondsToPrepare = 1;
/// From one pass of --progressive to the next: all before the last together cost a third of it.
constexpr uint32_t kPassGrowth = 4;

double seconds_since(Clock::time_point start) {
  return std::chrono::duration<double>(Clock::now() - start).count();
}

/// One `tessera render` from its options to its pictures.
class RenderRun {
 public:
  explicit RenderRun(const RenderOptions& options) : options_(options) {}

  ExitCode run() {
    check_render_options(options_);
    check_outputs(options_);
    if (options_.resume) store_ = std::make_shared<SqliteTileStore>(kept_tiles_path(options_));
    const auto first = options_.frames ? std::optional(options_.frames->front()) : std::nullopt;
    // Workers get ready while the scene is read, and so does what writes PNG, which waits for
    // little.
    for (const auto& path : picture_paths(options_)) {
      if (is_quickly_prepared(path)) prepare_to_write(path);
    }
    farm_ = start_farm();
    read(first.value_or(0));
    if (FrameRender(options_, scene_, first).sample_count() < kFewSamples) {
      prepare_to_write_pictures();
    }
    const ExitCode code = render_frames();
    // All pictures are written.
    if (store_ && code == ExitCode::done) end_store();
    return code;
  }

 private:
  ExitCode render_frames() {
    if (!options_.frames) return render_frame(std::nullopt, true);
    // What is done of an animation is written also where a later frame fails.
    AllFailures failures;
    failures.attempt([this] { render_all_frames(); });
    failures.attempt([this] { write_animations(); });
    failures.throw_if_any();
    return ExitCode::done;
  }

  void render_all_frames() {
    for (const int frame : *options_.frames) {
      if (frame > options_.frames->front()) {
        began_ = Clock::now();
        if (scene_.loaded.depends_on_frame) read(frame);
      }
      render_frame(frame, frame == options_.frames->back());
      ++frames_written_;
    }
  }

  void write_animations() const {
    const double rate = options_.frames_per_second.value_or(
        scene_frame_rate(options_.scene, scene_.loaded.scene.settings()));
    animations_.write(rate, [&](const AnimationFiles::Whole& file) {
      write_picture(file.path, file.bytes);
      if (!file.note.empty() && !options_.quiet) say_warning(file.note);
      if (options_.quiet || writes_standard_output(options_)) return;
      say("{}  {}, {:.4g} a second\n", file.path.string(), counted(file.frames, "frame"),
          file.frames_per_second);
    });
    flush_output();
  }

  void end_store() {
    const uint64_t others = store_->end();
    if (others > 0 && !options_.quiet) {
      say_warning(fmt::format("{} of other scenes or settings stay in '{}'",
                              counted(others, "tile"), kept_tiles_path(options_).string()));
    }
  }

  bool by_farm() const { return !options_.connection.endpoint.empty(); }

  std::unique_ptr<TracingFarm> start_farm() const {
    if (by_farm()) return connect_to_farm(options_.connection);
    const int cores = core_count();
    const int workers = options_.workers.value_or(cores);
    if (workers == 0) return start_in_process(options_.threads.value_or(cores));
    std::optional<HeldInterrupts> held(std::in_place);  // until the handler knows of the sockets
    return start_local_workers({.workers = workers,
                                .threads = options_.threads.value_or(1),
                                .quiet = options_.quiet,
                                .verify = options_.verify.value_or(0),
                                .tev = options_.tev,
                                .made_sockets = [&held](const auto& folder, const auto& files) {
                                  remove_when_interrupted(folder, files);
                                  held.reset();
                                }});
  }

  void read(int frame) {
    scene_ = measured([&] { return load_frame(options_, frame); });
    parse_seconds_ = scene_.load_seconds;
    // A wrong option is told before all that may be said of the scene.
    [[maybe_unused]] const FrameRender checked(
        options_, scene_, options_.frames ? std::optional(frame) : std::nullopt);
    if (options_.quiet) return;
    for (const auto& warnings :
         {scene_warnings(options_, scene_.loaded), file_warnings(options_, scene_.loaded)}) {
      for (const std::string& warning : warnings) warnings_.say(warning);
    }
  }

  ExitCode render_frame(std::optional<int> number, bool last) {
    const FrameRender frame(options_, scene_, number);
    pass_samples_ = 0;
    if (options_.progressive) write_passes(frame, number);
    farm_->keep_tiles(store_);
    JobResult result = trace(frame, number, last);
    const JobReport& report = result.report;
    if (report.end == JobReport::End::interrupted) throw interruption(report);
    const std::optional<Error> failure = frame.failure(report);
    if (failure && failure->code() == ExitCode::bad_scene) throw *failure;
    if (failure && report.tiles_done == 0) {
      throw Error(failure->code(),
                  fmt::format("{}; {}", failure->what(), what_was_written(report)));
    }
    try {
      std::optional<Cancellation> may_end(&interrupted());
      RenderedPicture picture = pictured(frame, result);
      note_exposure(picture);
      // Of several frames each is written to all of its files or to none.
      if (number) may_end.reset();
      write(frame, picture, number);
    } catch (const WorkCancelled&) {
      throw interruption(report);
    }
    if (failure) throw *failure;
    return ExitCode::done;
  }

  /// With the exposure of an animation's first frame, lest it flicker.
  RenderedPicture pictured(const FrameRender& frame, JobResult& result) const {
    RenderedPicture picture = frame.picture(result);
    if (exposure_) picture.auto_exposure = exposure_;
    return picture;
  }

  /// Tells what was chosen, for files that show it.
  void note_exposure(const RenderedPicture& picture) {
    const auto paths = picture_paths(options_);
    const bool is_shown = !std::all_of(paths.begin(), paths.end(), holds_floats);
    if (!exposure_ && picture.auto_exposure && is_shown && !options_.quiet)
      say(stderr, "exposure chosen: --exposure {:g}\n", *picture.auto_exposure);
    exposure_ = picture.auto_exposure;
  }

  /// Pictures of fewer samples, each the first ones of the next: jobs of their own, whose tiles are
  /// not kept. What goes wrong is for the last one to tell.
  void write_passes(const FrameRender& frame, std::optional<int> number) {
    const uint32_t all = frame.settings().samples_per_pixel();
    farm_->keep_tiles(nullptr);
    for (uint32_t samples = 1; samples < all; samples *= kPassGrowth) {
      const FrameRender pass = frame.with_samples(samples);
      JobResult result = trace(pass, number, false);
      if (result.report.end == JobReport::End::interrupted) throw interruption(result.report);
      if (result.report.end != JobReport::End::done) return;
      if (!write_pictures(pictured(pass, result), number, true)) pass_samples_ = samples;
    }
  }

  Error interruption(const JobReport& report) const {
    return Error(ExitCode::interrupted, fmt::format("interrupted; {}", what_was_written(report)));
  }

  std::string what_was_written(const JobReport& report) const {
    const std::string kept =
        store_
            ? fmt::format("{} of {} tiles are kept in '{}': --resume goes on from there",
                          report.tiles_done, report.tiles_total, kept_tiles_path(options_).string())
            : "no tile was kept: --resume keeps those that are finished";
    if (!options_.frames && pass_samples_ > 0) {
      return fmt::format("the picture has {} a pixel; {}", counted(pass_samples_, "sample"), kept);
    }
    if (!options_.frames) return "no picture was written; " + kept;
    const size_t frames = options_.frames->size();
    return fmt::format("{} of {} {} written; of the next, {}", frames_written_,
                       counted(frames, "frame"), frames == 1 ? "was" : "were", kept);
  }

  JobResult trace(const FrameRender& frame, std::optional<int> number, bool last) {
    const std::string label = number ? fmt::format("frame {}  ", *number) : "";
    ProgressDisplay display(progress_style(stderr, options_.quiet), stderr, label);
    const auto start = Clock::now();
    JobResult result = frame.trace(
        *farm_, scene_.loaded,
        [&](const JobProgress& progress) {
          display.show(progress);
          const double left = progress.remaining_seconds;
          if (left >= 0 && left < kSecondsToPrepare) prepare_to_write_pictures();
        },
        interrupted());
    traced_seconds_ = seconds_since(start);
    peak_worker_bytes_ = std::max(peak_worker_bytes_, farm_->peak_worker_bytes());
    // While the picture is written workers end, and give back the memory of large pictures, which
    // takes time.
    if (last) {
      scene_.loaded.blobs = {};
      farm_->dismiss();
    }
    return result;
  }

  /// What encodes the pictures takes 0.2 s to load, and need not wait beside the workers for hours.
  void prepare_to_write_pictures() const {
    for (const auto& path : picture_paths(options_)) prepare_to_write(path);
  }

  /// What failed: a disk that is full for one may have room for another.
  std::optional<Error> write_pictures(const RenderedPicture& picture, std::optional<int> frame,
                                      bool is_pass = false) {
    const OutputSettings output = shown_settings(options_.scene, picture, options_.output);
    AllFailures failures;
    for (const auto& path : picture_paths(options_)) {
      failures.attempt([&] {
        if (!frame || !holds_frames(path)) {
          write_image(frame_path(path, frame), picture.film, output, picture.metadata);
        } else if (!is_pass) {
          animations_.add(path, picture.film, output, picture.metadata);
        }
      });
    }
    return failures.error();
  }

  void write(const FrameRender& rendered, const RenderedPicture& picture,
             std::optional<int> frame) {
    const auto start = Clock::now();
    // Nothing finished is thrown away.
    const std::optional<Error> failure = write_pictures(picture, frame);
    FrameStatistics statistics = rendered.statistics(picture,
                                                     {.parse = std::exchange(parse_seconds_, 0),
                                                      .write = seconds_since(start),
                                                      .total = seconds_since(began_)},
                                                     peak_worker_bytes_);
    if (options_.stats) {
      statistics.pixels_sha256 = picture.film.pixels_sha256();
      const std::string text = statistics_json(statistics).dump(2) + "\n";
      if (stats_to_standard_output(options_)) {
        say("{}", text);
        flush_output();
      } else {
        write_output_file(frame_path(*options_.stats, frame), text);
      }
    }
    if (options_.trace && picture.report.trace)
      write_trace(statistics, frame_path(*options_.trace, frame));
    if (!options_.quiet) say_warnings(rendered, picture, frame);
    if (failure) throw *failure;
    if (!options_.quiet && !writes_standard_output(options_)) {
      print_end(picture, statistics, frame);
    }
  }

  /// What the picture shows to be odd in the scene.
  void say_warnings(const FrameRender& rendered, const RenderedPicture& picture,
                    std::optional<int> frame) {
    const PictureOrigin origin{.scene = options_.scene,
                               .is_of_strokes = has_strokes_alone(scene_.loaded.scene),
                               .is_whole = shows_whole_frame(picture.film, rendered.settings())};
    for (const std::string& warning : report_warnings(picture.report, origin))
      warnings_.say(warning, frame);
    const OutputSettings output = shown_settings(options_.scene, picture, options_.output);
    for (const std::string& warning :
         brightness_warnings(rendered.settings(), picture_paths(options_), picture.film, output))
      warnings_.say(warning, frame);
  }

  /// The timeline of the workers, and of this process around it.
  void write_trace(const FrameStatistics& statistics, const std::filesystem::path& path) const {
    const PhaseSeconds& seconds = statistics.seconds;
    const double ended = seconds.total - seconds.write;
    // It begins with the frame's work, the trace when the coordinator took the frame up.
    const double traced = traced_seconds_;
    const std::vector<TracePhase> phases = {
        {"parse", -(ended - traced), -(ended - traced) + seconds.parse},
        {"trace", 0, traced},
        {"write", traced, traced + seconds.write}};
    write_output_file(path, chrome_trace(*statistics.report.trace,
                                         fmt::format("tessera render {}", options_.scene), phases));
  }

  void print_end(const RenderedPicture& picture, const FrameStatistics& statistics,
                 std::optional<int> frame) const {
    for (const auto& path : picture_paths(options_)) {
      if (frame && holds_frames(path)) continue;
      const JobReport& report = picture.report;
      const std::string retries =
          report.retries == 1 ? "1 retry" : fmt::format("{} retries", report.retries);
      const std::string kept =
          report.tiles_restored > 0
              ? fmt::format("{} kept from an earlier run, ", report.tiles_restored)
              : "";
      say("{}  {}x{}, {} by {}, {}, {}{}\n", frame_path(path, frame).string(), picture.film.width(),
          picture.film.height(), counted(report.tiles_done, "tile"),
          counted(report.workers_seen, "worker"), retries, kept,
          duration_text(statistics.seconds.total));
    }
    flush_output();
  }

  const RenderOptions& options_;
  Clock::time_point began_ = Clock::now();  ///< the work on this frame
  std::unique_ptr<TracingFarm> farm_;
  std::shared_ptr<SqliteTileStore> store_;  ///< null: tiles are not kept
  FrameScene scene_;
  AnimationFiles animations_;
  std::optional<double> exposure_;  ///< as the first picture has chosen it
  double parse_seconds_ = 0;        ///< of what was read for this frame
  double traced_seconds_ = 0;       ///< the last frame, from its start to its film
  uint64_t peak_worker_bytes_ = 0;
  int frames_written_ = 0;
  uint32_t pass_samples_ = 0;  ///< of the picture that there is of this frame; 0: none
  WarningsOnce warnings_;
};

}  // namespace

void add_render_command(CLI::App& app, Action& action) {
  auto options = std::make_shared<RenderOptions>();
  CLI::App* command = app.add_subcommand("render", "Render a scene file to a picture");
  command->footer(kFooter);
  command
      ->add_option("SCENE", options->scene,
                   "The scene file, or '-' for standard input; 'tessera info' tells what it holds")
      ->required()
      ->type_name("FILE");
  OptionList list;
  add_render_options(list, *options);
  add_options(*command, list);
  command->callback([options, &action] {
    action = [options] {
      take_standard_input(options->scene, options->reading);
      catch_interrupts();
      configure_logging(options->quiet ? "off" : "warn", "render");
      return RenderRun(*options).run();
    };
  });
}

}  // namespace tessera
