#include <CLI/CLI.hpp>
#include <memory>

#include "base/file.h"
#include "bench/growth.h"
#include "bench/precision.h"
#include "cli/add_options.h"
#include "cli/bench/bench_commands.h"
#include "cli/say.h"
#include "front/option_values.h"

namespace tessera {
namespace {

struct Options {
  std::string json_file, svg_file;
  PrecisionBenchOptions precision;
  GrowthBenchOptions growth;
};

ExitCode precision(const Options& options) {
  if (!options.json_file.empty()) check_output_file(options.json_file, "--json");
  const std::vector<PrecisionBenchRow> rows = bench_precision(options.precision);
  say("{}", precision_table(rows));
  if (!options.json_file.empty()) write_output_file(options.json_file, precision_json(rows));
  return ExitCode::done;
}

ExitCode growth(const Options& options) {
  if (!options.json_file.empty()) check_output_file(options.json_file, "--json");
  if (!options.svg_file.empty()) check_output_file(options.svg_file, "--svg");
  const std::vector<GrowthBenchRow> rows = bench_growth(options.growth);
  say("{}", growth_table(rows));
  if (!options.json_file.empty()) write_output_file(options.json_file, growth_json(rows));
  if (!options.svg_file.empty()) write_output_file(options.svg_file, growth_svg(rows));
  return ExitCode::done;
}

}  // namespace

void add_precision_and_growth_benches(CLI::App& bench, Action& action) {
  auto options = std::make_shared<Options>();
  CLI::App* command = bench.add_subcommand(
      "precision", "Error against time of the usual tests of shapes, and of ours");
  add_whole(*command, "--rays", 100, 100'000'000, "Rays a row [100000]", options->precision.rays);
  command->add_option("--json", options->json_file, "Write the rows as JSON too")
      ->type_name("FILE");
  command->callback([options, &action] { action = [options] { return precision(*options); }; });

  command = bench.add_subcommand("growth", "Build and trace times over 10^3 to 10^7 triangles");
  add_whole(*command, "--most", 1'000, 100'000'000, "Triangles of the largest mesh [10000000]",
            options->growth.most);
  add_whole(*command, "--most-octree", 1'000, 100'000'000,
            "Triangles of the largest octree [1000000]", options->growth.most_of_octrees);
  add_whole(*command, "--threads", 1, 1024, "Threads that build [1]",
            options->growth.build_threads);
  add_whole(*command, "--rays", 100, 100'000'000, "Rays a row [200000]", options->growth.rays);
  command->add_option("--json", options->json_file, "Write the rows as JSON too")
      ->type_name("FILE");
  command->add_option("--svg", options->svg_file, "Plot both times")->type_name("FILE");
  command->callback([options, &action] { action = [options] { return growth(*options); }; });
}

}  // namespace tessera
