#pragma once

#include <pybind11/pybind11.h>

#include <algorithm>
#include <atomic>
#include <cstdint>
#include <cstring>
#include <functional>
#include <memory>
#include <string>
#include <vector>

#include "python/array.h"
#include "renderer/math/encodings.h"

namespace tessera {

/// An array as Python handed it over: of any numbers, byte order and strides. Keeps its memory.
struct ArraySource {
  std::shared_ptr<const void> owner;  ///< may be let go of without the GIL
  const std::byte* data = nullptr;
  Array::Shape shape, strides;  ///< strides in bytes
  char kind = 'f';              ///< 'f', 'i', 'u' or '?'
  pybind11::ssize_t item_size = 8;
  bool swapped = false;    ///< the other byte order
  bool is_huge = false;    ///< doubles: one was a whole number beyond 64 bits
  bool read_only = false;  ///< nor can what it is a view of be written to

  pybind11::ssize_t count() const;
  /// In C order without gaps.
  bool is_contiguous() const;
  /// In C order, of this machine's byte order and of that type.
  bool is_plain(ElementType type) const;
};

/// Whether it is True or False, of Python or of numpy. Needs the GIL.
bool is_boolean(pybind11::handle value);
/// What is said of masked values: found, and expected.
inline constexpr const char* kMasked[] = {"masked values", "none, as in the array's filled()"};
/// Whether it is an array of numpy.ma with masked values, which its buffer does not tell, or
/// numpy.ma.masked itself, which converts to a number. Needs the GIL.
bool has_masked(pybind11::handle given);
/// Throws ValueError where it has.
void refuse_masked(pybind11::handle given, const std::string& name);

/// Takes whatever has the buffer protocol, `__array__`, or is a sequence of sequences of numbers.
/// `name` begins the message where it is none of these: TypeError, or ValueError for rows of
/// different lengths. Needs the GIL.
ArraySource array_source(pybind11::handle given, const std::string& name);

/// "(8, 3)", for messages.
std::string shape_text(const Array::Shape& shape);

/// "normals: shape (4, 3); expected (8, 3), one a vertex".
[[noreturn]] void wrong_shape(const std::string& name, const Array::Shape& found,
                              const std::string& expected);

/// Calls `use(value of To)` for `count` elements from number `first` on, in C order. Floats of any
/// width and integers become To as a cast does. Does not need the GIL.
template <class To, class Use>
void for_each_element(const ArraySource& source, pybind11::ssize_t first, pybind11::ssize_t count,
                      Use use);

/// The same for all elements, or for some where `stop` becomes true meanwhile.
template <class To, class Use>
void for_each_element(const ArraySource& source, const std::atomic<bool>& stop, Use use) {
  constexpr pybind11::ssize_t kAtOnce = 1 << 16;
  for (pybind11::ssize_t at = 0; at < source.count() && !stop; at += kAtOnce) {
    for_each_element<To>(source, at, std::min(kAtOnce, source.count() - at), std::ref(use));
  }
}

namespace detail {

template <class From, bool kSwapped>
From load(const std::byte* at) {
  std::byte bytes[sizeof(From)];
  std::memcpy(bytes, at, sizeof bytes);
  if constexpr (kSwapped) std::ranges::reverse(bytes);
  From value;
  std::memcpy(&value, bytes, sizeof value);
  return value;
}

struct Half {
  uint16_t bits;
};
template <class To, class From>
To as(From value) {
  if constexpr (std::is_same_v<From, Half>) {
    return static_cast<To>(half_to_float(value.bits));
  } else {
    return static_cast<To>(value);
  }
}

template <class To, class From, bool kSwapped, class Use>
void walk(const ArraySource& source, pybind11::ssize_t first, pybind11::ssize_t count, Use& use) {
  const std::byte* at = source.data;
  if (source.is_contiguous()) {
    at += first * source.item_size;
    for (pybind11::ssize_t i = 0; i < count; ++i, at += sizeof(From)) {
      use(as<To>(load<From, kSwapped>(at)));
    }
    return;
  }
  // The index along each axis; the last runs fastest.
  Array::Shape index(source.shape.size());
  for (size_t axis = index.size(); axis-- > 0; first /= source.shape[axis]) {
    index[axis] = first % source.shape[axis];
    at += index[axis] * source.strides[axis];
  }
  for (pybind11::ssize_t i = 0; i < count; ++i) {
    use(as<To>(load<From, kSwapped>(at)));
    for (size_t axis = index.size(); axis-- > 0;) {
      at += source.strides[axis];
      if (++index[axis] < source.shape[axis]) break;
      at -= source.shape[axis] * source.strides[axis];
      index[axis] = 0;
    }
  }
}

template <class To, class From, class Use>
void walk_ordered(const ArraySource& source, pybind11::ssize_t first, pybind11::ssize_t count,
                  Use& use) {
  if (source.swapped) {
    walk<To, From, true>(source, first, count, use);
  } else {
    walk<To, From, false>(source, first, count, use);
  }
}

}  // namespace detail

template <class To, class Use>
void for_each_element(const ArraySource& source, pybind11::ssize_t first, pybind11::ssize_t count,
                      Use use) {
  using namespace detail;
  if (count <= 0) return;
  switch (source.kind == 'f' ? -source.item_size
                             : source.item_size + (source.kind == 'i' ? 10 : 0)) {
    case -2:
      return walk_ordered<To, Half>(source, first, count, use);
    case -4:
      return walk_ordered<To, float>(source, first, count, use);
    case -8:
      return walk_ordered<To, double>(source, first, count, use);
    case 1:
      return walk_ordered<To, uint8_t>(source, first, count, use);
    case 2:
      return walk_ordered<To, uint16_t>(source, first, count, use);
    case 4:
      return walk_ordered<To, uint32_t>(source, first, count, use);
    case 8:
      return walk_ordered<To, uint64_t>(source, first, count, use);
    case 11:
      return walk_ordered<To, int8_t>(source, first, count, use);
    case 12:
      return walk_ordered<To, int16_t>(source, first, count, use);
    case 14:
      return walk_ordered<To, int32_t>(source, first, count, use);
    default:
      return walk_ordered<To, int64_t>(source, first, count, use);
  }
}

}  // namespace tessera
