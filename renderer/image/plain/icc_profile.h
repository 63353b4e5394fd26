#pragma once

#include <cstddef>
#include <span>

#include "renderer/image/plain/image_answer.h"

namespace tessera {

/// Turns colours of 8 bits from those of an embedded profile (ICC.1:2010) into sRGB. Knows profiles
/// by matrix and curves, as cameras and painting programs embed them; by any other, by one that is
/// damaged, and by one that is sRGB itself to within a code, nothing changes.
void convert_to_srgb(std::span<const unsigned char> profile, ImageAnswer& picture);

}  // namespace tessera
