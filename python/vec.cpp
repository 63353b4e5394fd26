#include <fmt/format.h>

#include <cmath>

#include "python/array_source.h"
#include "python/bindings.h"
#include "python/errors.h"
#include "python/value_reader.h"

namespace py = pybind11;

namespace tessera {
namespace {

/// `tessera.Vec`: three numbers that never change.
struct Vec {
  double at[3];
};

/// TypeError in place of another, ValueError for a number too large; what is none of the value
/// passes.
[[noreturn]] void refuse(const std::string& found) {
  refuse_overflow("vector");
  if (PyErr_Occurred() && !PyErr_ExceptionMatches(PyExc_TypeError)) throw py::error_already_set();
  PyErr_Clear();
  throw py::type_error(found + "; expected a vector of 3 numbers");
}

Vec take(py::handle given) {
  if (py::isinstance<Vec>(given)) return given.cast<Vec>();
  refuse_masked(given, "vector");
  // A tuple of its own: a list may change its length while a number of the user's is read.
  const auto items = py::reinterpret_steal<py::tuple>(
      py::isinstance<py::str>(given) ? nullptr : PySequence_Tuple(given.ptr()));
  if (!items) refuse(describe_found(given));
  if (items.size() != 3) refuse(fmt::format("{} numbers", items.size()));
  Vec vec{};
  for (size_t axis = 0; axis < 3; ++axis) {
    const py::handle item = PyTuple_GET_ITEM(items.ptr(), static_cast<py::ssize_t>(axis));
    refuse_masked(item, "vector");
    vec.at[axis] = PyFloat_AsDouble(item.ptr());
    if (vec.at[axis] == -1 && PyErr_Occurred()) refuse(describe_found(item));
  }
  return vec;
}

template <class F>
Vec each(const Vec& a, const Vec& b, F f) {
  return {{f(a.at[0], b.at[0]), f(a.at[1], b.at[1]), f(a.at[2], b.at[2])}};
}
Vec scaled(const Vec& v, double s) { return {{v.at[0] * s, v.at[1] * s, v.at[2] * s}}; }
double dot(const Vec& a, const Vec& b) {
  return a.at[0] * b.at[0] + a.at[1] * b.at[1] + a.at[2] * b.at[2];
}
Vec cross(const Vec& a, const Vec& b) {
  return {{a.at[1] * b.at[2] - a.at[2] * b.at[1], a.at[2] * b.at[0] - a.at[0] * b.at[2],
           a.at[0] * b.at[1] - a.at[1] * b.at[0]}};
}
double length(const Vec& v) { return std::hypot(v.at[0], v.at[1], v.at[2]); }

Vec normalized(const Vec& v) {
  const double l = length(v);
  if (!(l > 0) || !std::isfinite(l)) {
    throw py::value_error(fmt::format("Vec: length {}; expected a finite length above 0", l));
  }
  return {{v.at[0] / l, v.at[1] / l, v.at[2] / l}};
}

py::tuple numbers_of(const Vec& v) { return py::make_tuple(v.at[0], v.at[1], v.at[2]); }

py::object item(const Vec& v, py::handle index) {
  if (!PyIndex_Check(index.ptr()) && !PySlice_Check(index.ptr()))
    throw py::type_error(describe_found(index) + "; expected an index from -3 to 2, or a slice");
  const auto found =
      py::reinterpret_steal<py::object>(PyObject_GetItem(numbers_of(v).ptr(), index.ptr()));
  if (found) return found;
  if (!PyErr_ExceptionMatches(PyExc_IndexError)) throw py::error_already_set();
  PyErr_Clear();
  throw py::index_error(describe_found(index) + "; expected an index from -3 to 2");
}

std::string show(const Vec& v) {
  const auto text = [](double x) { return py::repr(py::float_(x)).cast<std::string>(); };
  return fmt::format("Vec({}, {}, {})", text(v.at[0]), text(v.at[1]), text(v.at[2]));
}

/// Whether it is an array of numpy, or of a library that works with numpy's.
bool is_array(py::handle given) {
  if (PyType_Check(given.ptr()) || !py::hasattr(given, "__array_ufunc__")) return false;
  const py::object axes = py::getattr(given, "ndim", py::none());
  return PyLong_Check(axes.ptr()) && PyLong_AsLong(axes.ptr()) > 0;
}
bool is_sequence(py::handle given) {
  return PySequence_Check(given.ptr()) && !py::isinstance<py::str>(given) &&
         !py::isinstance<py::bytes>(given);
}
py::object not_implemented() { return py::reinterpret_borrow<py::object>(Py_NotImplemented); }

/// Defines an operator. With arrays it is that of the array of the three numbers, on either side of
/// them; `own` has the rest.
template <class Own>
void define(py::class_<Vec>& type, const char* name, const Own& own) {
  type.def(name, [name, own](const py::object& self, py::handle other) -> py::object {
    if (!is_array(other)) return own(self.cast<const Vec&>(), other);
    return py::module_::import("numpy").attr("asarray")(self).attr(name)(other);
  });
}

template <class F>
auto with_vector(F f) {
  return [f](const Vec& a, py::handle b) {
    return is_sequence(b) ? py::cast(f(a, take(b))) : not_implemented();
  };
}
template <class F>
auto with_number(F f) {
  return [f](const Vec& a, py::handle b) {
    const double number = PyFloat_AsDouble(b.ptr());
    if (number != -1 || !PyErr_Occurred()) return py::cast(f(a, number));
    refuse_overflow("Vec");
    if (!PyErr_ExceptionMatches(PyExc_TypeError)) throw py::error_already_set();
    PyErr_Clear();
    return not_implemented();
  };
}

Vec divided(const Vec& v, double s) {
  if (s == 0) {
    PyErr_SetString(PyExc_ZeroDivisionError, "Vec: division by zero");
    throw py::error_already_set();
  }
  return {{v.at[0] / s, v.at[1] / s, v.at[2] / s}};
}

/// A list, tuple or the like is equal that has the same three numbers.
template <bool kWanted>
py::object compare_numbers(const Vec& a, py::handle other) {
  if (!is_sequence(other)) return not_implemented();
  const py::tuple numbers = numbers_of(a);
  return py::bool_(numbers.equal(py::tuple(py::reinterpret_borrow<py::object>(other))) == kWanted);
}

void define_operators(py::class_<Vec>& type) {
  define(type, "__add__",
         with_vector([](const Vec& a, const Vec& b) { return each(a, b, std::plus<>()); }));
  define(type, "__radd__",
         with_vector([](const Vec& a, const Vec& b) { return each(b, a, std::plus<>()); }));
  define(type, "__sub__",
         with_vector([](const Vec& a, const Vec& b) { return each(a, b, std::minus<>()); }));
  define(type, "__rsub__",
         with_vector([](const Vec& a, const Vec& b) { return each(b, a, std::minus<>()); }));
  define(type, "__mul__", with_number(scaled));
  define(type, "__rmul__", with_number(scaled));
  define(type, "__truediv__", with_number(divided));
  define(type, "__eq__", compare_numbers<true>);
  define(type, "__ne__", compare_numbers<false>);
  // numpy leaves these to us as well, since we ask it to leave the others.
  for (const char* name :
       {"__rtruediv__", "__floordiv__", "__rfloordiv__", "__mod__", "__rmod__", "__pow__",
        "__rpow__", "__matmul__", "__rmatmul__", "__lt__", "__le__", "__gt__", "__ge__"}) {
    define(type, name, [](const Vec&, py::handle) { return not_implemented(); });
  }
  type.def("__neg__", [](const Vec& v) { return scaled(v, -1); });
  type.attr("__array_priority__") = 1.0;
}

}  // namespace

void bind_vec(py::module_& module) {
  auto type =
      bind_class<Vec>(module, "Vec", py::buffer_protocol(),
                      "A vector of three numbers, which never changes. Tuples, lists and arrays "
                      "are taken wherever a Vec is.");
  type.def(py::init([](double x, double y, double z) {
             return Vec{{x, y, z}};
           }),
           py::arg("x"), py::arg("y"), py::arg("z"))
      .def(py::init([](const py::object& given) { return take(given); }), py::arg("components"))
      // What is neither: pybind11's error would name C++ types.
      .def(py::init([](const py::args& given, const py::kwargs& named) {
        if (named.empty()) return take(given);
        const auto name = py::cast<std::string>(named.begin()->first);
        throw py::type_error(fmt::format("{}: expected Vec(x, y, z) or Vec(components)", name));
      }))
      .def_buffer([](const Vec& v) {
        return py::buffer_info(const_cast<double*>(v.at), sizeof(double), "d", 1, {3},
                               {sizeof(double)}, true);
      })
      .def_property_readonly(
          "x", [](const Vec& v) { return v.at[0]; }, "The first component.")
      .def_property_readonly(
          "y", [](const Vec& v) { return v.at[1]; }, "The second component.")
      .def_property_readonly(
          "z", [](const Vec& v) { return v.at[2]; }, "The third component.")
      .def("__len__", [](const Vec&) { return 3; })
      .def("__getitem__", item)
      .def("__iter__", [](const Vec& v) { return py::iter(numbers_of(v)); })
      .def("__hash__", [](const Vec& v) { return py::hash(numbers_of(v)); })
      .def("__repr__", show)
      .def(
          "dot", [](const Vec& a, py::handle b) { return dot(a, take(b)); }, "The scalar product.")
      .def(
          "cross", [](const Vec& a, py::handle b) { return cross(a, take(b)); },
          "The vector product.")
      .def_property_readonly(
          "length", [](const Vec& v) { return length(v); }, "The Euclidean length.")
      .def(
          "normalized", [](const Vec& v) { return normalized(v); },
          "The vector of length 1 in this direction.")
      .def("__reduce__", [](const py::object& self) {
        return py::make_tuple(py::type::of(self), py::tuple(self));
      });
  define_operators(type);
}

}  // namespace tessera
