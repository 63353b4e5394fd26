#include "python/bindings.h"

// The extension module `tessera._core`. The package `tessera` imports it and is what users see.
PYBIND11_MODULE(_core, module) {
  tessera::bind_errors(module);
  tessera::bind_arrays(module);
  tessera::bind_mesh_arrays(module);
  tessera::bind_value_base(module);
  tessera::bind_vec(module);
  tessera::bind_scene(module);
  tessera::bind_load(module);
  tessera::bind_transforms(module);
  tessera::bind_picture(module);
  tessera::bind_render(module);
  tessera::bind_log(module);
}
