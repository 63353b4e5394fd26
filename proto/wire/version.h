#pragma once

#include <cstdint>

namespace tessera {

/// Processes talk only where the major numbers are equal; a minor one only adds.
inline constexpr uint32_t kProtocolMajor = 6;
inline constexpr uint32_t kProtocolMinor = 0;
/// Names the arithmetic that pixels come from: changes whenever any pixel may.
inline constexpr char kNumericsId[] = "ieee754-strict-20";

}  // namespace tessera
