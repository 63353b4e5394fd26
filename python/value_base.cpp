#include <new>

#include "python/bindings.h"
#include "python/value_classes.h"

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

/// What the attribute keeps of a text: of a word its one spelling.
py::object spelt_word(py::handle self, const char* name, py::handle text) {
  const auto kept = py::reinterpret_borrow<py::object>(text);
  const ValueClass* made = find_value_class(self);
  const ValueField* field = made ? made->find(name) : nullptr;
  const auto words = field && field->field ? words_of(*field->field) : std::vector<std::string>();
  if (words.empty()) return kept;
  py::ssize_t size = 0;
  const char* given = PyUnicode_AsUTF8AndSize(text.ptr(), &size);
  if (given) return py::str(spelt({given, static_cast<size_t>(size)}, words));
  PyErr_Clear();  // which is no word, and refused where the value is read
  return kept;
}

int set_attribute(PyObject* self, PyObject* name, PyObject* value) {
  py::object word;
  const char* named = value && PyUnicode_Check(value) ? PyUnicode_AsUTF8(name) : nullptr;
  if (named) {
    try {
      word = spelt_word(self, named, value);
    } catch (py::error_already_set& error) {
      error.restore();
      return -1;
    } catch (const std::bad_alloc&) {
      PyErr_NoMemory();
      return -1;
    }
    value = word.ptr();
  } else {
    PyErr_Clear();  // of a name that is no text, or none in UTF-8
  }
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
