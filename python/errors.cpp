#include "python/errors.h"

#include "base/error.h"
#include "python/bindings.h"
#include "python/gil.h"

namespace py = pybind11;

namespace tessera {

py::object error_class(const char* name) {
  return py::module_::import("tessera.errors").attr(name);
}

py::error_already_set python_error(const char* name, const std::string& message) {
  const py::object type = error_class(name);
  PyErr_SetObject(type.ptr(), run_or_sleep([&] { return type(message); }).ptr());
  return {};
}

namespace {

/// Sets the Python exception that stands for `error`: its class by the code, its place and
/// suggestion from the message.
void set_python_error(const Error& error) {
  const py::object make = py::module_::import("tessera.errors").attr("from_core");
  const py::object made =
      run_or_sleep([&] { return make(error.what(), static_cast<int>(error.code())); });
  PyErr_SetObject(py::type::of(made).ptr(), made.ptr());
}

}  // namespace

void bind_errors(py::module_&) {
  // std::bad_alloc becomes MemoryError by pybind11's own translation.
  py::register_exception_translator([](std::exception_ptr thrown) {
    try {
      if (thrown) std::rethrow_exception(thrown);
    } catch (const Error& error) {
      set_python_error(error);
    }
  });
}

}  // namespace tessera
