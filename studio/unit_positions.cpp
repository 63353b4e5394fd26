#include "studio/unit_positions.h"

#include <algorithm>
#include <utility>

namespace tessera {

UnitPositions::UnitPositions(std::string_view text, std::vector<uint32_t> bytes)
    : bytes_(std::move(bytes)) {
  std::sort(bytes_.begin(), bytes_.end());
  bytes_.erase(std::unique(bytes_.begin(), bytes_.end()), bytes_.end());
  positions_.reserve(bytes_.size());
  Position now;
  size_t at = 0, line_begin = 0;
  for (const uint32_t byte : bytes_) {
    for (; at < std::min<size_t>(byte, text.size()); ++at) {
      const auto c = static_cast<unsigned char>(text[at]);
      const bool continues = (c & 0xc0) == 0x80;
      // Four bytes of UTF-8 are two code units of UTF-16, fewer are one.
      now.offset += continues ? 0 : c >= 0xf0 ? 2 : 1;
      if (c != '\n') continue;
      ++now.line;
      line_begin = now.offset;
    }
    now.column = now.offset - line_begin + 1;
    positions_.push_back(now);
  }
}

const UnitPositions::Position& UnitPositions::at(uint32_t byte) const {
  const auto found = std::lower_bound(bytes_.begin(), bytes_.end(), byte);
  return positions_[static_cast<size_t>(found - bytes_.begin())];
}

}  // namespace tessera
