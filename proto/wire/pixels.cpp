#include "proto/wire/pixels.h"

#include <zstd.h>

#include <algorithm>
#include <cstring>
#include <limits>
#include <optional>
#include <string>

#include "proto/wire/crc32c.h"

namespace tessera {
namespace {

constexpr size_t kFloat = sizeof(float);

std::string shuffle(std::span<const std::byte> bytes) {
  const size_t count = bytes.size() / kFloat;
  std::string planes(bytes.size(), '\0');
  for (size_t plane = 0; plane < kFloat; ++plane) {
    for (size_t i = 0; i < count; ++i) {
      planes[plane * count + i] = static_cast<char>(bytes[i * kFloat + plane]);
    }
  }
  return planes;
}

void unshuffle(std::string_view planes, std::span<std::byte> bytes) {
  const size_t count = bytes.size() / kFloat;
  for (size_t plane = 0; plane < kFloat; ++plane) {
    for (size_t i = 0; i < count; ++i) {
      bytes[i * kFloat + plane] = static_cast<std::byte>(planes[plane * count + i]);
    }
  }
}

std::optional<std::string> compressed(std::span<const std::byte> bytes) {
  const std::string planes = shuffle(bytes);
  std::string packed(ZSTD_compressBound(planes.size()), '\0');
  const size_t size = ZSTD_compress(packed.data(), packed.size(), planes.data(), planes.size(), 1);
  if (ZSTD_isError(size) || size >= bytes.size()) return std::nullopt;
  packed.resize(size);
  return packed;
}

bool decompress(const std::string& packed, std::span<std::byte> bytes) {
  std::string planes(bytes.size(), '\0');
  if (ZSTD_decompress(planes.data(), planes.size(), packed.data(), packed.size()) != bytes.size()) {
    return false;
  }
  unshuffle(planes, bytes);
  return true;
}

/// What the band says that its pixels come to; nothing if it does not say.
std::optional<uint64_t> unpacked_bytes(const v1::TileBand& band) {
  const std::string& pixels = band.pixels();
  if (band.encoding() == v1::TileBand::RAW) return pixels.size();
  if (band.encoding() != v1::TileBand::SHUFFLED_ZSTD) return std::nullopt;
  const unsigned long long size = ZSTD_getFrameContentSize(pixels.data(), pixels.size());
  if (size == ZSTD_CONTENTSIZE_UNKNOWN || size == ZSTD_CONTENTSIZE_ERROR) return std::nullopt;
  return size;
}

}  // namespace

std::vector<v1::TileBand> encode_bands(std::span<const float> values, int width, int first_row,
                                       bool compress, int channels) {
  const size_t row_values = static_cast<size_t>(width) * static_cast<size_t>(channels);
  const size_t band_values = std::max<size_t>(1, kBandBytes / (row_values * kFloat)) * row_values;
  std::vector<v1::TileBand> bands;
  for (size_t start = 0; start < values.size(); start += band_values) {
    const auto part = values.subspan(start, std::min(band_values, values.size() - start));
    const auto bytes = std::as_bytes(part);
    v1::TileBand& band = bands.emplace_back();
    band.set_first_row(first_row + static_cast<int>(start / row_values));
    band.set_rows(static_cast<int>(part.size() / row_values));
    band.set_pixel_crc(crc32c(bytes));
    auto packed = compress ? compressed(bytes) : std::nullopt;
    if (packed) {
      band.set_encoding(v1::TileBand::SHUFFLED_ZSTD);
      band.set_pixels(std::move(*packed));
    } else {
      band.set_pixels(bytes.data(), bytes.size());
    }
  }
  if (!bands.empty()) bands.back().set_last(true);
  return bands;
}

bool decode_band(const v1::TileBand& band, int width, std::vector<float>& values, int channels) {
  if (band.rows() < 1 || width < 1) return false;
  const size_t row_bytes = static_cast<size_t>(width) * static_cast<size_t>(channels) * kFloat;
  const uint64_t expected = uint64_t{row_bytes} * static_cast<uint64_t>(band.rows());
  if (expected > std::max(kBandBytes, row_bytes)) return false;
  const std::string& pixels = band.pixels();
  if (unpacked_bytes(band) != expected) return false;
  values.resize(static_cast<size_t>(expected) / kFloat);
  const auto bytes = std::as_writable_bytes(std::span(values));
  if (band.encoding() == v1::TileBand::RAW) {
    std::memcpy(bytes.data(), pixels.data(), pixels.size());
  } else if (!decompress(pixels, bytes)) {
    return false;
  }
  return crc32c(bytes) == band.pixel_crc();
}

}  // namespace tessera
