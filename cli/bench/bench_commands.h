#pragma once

#include "cli/command_line.h"

namespace tessera {

/// `bench` with all of its kinds.
void add_bench_kinds(CLI::App& app, Action& action);
/// rays and octree.
void add_tracing_benches(CLI::App& bench, Action& action);
void add_precision_and_growth_benches(CLI::App& bench, Action& action);
void add_error_bench(CLI::App& bench, Action& action);
void add_skip_bench(CLI::App& bench, Action& action);
void add_studio_bench(CLI::App& bench, Action& action);

}  // namespace tessera
