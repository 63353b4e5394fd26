#pragma once

#include <optional>
#include <span>
#include <string>
#include <utility>
#include <vector>

#include "image/plain/image_answer.h"

namespace tessera {

/// What an image tells of its making, as names and texts; the last two are "Software" and
/// "Description", which is all the others.
std::vector<std::pair<std::string, std::string>> image_texts(const ImageAttributes& attributes);

/// Answers the most common requests with libraries that load at once: reads and writes PNG of 8
/// bits by libpng and OpenEXR by libOpenEXR, and reads JPEG by libjpeg, and PNM. `bytes` are the
/// pixels to encode or the file to decode. Pixels are those that OpenImageIO would give, but for
/// PNM (decode_pnm()) and OpenEXR (decode_exr()). Returns nullopt where that takes more, or where
/// something is wrong with the file, which OpenImageIO then tells. Throws for a wrong OpenEXR file.
std::optional<ImageAnswer> answer_plainly(const ImageRequest& request, std::span<const char> bytes);

}  // namespace tessera
