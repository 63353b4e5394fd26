#include "python/bindings.h"
#include "python/gil.h"

namespace py = pybind11;

namespace {

bool is_main_interpreter() { return PyInterpreterState_Get() == PyInterpreterState_Main(); }

PyObject* refuse(const char* why) {
  PyErr_SetString(PyExc_ImportError, why);
  return nullptr;
}

PyObject* new_object(PyTypeObject* type, PyObject* arguments, PyObject* keywords) {
  if (!py::detail::all_type_info(type).empty())
    return py::detail::pybind11_object_new(type, arguments, keywords);
  PyErr_Format(PyExc_TypeError, "%s: cannot be called; expected a class of tessera", type->tp_name);
  return nullptr;
}

/// Has the class that all others derive from refuse to be called, where pybind11 2.10 would end the
/// process.
void refuse_bare_objects() {
  auto* base = reinterpret_cast<PyTypeObject*>(py::detail::get_internals().instance_base);
  base->tp_new = new_object;
}

void fill(py::module_& module) {
  refuse_bare_objects();
  module.def("is_main_interpreter", is_main_interpreter,
             "Whether the caller runs in the main interpreter.");
  tessera::bind_errors(module);
  tessera::bind_arrays(module);
  tessera::bind_mesh_arrays(module);
  tessera::bind_value_base(module);
  tessera::bind_vec(module);
  tessera::bind_quadratic(module);
  tessera::bind_scene(module);
  tessera::bind_load(module);
  tessera::bind_transforms(module);
  tessera::bind_textures(module);
  tessera::bind_picture(module);
  tessera::bind_picture_state(module);
  tessera::bind_render(module);
  tessera::bind_log(module);
  tessera::bind_program(module);
  tessera::bind_tracer(module);
}

}  // namespace

// The extension module `tessera._core`. The package `tessera` imports it and is what users see.
//
// PYBIND11_MODULE would write the same but for the refusals. They have to come before anything of
// pybind11, which keeps its types in the interpreter that loads a module first, and ends the
// process where the module is made a second time. Python does that for a file that it meets by
// another path.
extern "C" PYBIND11_EXPORT PyObject* PyInit__core() {
  static bool is_made = false;
  if (!is_main_interpreter())
    return refuse("a sub-interpreter imports tessera; expected the main one");
  if (is_made) return refuse("tessera was imported by another path before; expected the same path");
  is_made = true;
  PYBIND11_CHECK_PYTHON_VERSION
  PYBIND11_ENSURE_INTERNALS_READY
  static PyModuleDef definition;
  auto module = py::module_::create_extension_module("_core", nullptr, &definition);
  try {
    fill(module);
    tessera::UnlockedWork::is_waited_for_at_exit();
    return module.ptr();
  }
  PYBIND11_CATCH_INIT_EXCEPTIONS
}
