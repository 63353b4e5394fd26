#pragma once

#include <optional>
#include <span>

#include "image/plain/image_answer.h"

namespace tessera {

/// Nothing for a picture that is neither grey nor YCbCr or RGB, or where libjpeg as much as warns.
/// `to_srgb`: an embedded colour profile is heeded.
std::optional<ImageAnswer> decode_jpeg(std::span<const char> file, bool to_srgb);

}  // namespace tessera
