#pragma once

#include <cstdint>
#include <string_view>
#include <vector>

namespace tessera {

/// Where bytes of a text with \n alone are in UTF-16 code units. Made by one pass over the text,
/// which is what makes the outline of a large scene cheap.
class UnitPositions {
 public:
  struct Position {
    size_t offset = 0;            ///< from 0
    size_t line = 1, column = 1;  ///< from 1
  };

  /// `bytes`: the offsets that are going to be asked for, in any order.
  UnitPositions(std::string_view text, std::vector<uint32_t> bytes);
  const Position& at(uint32_t byte) const;

 private:
  std::vector<uint32_t> bytes_;
  std::vector<Position> positions_;
};

}  // namespace tessera
