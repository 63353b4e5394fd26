#pragma once

#include <optional>
#include <span>

#include "image/plain/image_answer.h"

namespace tessera {

/// Decodes P1 to P6: each sample is divided by the largest value that the file names, which
/// OpenImageIO 2.4 rounds down to 8 or 16 bits and, above 32,768, overflows by. Samples are 8 bits
/// wide where that value divides 255, else floats. Names the channels Y, or R, G and B, where
/// `names_channels`. Nothing for PFM and for what is damaged.
std::optional<ImageAnswer> decode_pnm(std::span<const char> file, bool names_channels);

}  // namespace tessera
