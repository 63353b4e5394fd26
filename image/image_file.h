#pragma once

#include <cstdint>
#include <filesystem>
#include <string>
#include <string_view>
#include <vector>

#include "base/blob.h"
#include "renderer/film/film.h"
#include "renderer/film/tone_map.h"
#include "renderer/math/stored_samples.h"

namespace tessera {

/// What an image file tells of its making, where its format has room for it: nothing that is
/// another when the same picture is made again, so that neither is the file.
struct ImageMetadata {
  std::string scene_digest;
  uint32_t seed = 0;
  uint32_t samples_per_pixel = 0;
  std::string denoiser{};  ///< empty: its light is as it was traced
  std::string colors{};    ///< what the scene's numbers stand for: "scene-linear" or "display"
  /// Of the whole frame, where the film may be a crop of it; 0: it is not. EXR and TIFF tell it.
  int frame_width = 0, frame_height = 0;
};

/// A picture read back: rows from the top, for each pixel a float of each channel, numbers as the
/// file has them (integers divided by their largest value, no transfer curve undone). Of OpenEXR
/// the pixels in the display window, those of the crop if it was one.
struct FloatImage {
  int width = 0, height = 0;
  std::vector<std::string> channels;  ///< their names, at least one
  std::vector<float> values;
  SampleMeaning meaning{};  ///< of its colours
  std::string part_note{};  ///< which part of OpenEXR it is, where that is not the first
};

/// Red, green and blue of the picture as linear light: what it shows before black, so that alpha
/// tells as much whether or not the file has its colours multiplied by it.
std::vector<float> linear_light(const FloatImage& image);

/// The colour and coverage of a picture (color_channels_of()) as textures hold them: rows from the
/// top, tightly packed, numbers as the file has them.
struct TextureImage {
  uint32_t width = 0, height = 0;
  uint32_t channels = 0;  ///< 1 grey, 2 grey and alpha, 3 RGB, 4 RGBA
  uint32_t bits = 0;      ///< 8, 16 (half float) or 32 (float, or an integer by its largest value)
  BlobData texels;
  SampleMeaning meaning{};
  std::vector<std::string> unused_channels{};  ///< names of the file's other channels
  std::string part_note{};  ///< which part of OpenEXR it is, where that is not the first
  /// What is wrong with the data of a JPEG file that was read as far as it goes; empty: nothing.
  std::string damage{};
  /// The exponent that a PNG says made its codes of light, where that is not about sRGB's; else 0.
  float gamma = 0;
};

/// Starts what `path` will be encoded by (ImageCodec) without waiting for it. May be called from
/// any thread, often, or never.
void prepare_to_write(const std::filesystem::path& path);
/// Whether that takes but a few milliseconds, and little memory.
bool is_quickly_prepared(const std::filesystem::path& path);

/// Whether a picture to `path` goes to standard output: "-" for PNG, or "-.exr" and the like.
bool is_standard_output(const std::filesystem::path& path);

/// Throws a usage error now for what write_image could not do later: an ending that is no format, a
/// folder that is missing or not writable, a path that is no regular file, standard output where it
/// is a terminal. Leaves nothing behind.
void check_writable(const std::filesystem::path& path);

/// Throws a usage error where $OCIO names no configuration that can be read, or none that knows the
/// names.
void check_color_management(const ColorManagement& names);

/// The film's light as to_8_bit() makes it, or as its colour management does. Throws a render error
/// where that fails, as for names that check_color_management() refuses.
std::vector<uint8_t> shown_bytes(const Film& film, const OutputSettings& settings);

/// Whether what is beside light has a place in the format that the ending names.
bool holds_aovs(const std::filesystem::path& path);

/// Whether the format that the ending names takes any number.
bool holds_floats(const std::filesystem::path& path);

/// Throws a usage error where the settings ask for more bits than the format of integers has that
/// the ending names: PNG and TIFF have 16.
void check_bits(const std::filesystem::path& path, const OutputSettings& settings);

/// Throws a usage error where alpha is among them and the format that the ending names has none.
void check_alpha(const std::filesystem::path& path, AovSet aovs);

/// Writes the format that the ending names: exr, hdr and pfm take the linear values, every other
/// one is made integers by `settings`. What is beside light goes where holds_aovs(). Colours are
/// multiplied by alpha in files of floats, and are not in others. It is encoded
/// in memory, then goes through write_picture. Throws a render error where either fails.
void write_image(const std::filesystem::path& path, const Film& film,
                 const OutputSettings& settings, const ImageMetadata& metadata);

/// Writes the bytes of a picture's file to `path`, by write_output_file, or to standard output.
void write_picture(const std::filesystem::path& path, std::string_view bytes);

/// The bytes of the file that write_image would write to `path`.
std::string encode_image(const std::filesystem::path& path, const Film& film,
                         const OutputSettings& settings, const ImageMetadata& metadata);

/// All channels of the first picture in a file, whose format its content tells (image_format.h),
/// not its name. Throws a scene error.
FloatImage read_image(const std::filesystem::path& path);
/// Its colour and coverage, without loss; of OpenEXR the display window. Throws a scene error.
/// `to_srgb`: colours of 8 bits are taken from an embedded colour profile to sRGB.
TextureImage read_texture_image(const std::filesystem::path& path, bool to_srgb = false);
/// The same of a file in memory, which errors call `name`.
TextureImage decode_texture_image(const std::string& name, std::string_view file);

}  // namespace tessera
