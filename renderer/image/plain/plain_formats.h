#pragma once

#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "renderer/image/plain/image_answer.h"

namespace tessera {

/// What an image tells of its making, as names and texts; the last two are "Software" and
/// "Description", which is all the others.
std::vector<std::pair<std::string, std::string>> image_texts(const ImageAttributes& attributes);

/// Answers the most common requests with libpng and libjpeg alone, which load at once: writing PNG,
/// and reading JPEG and PNG of 8 bits. Pixels are what OpenImageIO would give. Nothing where it
/// takes more, or something is wrong with the file: that is for OpenImageIO to tell.
std::optional<ImageAnswer> answer_plainly(const ImageRequest& request,
                                          const std::vector<char>& payload);

}  // namespace tessera
