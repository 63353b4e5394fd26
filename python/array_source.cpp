#include "python/array_source.h"

#include <fmt/format.h>

#include <cctype>
#include <optional>

#include "python/errors.h"
#include "python/gil.h"

namespace py = pybind11;

namespace tessera {
namespace {

/// Lets go of a buffer from any thread.
struct HeldBuffer {
  Py_buffer view{};
  HeldBuffer() = default;
  HeldBuffer(const HeldBuffer&) = delete;
  HeldBuffer& operator=(const HeldBuffer&) = delete;
  ~HeldBuffer() {
    if (!Py_IsInitialized()) return;
    const GilAcquire locked;
    PyBuffer_Release(&view);
  }
};

/// The kind of numbers of a format of the module `struct`; nothing: no single number.
std::optional<char> kind_of(std::string_view code) {
  if (code.size() != 1) return std::nullopt;
  constexpr std::string_view kFloats = "efd", kSigned = "bhilqn", kUnsigned = "BHILQN";
  if (kFloats.find(code[0]) != code.npos) return 'f';
  if (kSigned.find(code[0]) != code.npos) return 'i';
  if (kUnsigned.find(code[0]) != code.npos) return 'u';
  if (code[0] == '?') return '?';
  return std::nullopt;
}

/// Whether nothing on the way from a view to the memory that it shows can be written to. What does
/// not tell whose memory it is may be anybody's.
bool is_frozen(py::handle view) {
  constexpr int kMostViews = 100;
  auto at = py::reinterpret_borrow<py::object>(view);
  for (int i = 0; i < kMostViews; ++i) {
    if (!PyObject_CheckBuffer(at.ptr())) return false;
    const auto memory = py::reinterpret_steal<py::object>(PyMemoryView_FromObject(at.ptr()));
    if (!memory) throw py::error_already_set();
    if (!PyMemoryView_GET_BUFFER(memory.ptr())->readonly) return false;
    at = py::getattr(at, PyMemoryView_Check(at.ptr()) ? "obj" : "base", py::none());
    if (at.is_none()) return true;
  }
  return false;
}

/// The strides in bytes of an array in C order without gaps.
Array::Shape contiguous_strides(const Array::Shape& shape, py::ssize_t item_size) {
  Array::Shape strides(shape.size());
  py::ssize_t stride = item_size;
  for (size_t axis = shape.size(); axis-- > 0; stride *= shape[axis]) strides[axis] = stride;
  return strides;
}

}  // namespace

bool is_boolean(py::handle value) {
  // As numpy 1 and 2 name theirs.
  const std::string_view type = Py_TYPE(value.ptr())->tp_name;
  return PyBool_Check(value.ptr()) || type == "numpy.bool_" || type == "numpy.bool";
}

bool has_masked(py::handle given) {
  const PyTypeObject* type = Py_TYPE(given.ptr());
  for (const PyTypeObject* plain : {&PyFloat_Type, &PyLong_Type, &PyTuple_Type, &PyList_Type})
    if (type == plain) return false;  // without the slow look for an attribute
  if (!py::hasattr(given, "filled")) return false;
  const py::object mask = py::getattr(given, "mask", py::none());
  return py::hasattr(mask, "any") && py::bool_(mask.attr("any")());
}

void refuse_masked(py::handle given, const std::string& name) {
  if (has_masked(given))
    throw py::value_error(fmt::format("{}: {}; expected {}", name, kMasked[0], kMasked[1]));
}

namespace {

ArraySource from_buffer(py::handle given, const std::string& name) {
  auto held = std::make_shared<HeldBuffer>();
  if (PyObject_GetBuffer(given.ptr(), &held->view, PyBUF_RECORDS_RO)) {
    if (!PyErr_ExceptionMatches(PyExc_BufferError) && !PyErr_ExceptionMatches(PyExc_ValueError))
      throw py::error_already_set();
    PyErr_Clear();
    throw py::type_error(fmt::format("{}: {} without strides; expected an array of numbers", name,
                                     with_article(Py_TYPE(given.ptr())->tp_name)));
  }
  const Py_buffer& view = held->view;
  std::string_view format = view.format ? view.format : "B";
  ArraySource source;
  if (!format.empty() && std::string_view("@=<>!").find(format[0]) != format.npos) {
    source.swapped = (format[0] == '>' || format[0] == '!') && view.itemsize > 1;
    format.remove_prefix(1);
  }
  const auto kind = kind_of(format);
  if (!kind || view.suboffsets) {
    throw py::type_error(
        fmt::format("{}: elements of format '{}'; expected float32, float64 or an "
                    "integer type",
                    name, view.format ? view.format : "B"));
  }
  source.kind = *kind;
  source.data = static_cast<const std::byte*>(view.buf);
  source.item_size = view.itemsize;
  source.read_only = view.readonly && is_frozen(given);
  source.shape.assign(view.shape, view.shape + view.ndim);
  if (view.strides) {
    source.strides.assign(view.strides, view.strides + view.ndim);
  } else {  // as ctypes leaves it out although it was asked for: in C order without gaps
    source.strides = contiguous_strides(source.shape, view.itemsize);
  }
  source.owner = std::move(held);
  return source;
}

/// The numbers of nested sequences, and how many there are along each axis.
class Flattener {
 public:
  explicit Flattener(const std::string& name) : name_(name) {}

