#pragma once

#include <pybind11/pybind11.h>

namespace tessera {

// Each adds the classes and functions of one topic to the module `tessera._core`.

void bind_errors(pybind11::module_& module);
void bind_mesh_arrays(pybind11::module_& module);
void bind_value_base(pybind11::module_& module);
void bind_vec(pybind11::module_& module);
void bind_quadratic(pybind11::module_& module);
void bind_arrays(pybind11::module_& module);
void bind_scene(pybind11::module_& module);
void bind_load(pybind11::module_& module);
void bind_transforms(pybind11::module_& module);
void bind_textures(pybind11::module_& module);
void bind_picture(pybind11::module_& module);
void bind_picture_state(pybind11::module_& module);
void bind_render(pybind11::module_& module);
/// From here on what C++ logs waits for `take_log()`.
void bind_log(pybind11::module_& module);
void bind_program(pybind11::module_& module);
void bind_tracer(pybind11::module_& module);

}  // namespace tessera
