#pragma once

#include <optional>
#include <span>
#include <string_view>
#include <vector>

#include "proto/tessera/v1/farm.pb.h"

namespace tessera {

/// Float32 values of a pixel that is light alone.
inline constexpr int kWireChannels = 3;
/// Decoded bytes of one band, unless a single row is longer.
inline constexpr size_t kBandBytes = size_t{1} << 20;

/// Cuts rows from the top of `width` pixels each, the first of them row `first_row` of the frame,
/// into bands with rows, encoding, pixels, checksum and `last` filled in. Compressed bands hold
/// byte planes (all first bytes, all second bytes ...) under zstd level 1; those that do not shrink
/// stay raw.
std::vector<v1::TileBand> encode_bands(std::span<const float> values, int width, int first_row,
                                       bool compress, int channels = kWireChannels);

/// Unpacks a band's rows of `width` pixels into `values`, which it resizes. False if they are
/// damaged, longer than encode_bands() makes them, or of another size than the band says: then
/// nothing was allocated.
bool decode_band(const v1::TileBand& band, int width, std::vector<float>& values,
                 int channels = kWireChannels);

}  // namespace tessera
