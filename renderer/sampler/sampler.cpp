#include "renderer/sampler/sampler.h"

#include <cmath>

#include "renderer/sampler/scramble.h"

namespace tessera {

namespace {

uint32_t reverse_bits(uint32_t v) {
  v = __builtin_bswap32(v);
  v = ((v & 0xf0f0f0f0u) >> 4) | ((v & 0x0f0f0f0fu) << 4);
  v = ((v & 0xccccccccu) >> 2) | ((v & 0x33333333u) << 2);
  return ((v & 0xaaaaaaaau) >> 1) | ((v & 0x55555555u) << 1);
}

uint64_t reverse_bits(uint64_t v) {
  v = __builtin_bswap64(v);
  v = ((v & 0xf0f0f0f0f0f0f0f0u) >> 4) | ((v & 0x0f0f0f0f0f0f0f0fu) << 4);
  v = ((v & 0xccccccccccccccccu) >> 2) | ((v & 0x3333333333333333u) << 2);
  return ((v & 0xaaaaaaaaaaaaaaaau) >> 1) | ((v & 0x5555555555555555u) << 1);
}

uint64_t mix(uint64_t v) {
  v += scramble::kMixStep;
  v = (v ^ (v >> 30)) * scramble::kMixFirst;
  v = (v ^ (v >> 27)) * scramble::kMixLast;
  return v ^ (v >> 31);
}

/// Each bit of the result depends on `seed` and on the bits of `v` at and below it (Laine and
/// Karras 2011). On reversed bits this is an Owen scramble.
uint32_t scramble_upwards(uint32_t v, uint32_t seed) {
  v ^= v * scramble::kUpwardsFirst;
  v += seed;
  v *= (seed >> 16) | 1u;
  v ^= v * scramble::kUpwardsNext;
  v ^= v * scramble::kUpwardsLast;
  return v;
}

/// The bits of the second Sobol coordinate from the last to the first. Its primitive polynomial is
/// x + 1, its direction numbers are the rows of Pascal's triangle modulo 2: bit j is the sum of the
/// index bits whose number contains j as a binary set, which five steps add up.
uint32_t sobol_second_reversed(uint32_t index) {
  index ^= (index >> 1) & 0x55555555u;
  index ^= (index >> 2) & 0x33333333u;
  index ^= (index >> 4) & 0x0f0f0f0fu;
  index ^= (index >> 8) & 0x00ff00ffu;
  return index ^ (index >> 16);
}

/// `reversed` is the sample's number with its bits reversed.
Vec2 owen_sobol_pair(uint64_t key, uint32_t reversed) {
  const auto low = static_cast<uint32_t>(key);
  const auto high = static_cast<uint32_t>(key >> 32);
  // Shuffling the order by an Owen scramble of the index keeps the first 2^k points a net, and
  // unties this pair from the others.
  const uint32_t index = reverse_bits(scramble_upwards(reversed, static_cast<uint32_t>(mix(key))));
  // The first coordinate is van der Corput's: the index reversed.
  const uint32_t u = scramble_upwards(index, low);
  const uint32_t v = scramble_upwards(sobol_second_reversed(index), high);
  const uint64_t both = reverse_bits(uint64_t{u} << 32 | v);
  return {static_cast<uint32_t>(both) * scramble::kUnit,
          static_cast<uint32_t>(both >> 32) * scramble::kUnit};
}

Vec2 independent_pair(uint64_t key, uint32_t sample) {
  const uint64_t bits = mix(key ^ mix(sample));
  return {static_cast<uint32_t>(bits) * scramble::kUnit,
          static_cast<uint32_t>(bits >> 32) * scramble::kUnit};
}

/// The bits of both numbers in turns, of `x` first.
uint32_t z_order(uint32_t x, uint32_t y) {
  const auto spread = [](uint32_t v) {  // of 16 bits
    v = (v | (v << 8)) & 0x00ff00ffu;
    v = (v | (v << 4)) & 0x0f0f0f0fu;
    v = (v | (v << 2)) & 0x33333333u;
    return (v | (v << 1)) & 0x55555555u;
  };
  return spread(x) | (spread(y) << 1);
}

/// Distance from the centre, in radii, below which a share `u` of a tent lies.
double tent(double u) { return u < 0.5 ? std::sqrt(2 * u) - 1 : 1 - std::sqrt(2 * (1 - u)); }

}  // namespace

Sampler::Sampler(const SamplerSettings& settings) : settings_(settings) {
  while (uint64_t{grid_ + 1} * (grid_ + 1) <= settings_.samples_per_pixel) ++grid_;
  while (uint64_t{1} << sample_bits_ < settings_.samples_per_pixel) ++sample_bits_;
  if (settings_.filter != PixelFilter::box && settings_.filter != PixelFilter::tent) {
    table_ = std::make_shared<const FilterTable>(settings_.filter, settings_.filter_radius);
  }
  const bool is_grid = settings_.pattern == SamplePattern::centered_grid ||
                       settings_.pattern == SamplePattern::corner_grid;
  is_plain_box_ = settings_.filter == PixelFilter::box && settings_.filter_radius == 0.5;
  is_centered_ =
      (settings_.pattern == SamplePattern::center || (is_grid && grid_ == 1)) && is_plain_box_;
}

Vec2 Sampler::pixel_square(int x, int y, uint32_t sample) const {
  switch (settings_.pattern) {
    case SamplePattern::center:
      return {0.5, 0.5};
    case SamplePattern::centered_grid:
    case SamplePattern::corner_grid: {
      if (grid_ == 1 && sample == 0) return {0.5, 0.5};
      const double shift = settings_.pattern == SamplePattern::centered_grid ? 0.5 : 0.0;
      const uint32_t column = sample % grid_, row = sample / grid_;
      return {(column + shift) / grid_, (row + shift) / grid_};
    }
    case SamplePattern::owen_sobol:
    case SamplePattern::independent:
    case SamplePattern::blue_noise:
      break;
  }
  return pair(x, y, sample, SampleUse::pixel);
}

Sampler::RasterSample Sampler::drawn_raster_sample(int x, int y, uint32_t sample) const {
  return filtered(x, y, pixel_square(x, y, sample));
}

Sampler::RasterSample Sampler::widely_filtered(int x, int y, Vec2 u) const {
  bool negative = false;
  if (table_) {
    const FilterTable::Draw across = table_->draw(u.x), down = table_->draw(u.y);
    u = {0.5 + across.offset, 0.5 + down.offset};
    negative = across.negative != down.negative;
  } else if (settings_.filter == PixelFilter::tent) {
    u = {0.5 + settings_.filter_radius * tent(u.x), 0.5 + settings_.filter_radius * tent(u.y)};
  } else {
    const double side = 2 * settings_.filter_radius;
    u = {0.5 + side * (u.x - 0.5), 0.5 + side * (u.y - 0.5)};
  }
  return {{x + u.x, y + u.y}, negative};
}

Vec2 SampleStream::pair(SampleUse use) const {
  const uint64_t key = mix(key_ ^ static_cast<uint32_t>(use));
  return independent_ ? independent_pair(key, sample_) : owen_sobol_pair(key, sample_);
}

SampleStream Sampler::stream(int x, int y, uint32_t sample) const {
  const auto column = static_cast<uint32_t>(x), row = static_cast<uint32_t>(y);
  if (settings_.pattern == SamplePattern::blue_noise) return picture_stream(column, row, sample);
  SampleStream stream;
  stream.key_ = mix((uint64_t{row} << 32) | column) ^ (uint64_t{settings_.seed} << 32);
  stream.independent_ = settings_.pattern == SamplePattern::independent;
  stream.sample_ = stream.independent_ ? sample : reverse_bits(sample);
  return stream;
}

SampleStream Sampler::picture_stream(uint32_t column, uint32_t row, uint32_t sample) const {
  // What does not fit into the index, pixels far apart and samples beyond those announced, is
  // keyed.
  const uint32_t side_bits = (32 - sample_bits_) / 2, mask = (1u << side_bits) - 1;
  const uint64_t square = (uint64_t{row >> side_bits} << 32) | (column >> side_bits);
  const uint32_t order = z_order(column & mask, row & mask);
  const uint32_t within = sample & ((1u << sample_bits_) - 1);
  SampleStream stream;
  stream.key_ =
      mix(square ^ (uint64_t{sample >> sample_bits_} << 48)) ^ (uint64_t{settings_.seed} << 32);
  stream.sample_ = reverse_bits((order << sample_bits_) | within);
  return stream;
}

Vec2 Sampler::pair(int x, int y, uint32_t sample, SampleUse use) const {
  return stream(x, y, sample).pair(use);
}

}  // namespace tessera
