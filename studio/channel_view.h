#pragma once

#include <array>
#include <cstdint>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "renderer/film/film.h"
#include "renderer/film/tone_map.h"

namespace tessera {

/// What a view shows of its film: its light, or one of the values beside it in false colours.
/// `cost`: those of its light, which the integrator `cost` counts.
enum class ViewChannel {
  light,
  albedo,
  normal,
  depth,
  position,
  id,
  variance,
  error,
  samples,
  cost
};

/// Throws usage_error, with the nearest name, for a name that is none of channel_names().
ViewChannel parse_channel(const std::string& name);
const char* name_of_channel(ViewChannel channel);
/// Those that a page may ask for, in the order of ViewChannel: all but `cost`.
std::span<const char* const> channel_names();
/// What a film has to have for it beside light; nothing for what light shows.
std::optional<Aov> aov_of(ViewChannel channel);

/// What the colours of a channel stand for.
struct Legend {
  ViewChannel channel = ViewChannel::light;
  bool is_scale = false;     ///< from `low`, dark blue, to `high`, yellow
  bool is_known = true;      ///< whether the film tells the channel; else the numbers say nothing
  double low = 0, high = 1;  ///< the least and the most of what is shown
  double mean = 0;           ///< of the pixels that have a value
  std::vector<double> steps{};  ///< at equal distances of colour, from `low` to `high`
  friend bool operator==(const Legend&, const Legend&) = default;
};

/// The colour of a share of the scale, 0 to 1.
std::array<uint8_t, 3> scale_color(double share);

/// Of the whole film, which has the channel and so many samples a pixel. The variance of light and
/// its error are known from two samples on.
Legend legend_of(const Film& film, ViewChannel channel, const OutputSettings& output,
                 uint32_t samples);

/// Opaque pixels, four bytes each, of a rect of the film. `legend`: of that channel, for its scale.
std::vector<uint8_t> channel_pixels(const Film& film, const PixelRect& rect, const Legend& legend,
                                    const OutputSettings& output);

}  // namespace tessera