  ArraySource take(py::handle given) {
    add(given, 0);
    ArraySource source;
    source.shape = shape_;
    source.read_only = false;
    if (all_boolean_ && complete_) {
      const auto kept =
          std::make_shared<const std::vector<uint8_t>>(numbers_.begin(), numbers_.end());
      source.data = reinterpret_cast<const std::byte*>(kept->data());
      source.kind = '?';
      source.item_size = 1;
      source.owner = kept;
    } else if (all_whole_) {
      const auto kept = std::make_shared<const std::vector<int64_t>>(std::move(whole_));
      source.data = reinterpret_cast<const std::byte*>(kept->data());
      source.kind = 'i';
      source.owner = kept;
    } else {
      const auto kept = std::make_shared<const std::vector<double>>(std::move(numbers_));
      source.data = reinterpret_cast<const std::byte*>(kept->data());
      source.owner = kept;
      source.is_huge = is_huge_;
    }
    source.strides = contiguous_strides(shape_, source.item_size);
    return source;
  }

 private:
  static constexpr size_t kMostAxes = 8;

  void add(py::handle given, size_t axis) {
    refuse_masked(given, name_);
    const bool is_sequence = PySequence_Check(given.ptr()) && !PyUnicode_Check(given.ptr()) &&
                             !PyBytes_Check(given.ptr());
    if (!is_sequence) return add_number(given, axis);
    if (axis >= kMostAxes)
      throw py::value_error(name_ + ": sequences inside sequences without end");
    const auto items = py::reinterpret_steal<py::object>(PySequence_Fast(given.ptr(), ""));
    if (!items) throw py::error_already_set();
    const py::ssize_t count = PySequence_Fast_GET_SIZE(items.ptr());
    if (shape_.size() == axis && !complete_) {
      shape_.push_back(count);
    } else if (shape_.size() <= axis || shape_[axis] != count) {
      throw py::value_error(
          fmt::format("{}: rows of different lengths ({} and {}); expected an array", name_,
                      shape_.size() > axis ? shape_[axis] : 1, count));
    }
    for (py::ssize_t i = 0; i < count; ++i) {
      if (i >= PySequence_Fast_GET_SIZE(items.ptr())) {
        throw py::value_error(
            fmt::format("{}: a sequence that shrank from {} to {} while it was read; expected an "
                        "array",
                        name_, count, PySequence_Fast_GET_SIZE(items.ptr())));
      }
      add(py::reinterpret_borrow<py::object>(PySequence_Fast_GET_ITEM(items.ptr(), i)), axis + 1);
    }
  }

  void add_number(py::handle given, size_t axis) {
    complete_ = true;
    if (axis != shape_.size()) {
      throw py::value_error(name_ + ": a number beside rows; expected an array");
    }
    const double number = PyFloat_AsDouble(given.ptr());
    if (number == -1 && PyErr_Occurred()) {
      refuse_overflow(name_);
      if (!PyErr_ExceptionMatches(PyExc_TypeError)) throw py::error_already_set();
      PyErr_Clear();
      throw py::type_error(fmt::format("{}: {}; expected numbers", name_,
                                       with_article(Py_TYPE(given.ptr())->tp_name)));
    }
    numbers_.push_back(number);
    const bool boolean = is_boolean(given);
    all_boolean_ = all_boolean_ && boolean;
    if (!all_whole_) return;
    if (boolean) return whole_.push_back(number != 0);
    int overflow = 0;
    // Those of numpy are whole numbers too.
    const auto index = py::reinterpret_steal<py::object>(
        PyIndex_Check(given.ptr()) ? PyNumber_Index(given.ptr()) : nullptr);
    if (!index && PyErr_Occurred()) throw py::error_already_set();
    whole_.push_back(index ? PyLong_AsLongLongAndOverflow(index.ptr(), &overflow) : 0);
    all_whole_ = index && !overflow;
    is_huge_ = overflow != 0;
  }

  const std::string& name_;
  Array::Shape shape_;
  bool complete_ = false;  ///< a number was met, so that the number of axes is known
  bool all_boolean_ = true;
  bool all_whole_ = true;
  bool is_huge_ = false;  ///< the first that is none of `whole_` is a whole number
  std::vector<double> numbers_;
  std::vector<int64_t> whole_;
};

}  // namespace

py::ssize_t ArraySource::count() const {
  py::ssize_t product = 1;
  for (const py::ssize_t length : shape) product *= length;
  return product;
}

bool ArraySource::is_contiguous() const {
  py::ssize_t stride = item_size;
  for (size_t axis = shape.size(); axis-- > 0; stride *= shape[axis]) {
    if (shape[axis] == 0) return true;
    if (shape[axis] != 1 && strides[axis] != stride) return false;
  }
  return true;
}

bool ArraySource::is_plain(ElementType type) const {
  const char wanted = *kind_of(std::string_view(&type.code, 1));
  return kind == wanted && item_size == type.size && !swapped && is_contiguous();
}

ArraySource array_source(py::handle given, const std::string& name) {
  if (PyObject_CheckBuffer(given.ptr()) && !PyBytes_Check(given.ptr())) {
    refuse_masked(given, name);
    return from_buffer(given, name);
  }
  if (!PyType_Check(given.ptr()) && py::hasattr(given, "__array__")) {
    const py::object array = given.attr("__array__")();
    if (PyObject_CheckBuffer(array.ptr())) return from_buffer(array, name);
  }
  if (PySequence_Check(given.ptr()) && !PyUnicode_Check(given.ptr()) &&
      !PyBytes_Check(given.ptr())) {
    return Flattener(name).take(given);
  }
  throw py::type_error(fmt::format("{}: {}; expected an array of numbers", name,
                                   with_article(Py_TYPE(given.ptr())->tp_name)));
}

std::string shape_text(const Array::Shape& shape) {
  return fmt::format("({}{})", fmt::join(shape, ", "), shape.size() == 1 ? "," : "");
}

void wrong_shape(const std::string& name, const Array::Shape& found, const std::string& expected) {
  throw py::value_error(
      fmt::format("{}: shape {}; expected {}", name, shape_text(found), expected));
}

}  // namespace tessera
