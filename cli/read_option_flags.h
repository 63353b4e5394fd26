#pragma once

#include "scenes/import/loaded_scene.h"

namespace CLI {
class App;
}

namespace tessera {

/// Adds the options that say how files are read; `options` must outlive the parsing.
void add_read_options(CLI::App& command, ReadOptions& options);

}  // namespace tessera
