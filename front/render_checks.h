#pragma once

#include "front/render_options.h"

namespace tessera {

/// Throws a usage error for options that exclude each other, and for what has no place in a pipe.
void check_render_options(const RenderOptions& options);

/// Throws one for files that could not be written, or read, in the end.
void check_outputs(const RenderOptions& options);

}  // namespace tessera
