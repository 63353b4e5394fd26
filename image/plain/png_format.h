#pragma once

#include <optional>
#include <span>

#include "image/plain/image_answer.h"

namespace tessera {

/// Nothing for palettes, colour keys, other depths than 8 bits, or where libpng as much as
/// warns. `to_srgb`: an embedded colour profile is heeded.
std::optional<ImageAnswer> decode_png(std::span<const char> file, bool to_srgb);
/// The exponent by which the file says, in a gAMA chunk, that light became its codes; 0 where it
/// does not, where that is about sRGB's, or where an sRGB or iCCP chunk counts in its place (PNG
/// 13.13).
float png_gamma(std::span<const char> file);
/// Nothing for another format than PNG.
std::optional<ImageAnswer> encode_png(const ImageRequest& request, std::span<const char> pixels);

}  // namespace tessera
