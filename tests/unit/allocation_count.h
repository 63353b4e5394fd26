#pragma once

#include <cstddef>

namespace tessera {

/// How often the program has taken memory from the heap so far. Linked with it, a program has an
/// operator new that counts.
size_t allocation_count();

}  // namespace tessera
