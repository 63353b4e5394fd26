#include <fmt/format.h>

#include <cmath>

#include "python/bindings.h"
#include "python/value_reader.h"

namespace py = pybind11;

namespace tessera {
namespace {

/// `tessera.Vec`: three numbers that never change.
struct Vec {
  double at[3];
};

/// TypeError in place of another; what is none of the value passes.
[[noreturn]] void refuse(const std::string& found) {
  if (PyErr_Occurred() && !PyErr_ExceptionMatches(PyExc_TypeError)) throw py::error_already_set();
  PyErr_Clear();
  throw py::type_error(found + "; expected a vector of 3 numbers");
}

Vec take(py::handle given) {
  if (py::isinstance<Vec>(given)) return given.cast<Vec>();
  // A tuple of its own: a list may change its length while a number of the user's is read.
  const auto items = py::reinterpret_steal<py::tuple>(
      py::isinstance<py::str>(given) ? nullptr : PySequence_Tuple(given.ptr()));
  if (!items) refuse(describe_found(given));
  if (items.size() != 3) refuse(fmt::format("{} numbers", items.size()));
  Vec vec{};
  for (size_t axis = 0; axis < 3; ++axis) {
    const py::handle item = PyTuple_GET_ITEM(items.ptr(), static_cast<py::ssize_t>(axis));
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

double item(const Vec& v, py::ssize_t index) {
  const py::ssize_t at = index < 0 ? index + 3 : index;
  if (at < 0 || at > 2) throw py::index_error(fmt::format("index {} of 3", index));
  return v.at[at];
}

std::string show(const Vec& v) {
  const auto text = [](double x) { return py::repr(py::float_(x)).cast<std::string>(); };
  return fmt::format("Vec({}, {}, {})", text(v.at[0]), text(v.at[1]), text(v.at[2]));
}

void define_arithmetic(py::class_<Vec>& type) {
  // Whatever is no vector is left to the other operand, as numpy's arrays do.
  type.def("__add__", [](const Vec& a, py::handle b) { return each(a, take(b), std::plus<>()); })
      .def("__radd__", [](const Vec& a, py::handle b) { return each(take(b), a, std::plus<>()); })
      .def("__sub__", [](const Vec& a, py::handle b) { return each(a, take(b), std::minus<>()); })
      .def("__rsub__", [](const Vec& a, py::handle b) { return each(take(b), a, std::minus<>()); })
      .def("__mul__", scaled)
      .def("__rmul__", scaled)
      .def("__truediv__",
           [](const Vec& v, double s) {
             if (s == 0) {
               PyErr_SetString(PyExc_ZeroDivisionError, "Vec: division by zero");
               throw py::error_already_set();
             }
             return Vec{{v.at[0] / s, v.at[1] / s, v.at[2] / s}};
           })
      .def("__neg__", [](const Vec& v) { return scaled(v, -1); });
}

}  // namespace

void bind_vec(py::module_& module) {
  py::class_<Vec> type(module, "Vec", py::buffer_protocol(),
                       "A vector of three numbers, which never changes. Tuples, lists and arrays "
                       "are taken wherever a Vec is.");
  type.def(py::init([](double x, double y, double z) {
             return Vec{{x, y, z}};
           }),
           py::arg("x"), py::arg("y"), py::arg("z"))
      .def(py::init([](const py::object& given) { return take(given); }), py::arg("components"))
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
      .def("__iter__",
           [](const Vec& v) { return py::iter(py::make_tuple(v.at[0], v.at[1], v.at[2])); })
      .def("__eq__",
           [](const Vec& a, py::handle other) -> py::object {
             if (!py::isinstance<Vec>(other) && !py::isinstance<py::tuple>(other)) {
               return py::reinterpret_borrow<py::object>(Py_NotImplemented);
             }
             return py::bool_(py::make_tuple(a.at[0], a.at[1], a.at[2])
                                  .equal(py::tuple(py::reinterpret_borrow<py::object>(other))));
           })
      .def("__hash__",
           [](const Vec& v) { return py::hash(py::make_tuple(v.at[0], v.at[1], v.at[2])); })
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
  define_arithmetic(type);
}

}  // namespace tessera
