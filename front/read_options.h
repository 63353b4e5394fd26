#pragma once

#include "front/option_list.h"
#include "scenes/import/loaded_scene.h"

namespace tessera {

/// Adds the options that say how files are read; `options` must outlive the parsing.
void add_read_options(OptionList& list, ReadOptions& options);

}  // namespace tessera
