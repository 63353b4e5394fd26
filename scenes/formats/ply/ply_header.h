#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "scenes/import/warnings.h"

namespace tessera {

enum class PlyType : uint8_t { int8, uint8, int16, uint16, int32, uint32, float32, float64 };

/// Bytes of a value in the binary encodings.
size_t ply_size(PlyType type);

struct PlyProperty {
  std::string name;
  PlyType type = PlyType::float32;
  std::optional<PlyType> count_type;  ///< a list: this many values follow a count of that type
};

struct PlyElement {
  std::string name;
  uint64_t count = 0;
  std::vector<PlyProperty> properties;
};

struct PlyHeader {
  enum class Encoding { ascii, little_endian, big_endian };
  Encoding encoding = Encoding::ascii;
  std::vector<PlyElement> elements;
  std::string texture_file;   ///< of a line "comment TextureFile NAME", as scanners write
  SourcePlace texture_place;  ///< of that line
  size_t data_begin = 0;      ///< the byte after the header

  /// How many rows all elements have that have any properties.
  uint64_t row_count() const;
};

/// Reads the header of a PLY file (Turk 1994). No element's count is more than one above what the
/// bytes that follow can hold. A line that is none of a header's is left out with a warning.
/// Throws scene_error with the place of what nothing can be read without.
PlyHeader read_ply_header(std::string_view bytes, const std::string& name, Warnings& warnings);

}  // namespace tessera
