#pragma once

#include "scenes/import/loaded_scene.h"

namespace tessera {

/// Leaves of a picture the one number of each texel that `channel` asks for. A picture of that one
/// number already is left as it is. Luminance weighs red, green and blue by .2126, .7152 and .0722
/// (Rec. ITU-R BT.709): the numbers as they are, or, where `is_srgb`, the light that 8-bit codes
/// stand for, which is then held as half floats. Numbers with associated alpha are divided by it.
void keep_channel(DecodedTexture& texture, PictureChannel channel, bool is_srgb);

}  // namespace tessera
