#include "python/bindings.h"

// The extension module `tessera._core`. The package `tessera` imports it and is what users see.
PYBIND11_MODULE(_core, module) {
  tessera::bind_errors(module);
  tessera::bind_arrays(module);
  tessera::bind_scene(module);
  tessera::bind_tracer(module);
}
