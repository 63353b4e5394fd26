#include <fmt/format.h>

#include <CLI/CLI.hpp>
#include <algorithm>
#include <cstdio>
#include <filesystem>
#include <memory>
#include <optional>
#include <vector>

#include "base/all_failures.h"
#include "base/log.h"
#include "base/plural.h"
#include "cli/add_options.h"
#include "cli/command_line.h"
#include "cli/interrupt.h"
#include "cli/progress_display.h"
#include "cli/say.h"
#include "cli/waiting.h"
#include "client/farm_client.h"
#include "client/job_client.h"
#include "front/animation_files.h"
#include "front/farm_connection.h"
#include "front/job_name.h"
#include "front/job_orders.h"
#include "front/output_settings.h"
#include "front/picture.h"
#include "front/picture_warnings.h"
#include "front/render_options.h"
#include "image/image_file.h"
#include "job/job_messages.h"
#include "proto/wire/printable.h"

namespace tessera {
namespace {

constexpr char kFetchFooter[] =
    "Fetches the light of each frame and makes pictures of it as 'tessera render' does; those of "
    "an\n"
    "animation go to NAME.NNNN.png, or all to one .gif or .apng. The job stays, so that this can\n"
    "be done again.\n"
    "Examples:\n"
    "  tessera fetch 7                                    NAME.png, if it is done\n"
    "  tessera fetch 7 --wait -o room.png -o room.exr\n"
    "  tessera fetch 7 -o brighter.png --exposure 1       the same light, another picture\n"
    "Exit codes are those of 'tessera render'; 3 too where the job has not ended.";

struct FetchOptions {
  FarmConnection connection{.endpoint = kDefaultEndpoint};
  std::string job;
  std::vector<std::filesystem::path> outputs;
  OutputOptions output;
  std::optional<double> frames_per_second;
  bool wait = false;
  bool denoise = false;
  bool forget = false;
  bool quiet = false;
};

/// One `tessera fetch`.
class Fetch {
 public:
  explicit Fetch(const FetchOptions& options)
      : options_(options),
        transport_(connect(options.connection)),
        client_(*transport_, options.connection.endpoint, interrupted()) {}

  ExitCode run() {
    query_.set_job(options_.forget ? find_job_to_change(client_, options_.job)
                                   : find_job(client_, options_.job, say_error));
    v1::JobStatus status = client_.ask(query_);
    paths_ = options_.outputs;
    // The name of a job is text from elsewhere: no folder of it counts.
    const auto name = std::filesystem::path(printable(status.name())).filename().string();
    if (paths_.empty()) paths_ = {name + ".png"};
    AllFailures unwritable;
    for (const auto& path : paths_) {
      unwritable.attempt([&] {
        check_writable(frame_path(path, number_in_animation(status)));
        check_alpha(path, AovSet(status.frame().settings().aovs()));
      });
    }
    unwritable.throw_if_any();
    ProgressDisplay display(progress_style(stderr, options_.quiet || !options_.wait), stderr, "");
    uint32_t missing = 0;
    for (uint32_t frame = 0; frame < status.frames_total(); ++frame) {
      query_.set_frame(frame);
      FetchedFrame fetched = fetch();
      while (options_.wait && !fetched.has_ended()) {
        display.show(progress_of(fetched.status));
        client_.wait(kAskEvery);
        fetched = fetch();
      }
      status = fetched.status;
      if (fetched.failure && !failure_) failure_ = fetched.failure;
      if (fetched.picture) write(fetched);
      if (!fetched.has_ended()) ++missing;
    }
    write_animations();
    if (failure_) throw *failure_;
    if (missing > 0) {
      throw render_error(fmt::format("job {}: {} of {} not done yet ({} of {} tiles); --wait waits",
                                     query_.job(), missing, counted(status.frames_total(), "frame"),
                                     status.tiles_done(), status.tiles_total()));
    }
    if (options_.forget) forget_job(client_, query_.job());
    return ExitCode::done;
  }

 private:
  static std::optional<int> number_in_animation(const v1::JobStatus& status) {
    return status.animation() ? std::optional(status.frame().number()) : std::nullopt;
  }
  /// Whether standard output is for texts.
  bool prints() const {
    return !options_.quiet && std::none_of(paths_.begin(), paths_.end(), is_standard_output);
  }
  FetchedFrame fetch() {
    if (!options_.wait) return fetch_frame(client_, query_, options_.denoise);
    return ask_patiently([&] { return fetch_frame(client_, query_, options_.denoise); });
  }

