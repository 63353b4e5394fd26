#include <fmt/format.h>

#include <CLI/CLI.hpp>
#include <algorithm>
#include <memory>

#include "base/error.h"
#include "base/file.h"
#include "bench/skip.h"
#include "cli/add_options.h"
#include "cli/command_line.h"
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
  for (const SkipCase& skip : skip_cases()) names.push_back(skip.name);
  return names;
}

void check_names(const std::vector<std::string>& names) {
  const std::vector<std::string> known = known_names();
  for (const std::string& name : names) {
    if (std::find(known.begin(), known.end(), name) == known.end())
      throw usage_error(fmt::format("SKIP: '{}'; expected {}{}", name, fmt::join(known, ", "),
                                    suggestion(name, known)));
  }
}

ExitCode bench_skip_command(const SkipCommandOptions& options) {
  check_names(options.names);
  if (!options.json_file.empty()) check_output_file(options.json_file, "--json");
  const SkipBenchOptions bench{.repeats = options.repeats.value_or(options.quick ? 3 : 9),
                               .quick = options.quick};
  std::vector<SkipRow> rows;
  for (const SkipCase& skip : skip_cases()) {
    const auto& names = options.names;
    if (!names.empty() && std::find(names.begin(), names.end(), skip.name) == names.end()) continue;
    rows.push_back(bench_skip(skip, bench));
  }
  say("{}", skip_table(rows));
  if (!options.json_file.empty()) write_output_file(options.json_file, skip_json(rows));
  const bool all_within =
      std::all_of(rows.begin(), rows.end(), [](const SkipRow& row) { return row.within; });
  return all_within ? ExitCode::done : ExitCode::render_failed;
}

}  // namespace

void add_skip_bench(CLI::App& bench, Action& action) {
  auto options = std::make_shared<SkipCommandOptions>();
  CLI::App* command = bench.add_subcommand("skip", "What leaving out needless work saves");
  command->add_option("SKIP", options->names,
                      fmt::format("{} [all]", fmt::join(known_names(), ", ")));
  command->footer(
      "Each kind of work that the renderer leaves out is done after all, on a scene that has much "
      "of\n"
      "it, in turns with leaving it out: whether the picture keeps its bits, how often it was "
      "left\n"
      "out, and what of the processor time of building and tracing that saves. docs/skipping.md "
      "tells\n"
      "why each is right. The exit code is 3 where a picture differs by more than it may.\n"
      "Example:\n"
      "  tessera bench skip dark-shadow-rays unhit-meshes");
  add_whole(*command, "--repeats", 1, 1000, "Turns, of which medians are taken [9]",
            std::function([options](int64_t n) { options->repeats = static_cast<int>(n); }));
  command->add_flag("--quick", options->quick,
                    "A sixteenth of the pixels, --repeats 3: of what it costs to build "
                    "a scene the savings say too much");
  command->add_option("--json", options->json_file, "Write the rows as JSON too")
      ->type_name("FILE");
  command->callback(
      [options, &action] { action = [options] { return bench_skip_command(*options); }; });
}

}  // namespace tessera
