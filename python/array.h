#pragma once

#include <pybind11/pybind11.h>

#include <cstddef>
#include <cstdint>
#include <functional>
#include <memory>
#include <numeric>
#include <span>
#include <string>
#include <utility>
#include <vector>

#include "base/blob.h"
#include "base/digest.h"

namespace tessera {

/// What an element of an array is: a code of Python's `struct` ('f', 'd', 'i', 'I', 'q', 'Q', 'B',
/// 'e' for half floats, '?' for bool ...), in this machine's byte order.
struct ElementType {
  char code = 'd';
  pybind11::ssize_t size = 8;
};
template <class T>
inline constexpr ElementType kElementOf{};
template <>
inline constexpr ElementType kElementOf<double>{'d', 8};
template <>
inline constexpr ElementType kElementOf<float>{'f', 4};
template <>
inline constexpr ElementType kElementOf<int32_t>{'i', 4};
template <>
inline constexpr ElementType kElementOf<uint32_t>{'I', 4};
template <>
inline constexpr ElementType kElementOf<int64_t>{'q', 8};
template <>
inline constexpr ElementType kElementOf<uint8_t>{'B', 1};
template <>
inline constexpr ElementType kElementOf<bool>{'?', 1};

/// `tessera._core.Array`: a read-only array of any number of dimensions, in C order, over memory
/// that its owner keeps. Python reads it through the buffer protocol, so that `numpy.asarray` makes
/// no copy.
class Array {
 public:
  using Shape = std::vector<pybind11::ssize_t>;
  Array(std::shared_ptr<const void> owner, const void* data, ElementType type, Shape shape)
      : owner_(std::move(owner)), data_(data), type_(type), shape_(std::move(shape)) {}
  template <class T>
  Array(std::vector<T> elements, Shape shape) : type_(kElementOf<T>), shape_(std::move(shape)) {
    auto kept = std::make_shared<const std::vector<T>>(std::move(elements));
    data_ = kept->data();
    owner_ = std::move(kept);
  }

  const void* data() const { return data_; }
  ElementType type() const { return type_; }
  const Shape& shape() const { return shape_; }
  pybind11::ssize_t count() const {
    return std::accumulate(shape_.begin(), shape_.end(), pybind11::ssize_t{1}, std::multiplies<>());
  }
  std::span<const std::byte> bytes() const {
    return {static_cast<const std::byte*>(data_), static_cast<size_t>(count() * type_.size)};
  }
  const std::shared_ptr<const void>& owner() const { return owner_; }
  /// The blob of these bytes and its digest, which blob_of() computes at its first call.
  std::pair<Digest, BlobData>& blob() const { return blob_; }

 private:
  std::shared_ptr<const void> owner_;
  const void* data_ = nullptr;
  ElementType type_;
  Shape shape_;
  mutable std::pair<Digest, BlobData> blob_;
};

}  // namespace tessera
