#include "python/bindings.h"

namespace py = pybind11;

namespace tessera {
namespace {

/// Leaves it to `tessera._value.refuse_name` to say which name is nearest to one that `self` lacks.
void refuse_name(PyObject* self, PyObject* name) {
  if (!PyErr_ExceptionMatches(PyExc_AttributeError)) return;
  PyErr_Clear();
  try {
    py::module_::import("tessera._value").attr("refuse_name")(py::handle(self), py::handle(name));
  } catch (py::error_already_set& refused) {
    refused.restore();
  }
}

PyObject* get_attribute(PyObject* self, PyObject* name) {
  PyObject* found = PyObject_GenericGetAttr(self, name);
  // Names with two underscores are asked for by protocols that expect plain answers.
  if (!found && PyUnicode_Check(name) && PyUnicode_GetLength(name) > 0 &&
      PyUnicode_ReadChar(name, 0) != '_') {
    refuse_name(self, name);
  }
  return found;
}

int set_attribute(PyObject* self, PyObject* name, PyObject* value) {
  const int failed = PyObject_GenericSetAttr(self, name, value);
  if (failed) refuse_name(self, name);
  return failed;
}

PyType_Slot kSlots[] = {
    {Py_tp_getattro, reinterpret_cast<void*>(get_attribute)},
    {Py_tp_setattro, reinterpret_cast<void*>(set_attribute)},
    {Py_tp_doc, const_cast<char*>("Base of the values of a scene: a wrong name is told with the "
                                  "nearest right one.")},
    {0, nullptr}};
PyType_Spec kSpec = {"tessera._core.ValueBase", sizeof(PyObject), 0,
                     Py_TPFLAGS_DEFAULT | Py_TPFLAGS_BASETYPE, kSlots};

}  // namespace

void bind_value_base(py::module_& module) {
  module.add_object("ValueBase", py::reinterpret_steal<py::object>(PyType_FromSpec(&kSpec)));
}

}  // namespace tessera
