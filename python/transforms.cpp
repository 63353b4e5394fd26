#include <fmt/format.h>

#include <pybind11/stl.h>

#include <algorithm>
#include <atomic>
#include <cmath>
#include <utility>

#include "proto/tessera/v1/scene.pb.h"
#include "python/array_source.h"
#include "python/bindings.h"
#include "python/interruptible.h"
#include "python/value_reader.h"
#include "renderer/math/transform.h"
#include "scenes/import/to_affine.h"

namespace py = pybind11;

namespace tessera {
namespace {

Affine affine_of(py::handle transform) {
  v1::Scene scene;
  BlobStore blobs;
  v1::Transform message;
  ValueReader(scene, blobs).read(transform, message);
  return to_affine(message);
}

std::vector<double> numbers_of(const Affine& affine) {
  std::vector<double> numbers;
  for (const auto& row : affine.m) numbers.insert(numbers.end(), row.begin(), row.end());
  return numbers;
}

/// The three upper rows of a transform's matrix.
Array transform_matrix(py::handle transform) { return {numbers_of(affine_of(transform)), {3, 4}}; }

/// Those of its inverse.
std::vector<double> inverse_matrix(py::handle transform) {
  std::vector<double> numbers = numbers_of(inverse(affine_of(transform)));
  if (!std::ranges::all_of(numbers, [](double number) { return std::isfinite(number); })) {
    throw py::value_error(
        "transform: has no inverse; expected one that keeps different points apart");
  }
  return numbers;
}

/// Matrices of three or four rows as (n, 3, 4) in double precision.
Array take_matrices(py::handle given, const std::string& name) {
  const ArraySource source = array_source(given, name);
  Array::Shape shape = source.shape;
  if (shape.size() == 2) shape.insert(shape.begin(), 1);
  if (shape == Array::Shape{1, 0} || shape == Array::Shape{0})
    return {std::vector<double>(), {0, 3, 4}};
  if (shape.size() != 3 || (shape[1] != 3 && shape[1] != 4) || shape[2] != 4) {
    wrong_shape(name, source.shape, "(any, 3, 4) or (any, 4, 4)");
  }
  const py::ssize_t count = shape[0] * 12, of_one = shape[1] * 4;
  auto [matrices, wrong] = run_unlocked(
      static_cast<size_t>(count) * sizeof(double),
      [source, count, of_one](const std::atomic<bool>& stop) {
        std::vector<double> numbers;
        numbers.reserve(static_cast<size_t>(count));
        constexpr double kLastRow[] = {0, 0, 0, 1};
        py::ssize_t at = 0, bad = -1;
        for_each_element<double>(source, stop, [&](double number) {
          const py::ssize_t place = at % of_one;
          const bool is_right = place < 12 ? std::isfinite(number) : number == kLastRow[place - 12];
          if (!is_right && bad < 0) bad = at / of_one;
          if (place < 12) numbers.push_back(number);
          ++at;
        });
        return std::pair(std::move(numbers), bad);
      });
  if (wrong >= 0) {
    throw py::value_error(fmt::format(
        "{}: matrix {} has a number that is not finite, or a fourth row; expected finite numbers "
        "and, if there is a fourth row, 0 0 0 1",
        name, wrong));
  }
  return {std::move(matrices), {shape[0], 3, 4}};
}

}  // namespace

void bind_transforms(py::module_& module) {
  module.def("transform_matrix", &transform_matrix,
             "The upper three rows of a transform's matrix.");
  module.def("inverse_matrix", &inverse_matrix, "The 12 numbers of the rows of its inverse.");
  module.def("take_matrices", &take_matrices, "Matrices as an array (n, 3, 4).");
}

}  // namespace tessera
