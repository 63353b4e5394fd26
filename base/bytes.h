#pragma once

#include <cstddef>
#include <memory>
#include <utility>
#include <vector>

namespace tessera {

/// Leaves what a vector is resized to as it lies in memory: for numbers that are written at once.
template <typename T>
class Unfilled : public std::allocator<T> {
 public:
  template <typename Other>
  struct rebind {
    using other = Unfilled<Other>;
  };
  template <typename Other>
  void construct(Other* place) noexcept {
    ::new (static_cast<void*>(place)) Other;
  }
  template <typename Other, typename... Arguments>
  void construct(Other* place, Arguments&&... arguments) {
    std::construct_at(place, std::forward<Arguments>(arguments)...);
  }
};

/// Bytes that travel; new ones are of no value until they are written.
using Bytes = std::vector<std::byte, Unfilled<std::byte>>;

}  // namespace tessera
