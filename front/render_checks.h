#pragma once

#include "front/render_options.h"

namespace tessera {

/// Throws a usage error for options that exclude each other, and for what has no place in a pipe.
void check_render_options(const RenderOptions& options);

/// Throws one for files that could not be written in the end, and a scene error for a scene that is
/// missing or of a format that is not read.
void check_outputs(const RenderOptions& options);

}  // namespace tessera
