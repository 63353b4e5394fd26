#pragma once

#include <span>
#include <string_view>

#include "renderer/sampler/sampler.h"

namespace tessera {

/// Sampler::raster_sample() of each key, to the last bit, by the instructions of the set that
/// Highway calls so. As many samples as keys.
void draw_rasters(const Sampler& sampler, std::span<const SampleKey> keys,
                  std::span<Sampler::RasterSample> samples, std::string_view instructions);

}  // namespace tessera
