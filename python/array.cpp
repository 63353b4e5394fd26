#include "python/array.h"

#include "python/bindings.h"

namespace py = pybind11;

namespace tessera {
namespace {

py::buffer_info buffer_of(const Array& array) {
  const ElementType type = array.type();
  Array::Shape strides(array.shape().size());
  py::ssize_t stride = type.size;
  for (size_t axis = strides.size(); axis-- > 0;) {
    strides[axis] = stride;
    stride *= array.shape()[axis];
  }
  return {const_cast<void*>(array.data()),
          type.size,
          std::string(1, type.code),
          static_cast<py::ssize_t>(strides.size()),
          array.shape(),
          strides,
          true};
}

py::tuple shape_of(const Array& array) {
  py::tuple shape(array.shape().size());
  for (size_t axis = 0; axis < shape.size(); ++axis) shape[axis] = array.shape()[axis];
  return shape;
}

py::ssize_t length_of(const Array& array) {
  if (array.shape().empty()) throw py::type_error("an array without axes has no length");
  return array.shape()[0];
}

/// A row of an array as an array that shares its memory; a number where there is one axis.
py::object item_of(const Array& array, py::ssize_t index) {
  const py::ssize_t length = length_of(array);
  const py::ssize_t at = index < 0 ? index + length : index;
  if (at < 0 || at >= length) {
    throw py::index_error("index " + std::to_string(index) + " of " + std::to_string(length));
  }
  Array::Shape rest(array.shape().begin() + 1, array.shape().end());
  const auto view =
      py::reinterpret_steal<py::object>(PyMemoryView_FromObject(py::cast(array).ptr()));
  if (rest.empty()) return view[py::int_(at)];
  Array row(array.owner(), nullptr, array.type(), rest);
  const py::ssize_t row_bytes = row.count() * array.type().size;
  return py::cast(Array(array.owner(), static_cast<const std::byte*>(array.data()) + at * row_bytes,
                        array.type(), std::move(rest)));
}

}  // namespace

void bind_arrays(py::module_& module) {
  py::class_<Array>(module, "Array", py::buffer_protocol(),
                    "A read-only array: `numpy.asarray` and `memoryview` share its memory.")
      .def_buffer(buffer_of)
      .def_property_readonly("shape", shape_of, "The length of each axis.")
      .def_property_readonly(
          "dtype", [](const Array& array) { return std::string(1, array.type().code); },
          "What an element is, as a code of the module `struct`.")
      .def("__len__", length_of)
      .def("__getitem__", item_of);
}

}  // namespace tessera
