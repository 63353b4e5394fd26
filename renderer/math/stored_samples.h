#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <optional>
#include <span>
#include <string>
#include <vector>

namespace tessera {

// What the samples of image files stand for. These functions alone decide which channels of a file
// are colour and coverage, and how its numbers become linear light.

/// The channels of a picture that are its colour and its coverage, as indices into all channels.
struct ColorChannels {
  enum class Kind : uint8_t {
    grey,              ///< one channel
    rgb,               ///< three channels; one that is missing counts as 0
    luminance_chroma,  ///< Y, RY = (R - Y) / Y, BY = (B - Y) / Y, as OpenEXR defines them
  };
  Kind kind = Kind::grey;
  std::array<std::optional<uint32_t>, 3> colors{};
  std::optional<uint32_t> alpha;

  /// Channels of the picture that these make: 1 grey, 2 grey and alpha, 3 RGB, 4 RGBA.
  uint32_t count() const { return (kind == Kind::grey ? 1 : 3) + (alpha ? 1 : 0); }
  /// The channels in the order of that picture.
  std::vector<std::optional<uint32_t>> in_order() const;
};

/// Finds R, G, B and A, or Y, RY and BY, by their names in any order and in upper or lower case.
/// Channels without a layer come before those of a layer ("diffuse.R"). Among layers one called
/// Combined, RGBA or beauty comes first, else the first that has colours. Where no name is known,
/// the first three channels, or the first one of fewer, are the colour. Words count as well: red,
/// green, blue, alpha, grey, gray, I. `names` must not be empty.
ColorChannels color_channels_of(std::span<const std::string> names);

/// How well the colours that color_channels_of() takes fit a picture by their layer's name, the
/// lower the better: 0 no layer, 1 Combined, RGBA or beauty, 2 three colours, 3 others, 4 no name
/// is known as that of a colour.
int color_rank(std::span<const std::string> names);

/// Makes floats of numbers of 8 bits, which are divided by 255, of half floats (16 bits) or of
/// floats (32 bits). `samples` has as many as `floats`.
void samples_to_floats(std::span<const std::byte> samples, uint32_t bits, std::span<float> floats);

/// Makes red, green and blue of the first three of each pixel's `channels` floats, which are Y, RY
/// and BY, with the primaries of Rec. ITU-R BT.709.
void luminance_chroma_to_rgb(std::span<float> pixels, uint32_t channels);

/// How a file means its numbers.
struct SampleMeaning {
  bool from_integers = false;  ///< integers divided by their largest value; else floats
  bool is_associated = false;  ///< colours are multiplied by alpha

  bool operator==(const SampleMeaning&) const = default;
};

/// Which transfer curve the numbers of colours went through.
enum class SampleEncoding : uint8_t {
  automatic,  ///< integers through that of sRGB; floats through none
  srgb,
  linear,
};

/// Whether numbers so encoded are codes of sRGB and not light.
bool holds_codes(SampleMeaning meaning, SampleEncoding encoding);

/// Makes linear light of the colours of pixels with 1 to 4 channels, as ColorChannels::count()
/// tells them, that hold codes; all else stays as it is. Codes with associated alpha are divided
/// by it before they are decoded and multiplied by it afterwards.
void decode_samples(std::span<float> samples, uint32_t channels, SampleMeaning meaning,
                    SampleEncoding encoding);

}  // namespace tessera
