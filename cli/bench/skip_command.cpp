#include <fmt/format.h>

#include <CLI/CLI.hpp>
#include <algorithm>
#include <memory>

#include "base/error.h"
#include "base/file.h"
#include "bench/skip.h"
#include "cli/add_options.h"
#include "cli/bench/bench_commands.h"
#include "cli/say.h"
#include "front/option_values.h"

namespace tessera {
namespace {

struct SkipCommandOptions {
  std::vector<std::string> names;
  std::string json_file;
  std::optional<int> repeats;
  bool quick = false;
};

std::vector<std::string> known_names() {
  std::vector<std::string> names;
  for (const UnneededKind& kind : unneeded_kinds()) names.push_back(kind.name);
  return names;
}

void check_names(const std::vector<std::string>& names) {
  const std::vector<std::string> known = known_names();
  for (const std::string& name : names) {
    if (std::find(known.begin(), known.end(), name) == known.end())
      throw usage_error(fmt::format("KIND: '{}'; expected {}{}", name, fmt::join(known, ", "),
                                    suggestion(name, known)));
  }
}

ExitCode bench_skip_command(const SkipCommandOptions& options) {
  check_names(options.names);
  if (!options.json_file.empty()) check_output_file(options.json_file, "--json");
  const SkipBenchOptions bench{.repeats = options.repeats.value_or(options.quick ? 3 : 9),
                               .quick = options.quick};
  std::vector<SkipRow> rows;
  for (const UnneededKind& kind : unneeded_kinds()) {
    const auto& names = options.names;
    if (!names.empty() && std::find(names.begin(), names.end(), kind.name) == names.end()) continue;
    rows.push_back(bench_skip(kind, bench));
  }
  say("{}", skip_table(rows));
  if (!options.json_file.empty()) write_output_file(options.json_file, skip_json(rows));
  const bool is_same =
      std::all_of(rows.begin(), rows.end(), [](const SkipRow& row) { return row.same_bits; });
  return is_same ? ExitCode::done : ExitCode::render_failed;
}

}  // namespace

void add_skip_bench(CLI::App& bench, Action& action) {
  auto options = std::make_shared<SkipCommandOptions>();
  CLI::App* command =
      bench.add_subcommand("skip", "What a thousand things cost that a picture does not need");
  command->add_option("KIND", options->names,
                      fmt::format("{} [all]", fmt::join(known_names(), ", ")));
  command->footer(
      "A scene is traced in turns with the same scene and a thousand things of one kind that its\n"
      "picture does not depend on: whether the picture keeps its bits, and the ratio of the\n"
      "processor times of tracing, which is to be at most 1.01. docs/skipping.md tells what\n"
      "is left out. The exit code is 3 where a picture differs.\n"
      "Example:\n"
      "  tessera bench skip black-lights textures");
  add_whole(*command, "--repeats", 1, 1000, "Turns; figures are their medians [9]",
            std::function([options](int64_t n) { options->repeats = static_cast<int>(n); }));
  command->add_flag("--quick", options->quick, "A sixteenth of the pixels, --repeats 3");
  command->add_option("--json", options->json_file, "Write the rows as JSON too")
      ->type_name("FILE");
  command->callback(
      [options, &action] { action = [options] { return bench_skip_command(*options); }; });
}

}  // namespace tessera
