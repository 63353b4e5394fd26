#include "python/errors.h"

#include <string_view>

#include "base/error.h"
#include "base/missing_file.h"
#include "python/bindings.h"
#include "python/gil.h"

namespace py = pybind11;

namespace tessera {

py::object error_class(const char* name) {
  return py::module_::import("tessera.errors").attr(name);
}

namespace {

/// A message may name a file, whose name is any bytes. Python escapes those that are not UTF-8.
py::object text_of(std::string_view bytes) {
  const auto text = py::reinterpret_steal<py::object>(PyUnicode_DecodeUTF8(
      bytes.data(), static_cast<py::ssize_t>(bytes.size()), "surrogateescape"));
  if (!text) throw py::error_already_set();
  return text;
}

}  // namespace

void set_python_error(const char* name, const std::string& message,
                      const std::vector<std::pair<const char*, std::string>>& keywords) {
  const py::object type = error_class(name);
  py::dict named;
  for (const auto& [keyword, text] : keywords) named[keyword] = text_of(text);
  const py::object made = run_or_sleep([&] { return type(text_of(message), **named); });
  PyErr_SetObject(type.ptr(), made.ptr());
}

py::error_already_set python_error(const char* name, const std::string& message) {
  set_python_error(name, message);
  return {};
}

void refuse_overflow(const std::string& name) {
  if (!PyErr_Occurred() || !PyErr_ExceptionMatches(PyExc_OverflowError)) return;
  PyErr_Clear();
  throw py::value_error(name + ": a number above all that a float has; expected a smaller one");
}

std::string with_article(const std::string& noun) {
  const bool is_vowel =
      !noun.empty() && std::string_view("AEIOaeio").find(noun[0]) != std::string_view::npos;
  return (is_vowel ? "an " : "a ") + noun;
}

namespace {

/// Sets the Python exception that stands for `error`: its class by the code, its place and
/// suggestion from the message, where that has them.
void translate(const Error& error) {
  const py::object make = py::module_::import("tessera.errors").attr("from_core");
  const auto& parts = error.diagnostics();
  const std::string file = parts.empty() ? "" : parts.front().place.file;
  const py::object made = run_or_sleep(
      [&] { return make(text_of(error.what()), static_cast<int>(error.code()), text_of(file)); });
  PyErr_SetObject(py::type::of(made).ptr(), made.ptr());
}

}  // namespace

void bind_errors(py::module_&) {
  // std::bad_alloc becomes MemoryError by pybind11's own translation.
  py::register_exception_translator([](std::exception_ptr thrown) {
    try {
      if (thrown) std::rethrow_exception(thrown);
    } catch (const MissingFileError& error) {
      set_python_error("MissingFile", error.what(), {{"filename", error.path()}});
    } catch (const Error& error) {
      translate(error);
    } catch (const py::value_error& error) {
      set_python_error("UsageError", error.what());
    }
  });
}

}  // namespace tessera
