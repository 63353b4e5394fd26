#pragma once

#include <cstdint>

namespace tessera {

/// Who is connected; never used twice.
using ClientId = uint64_t;

}  // namespace tessera
