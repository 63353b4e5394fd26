#include "image/image_file.h"

#include <fmt/format.h>
#include <unistd.h>

#include <algorithm>
#include <array>
#include <cerrno>
#include <cmath>
#include <cstdlib>
#include <cstring>
#include <limits>
#include <span>

#include "base/core_count.h"
#include "base/error.h"
#include "base/file.h"
#include "base/lower_case.h"
#include "base/open_file.h"
#include "base/open_input.h"
#include "base/owned_descriptor.h"
#include "base/parallel.h"
#include "base/version.h"
#include "image/image_codec.h"
#include "image/image_format.h"

namespace tessera {

namespace fs = std::filesystem;

namespace {

struct Format {
  const char* ending;
  const char* name;  ///< as OpenImageIO calls it; null: it can not write it, we do
  bool is_float;
  bool has_channels = false;  ///< as many as there are, with names
  bool holds_16_bits = false;
  bool holds_alpha = false;
};

constexpr std::array<Format, 15> kFormats{{{"png", "png", false, false, true, true},
                                           {"apng", "png", false, false, true, true},
                                           {"exr", "openexr", true, true, false, true},
                                           {"jpg", "jpeg", false},
                                           {"jpeg", "jpeg", false},
                                           {"bmp", "bmp", false},
                                           {"tif", "tiff", false, false, true, true},
                                           {"tiff", "tiff", false, false, true, true},
                                           {"tga", "targa", false, false, false, true},
                                           {"ppm", "pnm", false},
                                           {"webp", "webp", false, false, false, true},
                                           {"hdr", "hdr", true},
                                           {"pfm", nullptr, true},
                                           {"gif", "gif", false},
                                           {"sgi", "sgi", false}}};

const Format& format_of(const fs::path& path) {
  std::string ending = lower_case(path.extension().string());
  if (!ending.empty()) ending.erase(0, 1);
  if (path == "-") ending = "png";
  std::vector<std::string> known;
  for (const Format& format : kFormats) {
    if (ending == format.ending) return format;
    known.emplace_back(format.ending);
  }
  if (ending.empty()) {
    throw usage_error(fmt::format("'{}' has no ending, which names the format; expected .{}",
                                  path.string(), fmt::join(known, ", .")));
  }
  throw usage_error(
      fmt::format("{}: '{}' is no image format that can be written; expected one of {}{}",
                  path.string(), ending, fmt::join(known, ", "), suggestion(ending, known)));
}

/// ".png, .exr" of the formats that have it.
std::string endings_with(bool Format::*has) {
  std::vector<std::string> endings;
  for (const Format& format : kFormats) {
    if (format.*has) endings.push_back(fmt::format(".{}", format.ending));
  }
  return fmt::format("{}", fmt::join(endings, ", "));
}

/// Portable float map: little-endian floats, rows from the bottom.
std::string encode_pfm(const Film& film) {
  std::string bytes = fmt::format("PF\n{} {}\n-1.0\n", film.width(), film.height());
  bytes.reserve(bytes.size() + film.values().size_bytes());
  const auto row_size = static_cast<size_t>(film.width()) * kFilmChannels;
  for (int y = film.height() - 1; y >= 0; --y) {
    const auto row = film.values().subspan(static_cast<size_t>(y) * row_size, row_size);
    bytes.append(reinterpret_cast<const char*>(row.data()), row.size_bytes());
  }
  return bytes;
}

static_assert(PixelLayout::kMostSide == kMaxFrameSide &&
              PixelLayout::kMostPixels == kMaxFramePixels);

template <size_t size>
void copy_text(std::string_view text, char (&out)[size]) {
  out[text.copy(out, size - 1)] = 0;
}

std::string_view as_text(std::span<const std::byte> bytes) {
  return {reinterpret_cast<const char*>(bytes.data()), bytes.size()};
}

void copy_name(const char* option, std::string_view text, char (&out)[128]) {
  if (text.size() >= sizeof out) {
    throw usage_error(fmt::format("the name of the {} is too long; expected at most {} bytes",
                                  option, sizeof out - 1));
  }
  copy_text(text, out);
}

/// The film as the names ask for it.
void convert_colors(const ColorManagement& names, Film& film) {
  ImageRequest request;
  request.call = ImageRequest::convert_colors;
  request.layout = {film.width(), film.height(), kFilmChannels, 32};
  copy_name("input colour space", names.input, request.colors.input);
  copy_name("display", names.display, request.colors.display);
  copy_name("view", names.view, request.colors.view);
  copy_name("colour space", names.color_space, request.colors.color_space);
  const auto answer =
      ImageCodec::for_colors().call(request, as_text(std::as_bytes(std::span(film.values()))));
  const auto values = std::as_writable_bytes(film.values());
  if (answer.payload->size() != values.size()) throw render_error("colours are missing");
  std::ranges::copy(*answer.payload, values.begin());
}

/// The film's light as `quantize` makes it integers, by colour management where that is asked for.
template <typename Quantize>
auto shown(const Film& film, const OutputSettings& settings, const Quantize& quantize) {
  if (!settings.color_management) return quantize(film, settings);
  Film converted(film.rect());
  std::ranges::copy(film.values(), converted.values().begin());
  expose(converted, settings);
  convert_colors(*settings.color_management, converted);
  return quantize(converted,
                  {.transfer = TransferCurve::display, .quantization = settings.quantization});
}

/// The same of a film with alpha and nothing else beside its light. Of colours those are shown that
/// alpha is the share of; the curves leave alpha alone.
template <typename Quantize>
auto shown_before_anything(const Film& film, const OutputSettings& settings,
                           const Quantize& quantize) {
  constexpr size_t kChannels = kFilmChannels + 1;
  const std::span<const float> values = film.values();
  Film unassociated(film.rect());
  float* to = unassociated.values().data();
  for (size_t pixel = 0; pixel < values.size(); pixel += kChannels) {
    const float alpha = values[pixel + kFilmChannels];
    for (size_t i = 0; i < kFilmChannels; ++i) *to++ = alpha > 0 ? values[pixel + i] / alpha : 0;
  }
  const auto colors = shown(unassociated, settings, quantize);
  using Integer = typename decltype(colors)::value_type;
  std::vector<Integer> result(values.size());
  auto color = colors.begin();
  for (size_t pixel = 0; pixel < result.size(); pixel += kChannels, color += kFilmChannels) {
    std::copy_n(color, kFilmChannels, &result[pixel]);
    const float alpha = std::clamp(values[pixel + kFilmChannels], 0.0f, 1.0f);
    result[pixel + kFilmChannels] =
        static_cast<Integer>(std::lround(alpha * std::numeric_limits<Integer>::max()));
  }
  return result;
}

BlobData encode(const Format& format, const Film& film, const OutputSettings& settings,
                const ImageMetadata& metadata) {
  ImageRequest request;
  request.call = ImageRequest::encode;
  copy_text(format.name, request.format);
  request.layout = {film.width(), film.height(), film.channels(),
                    format.is_float ? 32 : settings.bits};
  if (format.has_channels) {
    copy_text(fmt::format("{}", fmt::join(film.aovs().channel_names(), ",")),
              request.channel_names);
  }
  request.window = {film.rect().x0, film.rect().y0, metadata.frame_width, metadata.frame_height};
  copy_text(fmt::format("tessera {}", kVersion), request.attributes.software);
  copy_text(metadata.scene_digest, request.attributes.scene_digest);
  copy_text(metadata.colors, request.attributes.colors);
  copy_text(metadata.denoiser, request.attributes.denoiser);
  request.attributes.seed = metadata.seed;
  request.attributes.samples_per_pixel = metadata.samples_per_pixel;
  const auto encoded = [&request](const auto& values) {
    return ImageCodec::shared().call(request, as_text(std::as_bytes(std::span(values)))).payload;
  };
  if (format.is_float) return encoded(film.values());
  const auto as_integers = [&](const auto& quantize) {
    return encoded(film.aovs().empty() ? shown(film, settings, quantize)
                                       : shown_before_anything(film, settings, quantize));
  };
  return settings.bits == 16 ? as_integers(to_16_bit) : as_integers(to_8_bit);
}

/// The file in memory that the codec can be handed, and its format.
struct ImageBytes {
  const char* format;
  SealedMemory memory;
};

SealedMemory make_memory(const std::string& name, uint64_t bytes) {
  if (auto memory = SealedMemory::create(bytes)) return *std::move(memory);
  throw render_error(
      fmt::format("'{}' cannot be read: no memory for it: {}", name, std::strerror(errno)));
}

/// The first bytes of the file at `path`, as many as there is room for.
void read_beginning(const std::string& path, const OwnedDescriptor& file,
                    std::span<std::byte> bytes) {
  errno = 0;
  if (read_all_at(file.get(), 0, bytes)) return;
  const char* const cause = errno ? std::strerror(errno) : "the file has become shorter";
  throw scene_error(fmt::format("{}: {}", path, cause));
}

ImageBytes read_bytes(const std::string& path) {
  // More than any picture that is_legal() has, however it is compressed.
  constexpr uint64_t kMostFileBytes = most_encoded_bytes(16 * uint64_t{PixelLayout::kMostPixels});
  const uint64_t size = check_input_file(path, kMostFileBytes);
  const OwnedDescriptor file = open_input(path);
  if (file.get() < 0) throw scene_error(fmt::format("{}: {}", path, std::strerror(errno)));
  std::array<std::byte, kFormatBytes> head;
  const auto known = std::span(head).first(std::min<uint64_t>(size, head.size()));
  read_beginning(path, file, known);
  ImageBytes read{image_format_of(path, as_text(known)), make_memory(path, size)};
  read_beginning(path, file, std::as_writable_bytes(read.memory.bytes()));
  return read;
}

ImageBytes copy_bytes(const std::string& name, std::string_view file) {
  ImageBytes copy{image_format_of(name, file), make_memory(name, file.size())};
  std::ranges::copy(file, copy.memory.bytes().begin());
  return copy;
}

/// What the codec tells of a file, whose libraries call it by a path of the codec's own.
std::string named(std::string cause, const std::string& name) {
  constexpr std::string_view kOwn = "/proc/self/fd/";
  for (size_t at = cause.find(kOwn); at != std::string::npos; at = cause.find(kOwn, at)) {
    const size_t end = cause.find_first_not_of("0123456789", at + kOwn.size());
    cause.replace(at, std::min(end, cause.size()) - at, name);
    at += name.size();
  }
  return cause;
}

ImageCodec::Answer decode(ImageRequest::Call call, const std::string& name, ImageBytes file,
                          bool to_srgb = false) {
  ImageRequest request;
  request.call = call;
  request.to_srgb = to_srgb;
  copy_text(file.format, request.format);
  try {
    return ImageCodec::shared().decode(request, std::move(file.memory));
  } catch (const ImageCodec::Refusal& refusal) {
    throw scene_error(SourcePlace{name},
                      fmt::format("can not be read: {}", named(refusal.what(), name)),
                      "an image file");
  } catch (const Error& error) {
    throw render_error(fmt::format("'{}' cannot be read: {}", name, error.what()));
  }
}

std::string part_note(const std::string& part) {
  return part.empty() ? "" : fmt::format("part '{}' is read, not the first", part);
}

TextureImage as_texture(ImageCodec::Answer answer) {
  return {.width = static_cast<uint32_t>(answer.layout.width),
          .height = static_cast<uint32_t>(answer.layout.height),
          .channels = static_cast<uint32_t>(answer.layout.channels),
          .bits = static_cast<uint32_t>(answer.layout.bits),
          .texels = std::move(answer.payload),
          .meaning = answer.meaning,
          .unused_channels = std::move(answer.names),
          .part_note = part_note(answer.part),
          .damage = std::move(answer.damage),
          .gamma = answer.gamma};
}

}  // namespace

bool is_quickly_prepared(const fs::path& path) {
  const char* const name = format_of(path).name;
  return name && (std::string_view(name) == "png" || std::string_view(name) == "openexr");
}

void prepare_to_write(const fs::path& path) {
  if (format_of(path).name) ImageCodec::shared().start(!is_quickly_prepared(path));
}

void check_writable(const fs::path& path) {
  if (format_of(path).name) ImageCodec::check_installed();
  if (!is_standard_output(path)) return check_output_file(path.string());
  if (::isatty(STDOUT_FILENO) == 0) return;
  throw usage_error(
      fmt::format("'{}': standard output is a terminal; expected a pipe or a file", path.string()));
}

bool is_standard_output(const fs::path& path) {
  return !path.has_parent_path() && path.stem() == "-";
}

void write_picture(const fs::path& path, std::string_view bytes) {
  if (!is_standard_output(path)) return write_output_file(path.string(), bytes);
  if (!write_all(STDOUT_FILENO, std::as_bytes(std::span(bytes))))
    throw render_error(fmt::format("standard output: {}", std::strerror(errno)));
}

void check_color_management(const ColorManagement& names) {
  const char* const file = std::getenv("OCIO");
  if (!file || !*file) {
    const char* const option = !names.color_space.empty() ? "--ocio-space"
                               : !names.display.empty()   ? "--ocio-display"
                                                          : "--ocio-view";
    throw usage_error(fmt::format(
        "{} without $OCIO; expected that to be the path of an OpenColorIO configuration", option));
  }
  std::error_code unknown;
  const fs::file_status status = fs::status(file, unknown);
  if (fs::exists(status) && !fs::is_regular_file(status)) {
    throw usage_error(fmt::format(
        "$OCIO, '{}': no regular file; expected the path of an OpenColorIO configuration", file));
  }
  Film film({0, 0, 1, 1});
  try {
    convert_colors(names, film);
  } catch (const Error& error) {
    throw usage_error(fmt::format("$OCIO, '{}': {}", file, error.what()));
  }
}

std::vector<uint8_t> shown_bytes(const Film& film, const OutputSettings& settings) {
  return shown(film, settings, to_8_bit);
}

bool holds_aovs(const fs::path& path) { return format_of(path).has_channels; }

bool holds_floats(const fs::path& path) { return format_of(path).is_float; }

void check_bits(const fs::path& path, const OutputSettings& settings) {
  const Format& format = format_of(path);
  if (settings.bits == 8 || format.is_float || format.holds_16_bits) return;
  throw usage_error(fmt::format("--bits {}: '{}' holds 8; expected one of {}", settings.bits,
                                path.string(), endings_with(&Format::holds_16_bits)));
}

void check_alpha(const fs::path& path, AovSet aovs) {
  if (!aovs.has(Aov::alpha) || format_of(path).holds_alpha) return;
  throw usage_error(fmt::format("--transparent-background: '{}' holds no alpha; expected one of {}",
                                path.string(), endings_with(&Format::holds_alpha)));
}

std::string encode_image(const fs::path& path, const Film& film, const OutputSettings& settings,
                         const ImageMetadata& metadata) {
  const Format& format = format_of(path);
  check_bits(path, settings);
  check_alpha(path, film.aovs());
  if (const AovSet held = film.aovs().only_alpha(); film.aovs() != held && !format.has_channels) {
    return encode_image(path, film.with_only(held), settings, metadata);
  }
  if (!format.name) return encode_pfm(film);
  // Its numbers have 16 bits, and what does not fit would be cut off without a word.
  constexpr int kMostSideOfGif = 65535;
  if (format.name == std::string_view("gif") &&
      std::max(film.width(), film.height()) > kMostSideOfGif) {
    throw render_error(
        fmt::format("'{}' cannot be written: {}x{} pixels; expected at most {} a side of a GIF",
                    path.string(), film.width(), film.height(), kMostSideOfGif));
  }
  try {
    return std::string(as_text(*encode(format, film, settings, metadata)));
  } catch (const Error& error) {
    throw render_error(fmt::format("'{}' cannot be written: {}", path.string(),
                                   named(error.what(), path.string())));
  }
}

void write_image(const fs::path& path, const Film& film, const OutputSettings& settings,
                 const ImageMetadata& metadata) {
  write_picture(path, encode_image(path, film, settings, metadata));
}

FloatImage read_image(const fs::path& path) {
  const ImageCodec::Answer answer =
      decode(ImageRequest::decode_all, path.string(), read_bytes(path.string()));
  FloatImage image{.width = answer.layout.width,
                   .height = answer.layout.height,
                   .channels = answer.names,
                   .values = {},
                   .meaning = answer.meaning,
                   .part_note = part_note(answer.part)};
  const std::span<const std::byte> samples = *answer.payload;
  const size_t bytes = static_cast<size_t>(answer.layout.bits) / 8;
  image.values.resize(samples.size() / bytes);
  constexpr size_t kAtOnce = size_t{1} << 18;
  for_each_piece_parallel(image.values.size(), kAtOnce, core_count(),
                          [&](size_t begin, size_t end) {
                            samples_to_floats(samples.subspan(begin * bytes, (end - begin) * bytes),
                                              static_cast<uint32_t>(answer.layout.bits),
                                              std::span(image.values).subspan(begin, end - begin));
                          });
  image.channels.resize(static_cast<size_t>(answer.layout.channels));
  return image;
}

std::vector<float> linear_light(const FloatImage& image) {
  const ColorChannels used = color_channels_of(image.channels);
  const auto order = used.in_order();
  const auto count = used.count();
  const bool is_grey = used.kind == ColorChannels::Kind::grey;
  const bool needs_alpha = used.alpha && !image.meaning.is_associated;
  const size_t pixels = image.values.size() / image.channels.size();
  std::vector<float> light(3 * pixels);
  constexpr size_t kPixelsAtOnce = size_t{1} << 16;
  for_each_piece_parallel(pixels, kPixelsAtOnce, core_count(), [&](size_t begin, size_t end) {
    std::vector<float> colors((end - begin) * order.size());
    const float* from = &image.values[begin * image.channels.size()];
    for (float* to = colors.data(); to != colors.data() + colors.size();
         to += order.size(), from += image.channels.size()) {
      for (size_t i = 0; i < order.size(); ++i) {
        if (order[i]) to[i] = from[*order[i]];
      }
    }
    if (used.kind == ColorChannels::Kind::luminance_chroma) luminance_chroma_to_rgb(colors, count);
    decode_samples(colors, count, image.meaning, SampleEncoding::automatic);
    for (size_t pixel = begin; pixel < end; ++pixel) {
      const float* const color = &colors[(pixel - begin) * count];
      const float alpha = needs_alpha ? color[count - 1] : 1;
      for (size_t i = 0; i < 3; ++i) light[3 * pixel + i] = alpha * color[is_grey ? 0 : i];
    }
  });
  return light;
}

TextureImage read_texture_image(const fs::path& path, bool to_srgb) {
  return as_texture(
      decode(ImageRequest::decode, path.string(), read_bytes(path.string()), to_srgb));
}

TextureImage decode_texture_image(const std::string& name, std::string_view file) {
  return as_texture(decode(ImageRequest::decode, name, copy_bytes(name, file)));
}

}  // namespace tessera
