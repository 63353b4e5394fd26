#include <fmt/format.h>

#include <CLI/CLI.hpp>
#include <memory>
#include <nlohmann/json.hpp>

#include "base/file.h"
#include "cli/add_options.h"
#include "cli/bench/bench_commands.h"
#include "cli/bench/bench_farm.h"
#include "cli/say.h"
#include "front/option_values.h"

namespace tessera {
namespace {

struct BenchOptions {
  BenchFarmOptions farm;
  std::string json_file;
};

/// The rows as a table of fixed columns; a cell is empty where a row lacks its key.
void print_table(const nlohmann::json& rows) {
  say("{:<60} {:>10} {:>10} {:>7} {:>7}\n", "measure", "seconds", "reference", "ratio", "limit");
  const auto cell = [](const nlohmann::json& row, const char* key, int precision) {
    return row.contains(key) ? fmt::format("{:.{}f}", row[key].get<double>(), precision) : "";
  };
  for (const auto& row : rows) {
    say("{:<60} {:>10} {:>10} {:>7} {:>7}{}\n", row["measure"].get<std::string>(),
        cell(row, "seconds", 4), cell(row, "reference_seconds", 4), cell(row, "ratio", 3),
        cell(row, "limit", 2), row["beyond_limit"].get<bool>() ? "  BEYOND" : "");
  }
}

ExitCode bench(const BenchOptions& options) {
  if (!options.json_file.empty()) check_output_file(options.json_file, "--json");
  const nlohmann::json rows = bench_farm(options.farm);
  print_table(rows);
  if (!options.json_file.empty()) {
    write_output_file(options.json_file, nlohmann::json{{"rows", rows}}.dump(2) + "\n");
  }
  return ExitCode::done;
}

}  // namespace

void add_bench_kinds(CLI::App& app, Action& action) {
  auto options = std::make_shared<BenchOptions>();
  CLI::App* command = app.add_subcommand("bench", "Measure this program on this machine");
  command->require_subcommand(1);
  command->footer(
      "Leave the machine alone meanwhile, and use a release build.\n"
      "Examples:\n"
      "  tessera bench rays bunny.obj icosphere:6 --json rays.json\n"
      "  tessera bench octree --compare\n"
      "  tessera bench farm bunny.obj --workers 4\n"
      "  tessera bench error cornell\n"
      "  tessera bench skip\n"
      "  tessera bench studio --browser chromium\n"
      "'tessera help bench KIND' tells all about one of them.");
  add_tracing_benches(*command, action);
  add_precision_and_growth_benches(*command, action);
  add_error_bench(*command, action);
  add_skip_bench(*command, action);
  add_studio_bench(*command, action);
  CLI::App* farm = command->add_subcommand("farm", "What distribution costs");
  farm->footer(
      "Pairs are measured in turns; seconds are medians, ratios medians of the pairs' ratios.\n"
      "Limits are of the ratio, or of the seconds where there is none; BEYOND marks what is over.\n"
      "Leave the machine alone meanwhile, and use a release build.\n"
      "Example:\n"
      "  tessera bench farm bunny.obj --json farm.json");
  farm->add_option("SCENE", options->farm.scene, "What to render at 1080p [a grid of spheres]")
      ->type_name("FILE");
  add_whole(*farm, "--workers", 1, 1000, "Worker processes, and threads to hold them against [4]",
            options->farm.workers);
  add_whole(*farm, "--repeats", 1, 1000, "How often each pair is measured [5]",
            options->farm.repeats);
  add_whole(*farm, "--rings", 3, 5000, "Of the sphere whose mesh is sent to all workers [2000]",
            options->farm.rings);
  farm->add_option_function<std::string>(
          "--only",
          [options](const std::string& text) {
            options->farm.only = parse_choice("--only", text, bench_farm_kinds());
          },
          "Measure these rows alone: frame, sphere, worker, tile or scene [all]")
      ->type_name("KIND");
  farm->add_option("--json", options->json_file, "Write the rows as JSON too")->type_name("FILE");
  farm->callback([options, &action] { action = [options] { return bench(*options); }; });
}

}  // namespace tessera
