#pragma once

#include <cstddef>
#include <type_traits>

namespace tessera {

/// Room for values that are made when they are assigned: to make many of them first takes time that
/// shows where they are of no more use than to be replaced.
template <typename Value, size_t kCount>
class Uninitialized {
  static_assert(std::is_trivially_copyable_v<Value>);

 public:
  Uninitialized() {}  // NOLINT(modernize-use-equals-default): that would be deleted
  Value& operator[](size_t i) { return values_[i]; }
  const Value& operator[](size_t i) const { return values_[i]; }
  Value* data() { return values_; }
  const Value* data() const { return values_; }

 private:
  union {
    Value values_[kCount];
  };
};

}  // namespace tessera
