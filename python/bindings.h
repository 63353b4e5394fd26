#pragma once

#include <pybind11/pybind11.h>

namespace tessera {

/// The `__new__` of every class of the module: it calls `__init__`, so that no object exists
/// without the C++ value that its methods read. (pybind11 would leave that to a later call, which a
/// pickle or a script may not make. It ignores the second call, by Python.)
inline PyObject* new_initialized(PyTypeObject* type, PyObject* arguments, PyObject* keywords) {
  PyObject* made = type->tp_base->tp_new(type, arguments, keywords);
  if (made && type->tp_init(made, arguments, keywords) < 0) Py_CLEAR(made);
  return made;
}

/// A class that nobody derives from and that has no objects without a C++ value.
template <class... Types, class... Extras>
pybind11::class_<Types...> bind_class(pybind11::module_& module, const char* name,
                                      const Extras&... extras) {
  const auto set_up = [](PyHeapTypeObject* made) { made->ht_type.tp_new = new_initialized; };
  return {module, name, pybind11::is_final(), pybind11::custom_type_setup(set_up), extras...};
}

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
