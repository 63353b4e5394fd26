#pragma once

#include <span>
#include <string_view>

#include "renderer/sampler/sampler.h"

namespace tessera {

/// Sampler::raster_sample() of each key, to the last bit. As many samples as keys.
using DrawRasters = void (*)(const Sampler& sampler, std::span<const SampleKey> keys,
                             std::span<Sampler::RasterSample> samples);
/// That for such a sampler, by the instructions of the set that Highway calls so.
DrawRasters raster_drawer(const Sampler& sampler, std::string_view instructions);

}  // namespace tessera