  /// The first failure counts; whatever else there is of pictures is written.
  void write(FetchedFrame& fetched) {
    const v1::JobStatus& status = fetched.status;
    const v1::JobFrame& frame = status.frame();
    const JobReport& report = fetched.picture->report;
    const Film& film = fetched.picture->film;
    RenderedPicture& picture = *fetched.picture;
    if (exposure_) picture.auto_exposure = exposure_;
    const OutputSettings settings =
        shown_settings(printable(status.name()), picture, options_.output);
    if (options_.output.auto_exposure && !exposure_) {
      exposure_ = settings.exposure;
      if (!options_.quiet) say(stderr, "exposure chosen: --exposure {:g}\n", *exposure_);
    }
    for (const auto& path : paths_) {
      const auto place = frame_path(path, number_in_animation(status));
      const bool is_part = status.animation() && holds_frames(path);
      try {
        if (is_part) {
          animations_.add(path, film, settings, fetched.picture->metadata);
        } else {
          write_image(place, film, settings, fetched.picture->metadata);
        }
      } catch (const Error& error) {
        if (!failure_) failure_ = error;
        continue;
      }
      if (!prints() || is_part) continue;
      const std::string kept =
          report.tiles_restored > 0
              ? fmt::format(", {} kept from an earlier run", report.tiles_restored)
              : "";
      say("{}  {}x{}, {} of {} tiles{}\n", place.string(), film.width(), film.height(),
          report.tiles_done, report.tiles_total, kept);
    }
    flush_output();
    if (!options_.quiet) {
      const auto number = number_in_animation(status);
      const bool is_whole = shows_whole_frame(film, frame.settings());
      for (const std::string& warning : report_warnings(report, {.is_whole = is_whole}))
        warnings_.say(warning, number);
      for (const std::string& warning :
           brightness_warnings(frame.settings(), paths_, film, settings))
        warnings_.say(warning, number);
    }
    // Frame k is at the instant k / rate.
    if (frame.number() > 0 && frame.settings().time() > 0)
      frame_rate_ = frame.number() / frame.settings().time();
  }

  void write_animations() {
    const double rate = options_.frames_per_second.value_or(frame_rate_);
    try {
      animations_.write(rate, [&](const AnimationFiles::Whole& file) {
        write_picture(file.path, file.bytes);
        if (!file.note.empty() && !options_.quiet) say_warning(file.note);
        if (!prints()) return;
        say("{}  {}, {:.4g} a second\n", file.path.string(), counted(file.frames, "frame"),
            file.frames_per_second);
      });
    } catch (const Error& error) {
      if (!failure_) failure_ = error;
    }
    flush_output();
  }

  const FetchOptions& options_;
  std::unique_ptr<ClientTransport> transport_;
  FarmClient client_;
  v1::JobQuery query_;
  std::vector<std::filesystem::path> paths_;
  AnimationFiles animations_;
  std::optional<double> exposure_;               ///< as the first picture has chosen it
  double frame_rate_ = kDefaultFramesPerSecond;  ///< as the frames' instants tell it
  std::optional<Error> failure_;
  WarningsOnce warnings_;
};

}  // namespace

void add_fetch_command(CLI::App& app, Action& action) {
  auto options = std::make_shared<FetchOptions>();
  CLI::App* command = app.add_subcommand("fetch", "Get the pictures of a farm's job");
  command->footer(kFetchFooter);
  command
      ->add_option("JOB", options->job,
                   "The job, by its number or name; name:NAME where the name is a number")
      ->type_name("JOB")
      ->required();
  OptionList connecting, output;
  add_connection_options(connecting, options->connection);
  add_options(*command, connecting);
  command->add_flag("--wait", options->wait, "Wait for frames that are not done yet");
  command->add_flag("--denoise", options->denoise,
                    "As render does; of jobs with --aovs albedo,normal,depth,variance");
  command->add_flag("--forget", options->forget, "Then delete the job, its tiles and its scene");
  command->add_flag("--quiet", options->quiet, "Print nothing but errors");
  command
      ->add_option_function<std::vector<std::string>>(
          "-o,--output",
          [options](const std::vector<std::string>& paths) {
            options->outputs.assign(paths.begin(), paths.end());
          },
          "Where to write the picture; the ending names the format; '-' and '-.exr' are standard "
          "output. May be given more than once "
          "[the job's name with .png, in the current folder]")
      ->type_name("FILE")
      ->option_text("FILE")
      ->allow_extra_args(false)
      ->group("Picture");
  OptionGroup(output, "Picture")
      .add("--fps", "N",
           fmt::format("Frames a second that a .gif or .apng shows [as the job's are, or {}]",
                       kDefaultFramesPerSecond),
           [options](const std::string& text) {
             options->frames_per_second = parse_frame_rate("--fps", text);
           });
  add_output_options(output, options->output);
  add_options(*command, output);
  command->callback([options, &action] {
    action = [options] {
      catch_interrupts();
      configure_logging("warn", "fetch");
      return Fetch(*options).run();
    };
  });
}

}  // namespace tessera
