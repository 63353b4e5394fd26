#pragma once

#include <sys/mman.h>

#include <cstddef>
#include <cstdint>

namespace tessera {

inline constexpr size_t kHugePageBytes = size_t{2} << 20;

/// Asks for memory that was not touched yet in pages of 2 MiB, as far as it has whole ones: to be
/// given a large array page by page may take longer than to fill it. Changes nothing where the
/// system has none.
inline void prefer_huge_pages(void* data, size_t size) {
  const auto begin = reinterpret_cast<uintptr_t>(data);
  const uintptr_t first = (begin + kHugePageBytes - 1) / kHugePageBytes * kHugePageBytes;
  const uintptr_t last = (begin + size) / kHugePageBytes * kHugePageBytes;
  if (first < last) madvise(reinterpret_cast<void*>(first), last - first, MADV_HUGEPAGE);
}

}  // namespace tessera
