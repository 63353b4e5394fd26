#pragma once

#include <string>
#include <vector>

#include "scenes/import/loaded_scene.h"

namespace tessera {

/// How the numbers of a picture's file are encoded. What Image.encoding does not say goes by the
/// type of the numbers.
SampleEncoding sample_encoding(const v1::Texture::Image& image);

/// Says that integers are encoded so, as an importer does whose format means its pictures so. Says
/// nothing of floats, which are light.
void set_integer_encoding(v1::Texture::Image::Encoding encoding, v1::Texture::Image& image);

/// Makes linear floats of a picture that the renderer could not decode: of codes of more than 8
/// bits, and of integers with associated alpha. Codes of 8 bits stay as they are.
void decode_picture(DecodedTexture& picture, SampleEncoding encoding);

/// Makes every number of a picture finite, as light has to be: infinity becomes the largest that
/// half floats hold, 65504; what is no number, and less than any light, becomes 0. Returns what to
/// warn of, with the first pixel; empty where there was nothing.
std::string mend_numbers(DecodedTexture& picture);

/// What to warn of a picture.
struct PictureNote {
  std::string what;
  bool is_repair = false;  ///< something that is wrong with its file was mended
};

/// Both of these, for a picture as its file has it. Returns what to warn of: damage and numbers
/// that were mended, and where it is read otherwise than the file says: another part than the
/// first, or codes of another gamma than sRGB's, which is not followed.
std::vector<PictureNote> prepare_picture(DecodedTexture& picture, SampleEncoding encoding);

}  // namespace tessera
