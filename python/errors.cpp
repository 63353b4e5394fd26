#include "python/errors.h"

#include <string_view>

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

std::string with_article(const std::string& noun) {
  const bool is_vowel =
      !noun.empty() && std::string_view("AEIOaeio").find(noun[0]) != std::string_view::npos;
  return (is_vowel ? "an " : "a ") + noun;
}

namespace {

/// Sets the Python exception that stands for `error`: its class by the code, its place and
/// suggestion from the message.
void set_python_error(const Error& error) {
  const py::object make = py::module_::import("tessera.errors").attr("from_core");
  // A message may name a file, whose name is any bytes. Python escapes those that are not UTF-8.
  const std::string_view text = error.what();
  const auto message = py::reinterpret_steal<py::object>(
      PyUnicode_DecodeUTF8(text.data(), static_cast<py::ssize_t>(text.size()), "surrogateescape"));
  if (!message) throw py::error_already_set();
  const py::object made =
      run_or_sleep([&] { return make(message, static_cast<int>(error.code())); });
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
