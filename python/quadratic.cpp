#include "renderer/math/quadratic.h"

#include <fmt/format.h>

#include "python/bindings.h"
#include "python/errors.h"
#include "python/value_reader.h"

namespace py = pybind11;

namespace tessera {
namespace {

int exponent_of(double x) {
  int exponent = 0;
  std::frexp(x, &exponent);
  return exponent;
}

/// The roots of a x^2 + b x + c for coefficients of any size. Where b^2 is so large that 4 a c
/// would vanish beside it, the roots are -b / a and -c / b. All others are solved for x = y 2^k,
/// with powers of two that make the coefficients of y^2 and 1 about as large as 1, so that no
/// product leaves the range.
int solve_any_quadratic(double a, double b, double c, double (&roots)[2]) {
  if (a == 0) return solve_quadratic(a, b, c, roots);
  const int of_a = exponent_of(a), of_b = exponent_of(b), of_c = exponent_of(c);
  constexpr int kVanishes = 110;
  if (c == 0 || (b != 0 && 2 * of_b > of_a + of_c + kVanishes)) {
    roots[0] = 0 - b / a;
    roots[1] = b == 0 ? roots[0] : 0 - c / b;
    if (roots[0] > roots[1]) std::swap(roots[0], roots[1]);
    return roots[0] == roots[1] ? 1 : 2;
  }
  const int k = (of_c - of_a) / 2;
  const int count = solve_quadratic(std::ldexp(a, 2 * k - of_c), std::ldexp(b, k - of_c),
                                    std::ldexp(c, -of_c), roots);
  for (double& root : roots) root = std::ldexp(root, k);
  return count;
}

py::tuple real_roots(py::handle a, py::handle b, py::handle c) {
  const py::handle objects[] = {a, b, c};
  double given[3];
  for (int i = 0; i < 3; ++i) {
    given[i] = PyFloat_AsDouble(objects[i].ptr());
    if (given[i] == -1 && PyErr_Occurred()) {
      refuse_overflow({"abc"[i]});
      if (!PyErr_ExceptionMatches(PyExc_TypeError)) throw py::error_already_set();
      PyErr_Clear();
      throw py::type_error(
          fmt::format("{}: {}; expected a number", "abc"[i], describe_found(objects[i])));
    }
    if (!std::isfinite(given[i])) {
      throw py::value_error(fmt::format("{}: {}; expected a finite number", "abc"[i], given[i]));
    }
  }
  double roots[2] = {};
  const int count = solve_any_quadratic(given[0], given[1], given[2], roots);
  py::list found;
  for (int i = 0; i < count; ++i) {
    if (std::isfinite(roots[i])) found.append(roots[i]);
  }
  return py::tuple(found);
}

}  // namespace

void bind_quadratic(py::module_& module) {
  module.def(
      "solve_quadratic", real_roots, py::arg("a"), py::arg("b"), py::arg("c"),
      "The real roots of a x^2 + b x + c = 0 as an ascending tuple, each at most 4 ulp off. A "
      "double root is there once, one beyond the range of float is left out; with a = 0 the "
      "equation is linear, and with b = 0 too it has no root that could be named.");
}

}  // namespace tessera
