#pragma once

#include <optional>
#include <vector>

#include "renderer/image/plain/image_answer.h"

namespace tessera {

bool is_png(const std::vector<char>& file);
/// Nothing for palettes, colour keys, other depths than 8 bits, or where libpng as much as
/// warns. `to_srgb`: an embedded colour profile is heeded.
std::optional<ImageAnswer> decode_png(const std::vector<char>& file, bool to_srgb);
/// Nothing for another format than PNG.
std::optional<ImageAnswer> encode_png(const ImageRequest& request, const std::vector<char>& pixels);

}  // namespace tessera
