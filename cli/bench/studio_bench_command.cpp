#include <fmt/format.h>

#include <CLI/CLI.hpp>
#include <memory>
#include <nlohmann/json.hpp>

#include "base/error.h"
#include "base/file.h"
#include "bench/studio/studio_bench.h"
#include "cli/add_options.h"
#include "cli/bench/bench_commands.h"
#include "cli/interrupt.h"
#include "cli/say.h"

namespace tessera {
namespace {

struct Options {
  StudioBenchOptions bench;
  std::string json_file;
  bool quick = false;
};

std::string limit_of(const StudioBenchRow& row) {
  if (row.at_most) return fmt::format("<= {:g}", *row.at_most);
  if (row.at_least) return fmt::format(">= {:g}", *row.at_least);
  return "";
}

nlohmann::ordered_json json_of(const StudioBenchRow& row) {
  nlohmann::ordered_json json{{"measure", row.measure}, {"value", row.value}, {"unit", row.unit}};
  if (row.at_most) json["at_most"] = *row.at_most;
  if (row.at_least) json["at_least"] = *row.at_least;
  json["misses"] = row.misses();
  if (!row.note.empty()) json["note"] = row.note;
  return json;
}

ExitCode bench(Options options) {
  if (!options.json_file.empty()) check_output_file(options.json_file, "--json");
  if (options.quick) {
    options.bench.rounds = 2;
    options.bench.samples = 4;
    options.bench.idle_seconds = 2;
    options.bench.triangles = 20'000;
  }
  catch_interrupts();
  options.bench.check = [] {
    if (interrupted()) throw Error(ExitCode::interrupted, "interrupted");
  };
  options.bench.begin = [](std::string_view what) { say(stderr, "measuring: {}\n", what); };
  nlohmann::ordered_json rows = nlohmann::ordered_json::array();
  bench_studio(options.bench, [&](const StudioBenchRow& row) {
    say("{:<58} {:>9.3f} {:<8} {:<8} {}{}\n", row.measure, row.value, row.unit, limit_of(row),
        row.note, row.misses() ? "  BEYOND" : "");
    flush_output();
    rows.push_back(json_of(row));
  });
  if (!options.json_file.empty()) {
    write_output_file(options.json_file, nlohmann::ordered_json{{"rows", rows}}.dump(2) + "\n");
  }
  return ExitCode::done;
}

}  // namespace

void add_studio_bench(CLI::App& bench_command, Action& action) {
  auto options = std::make_shared<Options>();
  options->bench.scenes = "scenes/samples";
  CLI::App* command = bench_command.add_subcommand(
      "studio", "From keys, orbits and clicks of the studio to pixels");
  command
      ->add_option("SAMPLES", options->bench.scenes,
                   "The folder of Tessera's samples [scenes/samples]")
      ->type_name("FOLDER");
  command->footer(
      "A studio is started, and worked with as its page does; BEYOND marks what is over its "
      "limit.\n"
      "Leave the machine alone meanwhile, and use a release build.\n"
      "Example:\n"
      "  tessera bench studio --browser chromium --json studio.json");
  command
      ->add_option("--browser", options->bench.browser,
                   "Measure in that Chromium too, headless, with keys and pointer [no]")
      ->type_name("PROGRAM");
  add_whole(*command, "--rounds", 1, 1000, "Keys in each scene; other rows have more [12]",
            options->bench.rounds);
  command->add_flag("--quick", options->quick, "Small sizes, whose figures mean nothing");
  command->add_option("--json", options->json_file, "Write the rows as JSON too")
      ->type_name("FILE");
  command->callback([options, &action] { action = [options] { return bench(*options); }; });
}

}  // namespace tessera
