#include <fmt/format.h>

#include <CLI/CLI.hpp>
#include <cstdio>
#include <memory>
#include <set>

#include "base/log.h"
#include "base/plural.h"
#include "cli/add_options.h"
#include "cli/command_line.h"
#include "cli/interrupt.h"
#include "cli/say.h"
#include "client/farm_client.h"
#include "front/farm_connection.h"
#include "front/gather_job.h"
#include "front/job_orders.h"
#include "front/load_frame.h"
#include "front/option_values.h"
#include "front/output_settings.h"
#include "front/picture_warnings.h"
#include "front/render_options.h"
#include "front/standard_input.h"
#include "job/check_job.h"
#include "job/job_messages.h"
#include "proto/transport/zmq_transport.h"
#include "proto/wire/frame.h"
#include "proto/wire/printable.h"
#include "scenes/formats/read_scene.h"

namespace tessera {
namespace {

constexpr char kSubmitFooter[] =
    "Prints the job's number, and returns once the coordinator has the whole scene: it sends only\n"
    "what the coordinator lacks. The job goes on without this command.\n"
    "Examples:\n"
    "  tessera submit room.x3d --size 1920x1080 --spp 64\n"
    "  tessera submit walk.x3d --frames 1-240 --priority 5 --connect tcp://127.0.0.1:7117\n"
    "  job=$(tessera submit room.x3d --quiet) && tessera fetch $job --wait -o room.png";

struct SubmitOptions {
  RenderOptions render;
  FarmConnection connection{.endpoint = kDefaultEndpoint};
  std::string name;
  int priority = 0;
  int weight = 1;
};

/// Reads all that is to be rendered.
SubmittedJob gather(const SubmitOptions& options) {
  check_scene_format(options.render.scene, options.render.reading);
  const JobOrder order{options.name, options.priority, options.weight};
  const auto load = [&](int frame) { return load_frame(options.render, frame); };
  const auto warn = [&](const std::string& warning) {
    if (!options.render.quiet) say_warning(warning);
  };
  return gather_job(options.render, order, load, warn);
}

ExitCode submit(const SubmitOptions& options) {
  catch_interrupts();
  configure_logging(options.render.quiet ? "off" : "warn", "submit");
  // The connection is made while the scene is read.
  const auto transport = connect(options.connection);
  const SubmittedJob job = gather(options);
  FarmClient client(*transport, options.connection.endpoint, interrupted());
  const v1::JobStatus status = submit_job(client, job);
  say("{}\n", status.job());
  flush_output();
  if (options.render.quiet) return ExitCode::done;
  const v1::PixelRect& crop = status.crop();
  say(stderr, "job {}: {}, {} of {}x{} pixels; sent {} of {}, {} bytes\n", status.job(),
      printable(status.name()), counted(status.frames_total(), "frame"), crop.x1() - crop.x0(),
      crop.y1() - crop.y0(), client.blobs_sent(), counted(job.blobs.size(), "blob"),
      client.bytes_sent());
  return ExitCode::done;
}

}  // namespace

void add_submit_command(CLI::App& app, Action& action) {
  auto options = std::make_shared<SubmitOptions>();
  CLI::App* command =
      app.add_subcommand("submit", "Hand a scene to a farm, which renders it on its own");
  command->footer(kSubmitFooter);
  command
      ->add_option("SCENE", options->render.scene,
                   "The scene file, or '-' for standard input; 'tessera info' tells what it holds")
      ->required()
      ->type_name("FILE");
  OptionList list;
  add_scene_options(list, options->render);
  constexpr char kGroup[] = "Who does the work";
  add_connection_options(list, options->connection, kGroup);
  add_options(*command, list);
  const auto number = [&](const char* name, int& value, int least, int most,
                          const std::string& text) {
    command
        ->add_option_function<std::string>(
            name,
            [name, &value, least, most](const std::string& typed) {
              value = static_cast<int>(parse_whole(name, typed, least, most));
            },
            text)
        ->type_name("N")
        ->group(kGroup);
  };
  number("--priority", options->priority, -1000, 1000,
         "Jobs of larger numbers go first, from -1000 to 1000 [0]");
  number("--weight", options->weight, 1, 1000,
         "Its share of the workers among jobs of the same priority [1]");
  command->add_option("--name", options->name, "What to call the job [SCENE's name]")
      ->type_name("NAME")
      ->group(kGroup);
  command->add_flag("--quiet", options->render.quiet, "Print nothing but the number and errors")
      ->group("Report");
  command->callback([options, &action] {
    action = [options] {
      take_standard_input(options->render.scene, options->render.reading);
      return submit(*options);
    };
  });
}

}  // namespace tessera
