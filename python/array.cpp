#include "python/array.h"

#include <pybind11/stl.h>

#include <algorithm>
#include <atomic>
#include <cstring>
#include <memory>
#include <vector>

#include "base/cancellation.h"
#include "python/array_source.h"
#include "python/bindings.h"
#include "python/errors.h"
#include "python/gil.h"
#include "python/interruptible.h"

namespace py = pybind11;

namespace tessera {
namespace {

/// Throws TypeError for a code that arrays do not have.
ElementType element_type(const std::string& code) {
  constexpr std::string_view kCodes = "?bBhHiIlLqQefd";
  if (code.size() == 1 && kCodes.find(code[0]) != kCodes.npos) {
    const py::object size = py::module_::import("struct").attr("calcsize")(code);
    return {code[0], size.cast<py::ssize_t>()};
  }
  throw py::type_error("Array: elements of format '" + code + "'");
}

/// Ends large arrays without the GIL: to give a gigabyte back to the system takes 0.1 s.
struct EndUnlocked {
  void operator()(Array* array) const {
    constexpr size_t kFew = size_t{1} << 20;
    std::unique_ptr<Array> ending(array);
    if (ending->bytes().size() > kFew) free_unlocked(std::move(ending));
  }
};

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
py::object item_of(const Array& array, const py::object& given) {
  const py::ssize_t length = length_of(array);
  if (!PyIndex_Check(given.ptr())) {
    throw py::type_error(with_article(Py_TYPE(given.ptr())->tp_name) +
                         "; expected the index of a row");
  }
  const py::ssize_t index = PyNumber_AsSsize_t(given.ptr(), PyExc_IndexError);
  if (index == -1 && PyErr_Occurred()) throw py::error_already_set();
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

bool are_equal(const Array& a, const Array& b) {
  if (a.shape() != b.shape() || a.type().code != b.type().code) return false;
  if (a.data() == b.data() || a.bytes().empty()) return true;
  return run_unlocked(a.bytes().size(), [a, b](const std::atomic<bool>&) {
    return std::memcmp(a.data(), b.data(), a.bytes().size()) == 0;
  });
}

/// Small arrays print as what makes them again; large ones are told.
std::string show(const py::object& self) {
  constexpr py::ssize_t kMostShown = 1000;
  const auto& array = self.cast<const Array&>();
  const py::object shape = shape_of(array);
  if (array.count() > kMostShown) {
    return "<Array '" + std::string(1, array.type().code) + "' " +
           py::str(shape).cast<std::string>() + ">";
  }
  // memoryview knows all formats but half floats, which are shown as their bits.
  const bool is_half = array.type().code == 'e';
  const Array flat(array.owner(), array.data(), is_half ? ElementType{'H', 2} : array.type(),
                   {array.count()});
  const auto view =
      py::reinterpret_steal<py::object>(PyMemoryView_FromObject(py::cast(flat).ptr()));
  return "Array.of(" + py::repr(view.attr("tolist")()).cast<std::string>() + ", '" +
         std::string(1, array.type().code) + "', " + py::str(shape).cast<std::string>() + ")";
}

/// An array of that type from the bytes of a buffer, which it shares where nobody can write to it.
/// Indices are copied all the same: memory that cannot be written to here may be by its owner, and
/// who changes an index after it was checked must not reach the renderer.
Array from_bytes(const py::buffer& given, const std::string& code, Array::Shape shape) {
  const ArraySource source = array_source(
      py::module_::import("builtins").attr("memoryview")(given).attr("cast")("B"), "Array");
  const ElementType type = element_type(code);
  py::ssize_t bytes = type.size;
  for (const py::ssize_t length : shape) {
    if (length < 0 || (length > 0 && bytes > PY_SSIZE_T_MAX / length))
      wrong_shape("Array", shape, "lengths of axes");
    bytes *= length;
  }
  if (bytes != source.count()) {
    throw py::value_error("Array: " + std::to_string(source.count()) + " bytes; expected " +
                          std::to_string(bytes));
  }
  const bool may_be_indices = type.code == kElementOf<uint32_t>.code;
  if (source.read_only && !may_be_indices)
    return {source.owner, source.data, type, std::move(shape)};
  const auto copy = run_unlocked(static_cast<size_t>(bytes), [source,
                                                              bytes](const std::atomic<bool>&) {
    constexpr py::ssize_t kBetweenLooks = 1 << 24;
    std::vector<std::byte> made;
    made.reserve(static_cast<size_t>(bytes));
    for (py::ssize_t at = 0; at < bytes; at += kBetweenLooks) {
      Cancellation::check();
      made.insert(made.end(), source.data + at, source.data + std::min(bytes, at + kBetweenLooks));
    }
    return std::make_shared<const std::vector<std::byte>>(std::move(made));
  });
  return {copy, copy->data(), type, std::move(shape)};
}

/// An array of numbers in a list, as `repr` shows them.
Array from_list(const py::list& numbers, const std::string& code, Array::Shape shape) {
  element_type(code);
  const py::module_ module = py::module_::import("struct");
  const auto pack = module.attr("pack");
  constexpr py::ssize_t kAtOnce = 1 << 14;
  py::list parts;
  try {
    for (py::ssize_t at = 0; at < PyList_GET_SIZE(numbers.ptr()); at += kAtOnce) {
      const auto some =
          py::reinterpret_steal<py::list>(PyList_GetSlice(numbers.ptr(), at, at + kAtOnce));
      const std::string format = std::to_string(some.size()) + (code == "e" ? "H" : code);
      parts.append(pack(format, *some));
      let_others_run();
    }
    return from_bytes(py::bytes().attr("join")(parts), code, std::move(shape));
  } catch (py::error_already_set& error) {
    if (!error.matches(module.attr("error"))) throw;
    throw py::value_error("Array: " + py::str(error.value()).cast<std::string>() +
                          "; expected numbers of the format '" + code + "'");
  }
}

/// Bytes that are pickled at once, in a millisecond or so.
constexpr py::ssize_t kPickledBytes = 1 << 20;

/// The bytes of an array as arrays of some of them each, which pickle() asks one after the other.
py::list parts_of(const Array& array) {
  const auto* const first = static_cast<const std::byte*>(array.data());
  const auto size = static_cast<py::ssize_t>(array.bytes().size());
  py::list parts;
  for (py::ssize_t at = 0; at < size; at += kPickledBytes) {
    parts.append(Array(array.owner(), first + at, kElementOf<uint8_t>,
                       {std::min(kPickledBytes, size - at)}));
  }
  return parts;
}

/// An array of that type from arrays of its bytes in order.
Array from_parts(const std::vector<Array>& parts, const std::string& code, Array::Shape shape) {
  const ElementType type = element_type(code);
  size_t size = 0;
  for (const Array& part : parts) size += part.bytes().size();
  const auto joined = run_unlocked(size, [parts, size](const std::atomic<bool>&) {
    std::vector<std::byte> bytes;
    bytes.reserve(size);
    for (const Array& part : parts)
      bytes.insert(bytes.end(), part.bytes().begin(), part.bytes().end());
    return std::make_shared<const std::vector<std::byte>>(std::move(bytes));
  });
  const Array whole(joined, joined->data(), type, std::move(shape));
  if (whole.bytes().size() != size) throw py::value_error("Array: parts of another size");
  return whole;
}

py::tuple reduce(const py::object& self, int protocol) {
  const auto& array = self.cast<const Array&>();
  py::object bytes;
  if (protocol >= 5) {
    bytes = py::module_::import("pickle").attr("PickleBuffer")(self);
  } else if (static_cast<py::ssize_t>(array.bytes().size()) > kPickledBytes) {
    bytes = parts_of(array);
  } else {
    let_others_run();
    bytes = py::bytes(reinterpret_cast<const char*>(array.data()), array.bytes().size());
  }
  return py::make_tuple(py::module_::import("tessera._value").attr("restore_array"),
                        py::make_tuple(bytes, std::string(1, array.type().code), shape_of(array)));
}

}  // namespace

void bind_arrays(py::module_& module) {
  bind_class<Array, std::unique_ptr<Array, EndUnlocked>>(
      module, "Array", py::buffer_protocol(),
      "A read-only array: `numpy.asarray` and `memoryview` share its memory.")
      .def_buffer(buffer_of)
      .def_property_readonly("shape", shape_of, "The length of each axis.")
      .def_property_readonly(
          "format", [](const Array& array) { return std::string(1, array.type().code); },
          "What an element is, as a code of the module `struct`.")
      .def("__len__", length_of)
      .def("__getitem__", item_of)
      .def("__eq__", are_equal, py::is_operator())
      .def("__repr__", show)
      .def("__reduce_ex__", reduce)
      .def("__copy__", [](const py::object& self) { return self; })
      .def("__deepcopy__", [](const py::object& self, const py::object&) { return self; })
      .def_static("of", from_list, "An array of the numbers in a list.")
      .def_static("from_bytes", from_bytes, "An array of the bytes of a buffer.")
      .def_static("_from_parts", from_parts);
}

}  // namespace tessera
