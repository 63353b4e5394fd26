#pragma once

#include <cstddef>
#include <cstdint>
#include <span>

namespace tessera {

/// CRC-32C (Castagnoli; RFC 3720, B.4): finds damage on the way, not malice. Some 20 GB/s on x86.
uint32_t crc32c(std::span<const std::byte> data);

}  // namespace tessera
