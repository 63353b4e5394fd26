#pragma once

#include <array>
#include <optional>
#include <string>

#include "proto/tessera/v1/scene.pb.h"
#include "scenes/formats/obj/line_reader.h"
#include "scenes/import/warnings.h"

namespace tessera {

/// What printing and reading again may make of 0 and 1; less than anyone sees.
inline constexpr double kMtlRounding = 1e-5;

/// What a map statement of an MTL file says: options, then the name of a picture.
struct MtlMap {
  std::string file;  ///< as written, in UTF-8, with forward slashes
  std::array<double, 3> scale{1, 1, 1};
  std::array<double, 3> offset{};
  bool clamp = false;
  double multiplier = 1;                           ///< -bm
  double gain = 1;                                 ///< -mm
  std::optional<v1::FloatInput::Channel> channel;  ///< -imfchan r, g, b or m
  bool luminance = false;                          ///< -imfchan l
  std::optional<v1::Texture::Image::Encoding> encoding;
};

/// Reads the rest of the line after `keyword`. Options that change no number that we look up are
/// counted in `warnings`. Throws scene_error with the place.
MtlMap read_mtl_map(LineReader& reader, const std::string& keyword, Warnings& warnings);

}  // namespace tessera
