#pragma once

#include <optional>
#include <span>

#include "image/plain/image_answer.h"

namespace tessera {

/// Reads the part of OpenEXR whose name and channels fit a picture best, as where a depth map or a
/// pass of light comes first: its colours and coverage, or with `all` every channel. Throws
/// std::exception where libOpenEXR cannot read it, or it holds no flat picture.
ImageAnswer decode_exr(std::span<const char> file, bool all);
/// Writes scanlines of floats, compressed by ZIP. Nothing for another format than OpenEXR.
std::optional<ImageAnswer> encode_exr(const ImageRequest& request, std::span<const char> pixels);

}  // namespace tessera
