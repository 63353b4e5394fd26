#include "studio/channel_view.h"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>

#include "base/error.h"
#include "image/image_file.h"

namespace tessera {
namespace {

constexpr std::array<const char*, 10> kNames{"light", "albedo",   "normal", "depth",   "position",
                                             "id",    "variance", "error",  "samples", "cost"};
constexpr int kLegendSteps = 5;

}  // namespace

std::span<const char* const> channel_names() {
  return std::span(kNames).first(static_cast<size_t>(ViewChannel::cost));
}

const char* name_of_channel(ViewChannel channel) { return kNames[static_cast<size_t>(channel)]; }

namespace {

using Rgb = std::array<uint8_t, 3>;

/// Viridis: colours that get lighter evenly, also for the colour-blind and in print.
constexpr std::array<Rgb, 9> kScale{{{68, 1, 84},
                                     {71, 44, 122},
                                     {59, 81, 139},
                                     {44, 113, 142},
                                     {33, 144, 141},
                                     {39, 173, 129},
                                     {92, 200, 99},
                                     {170, 220, 50},
                                     {253, 231, 37}}};

uint8_t byte_of(double value) {
  return static_cast<uint8_t>(std::lround(std::clamp(value, 0.0, 1.0) * 255));
}

/// One colour for each number, far from that of the next; 0, which is no object, is black.
Rgb color_of_id(float id) {
  if (!(id > 0)) return {0, 0, 0};
  constexpr double kGoldenShare = 0.618033988749895;
  const double hue = 6 * std::fmod(static_cast<double>(id) * kGoldenShare, 1.0);
  const auto side = [hue](double shift) {
    const double at = std::fmod(hue + shift, 6.0);
    return byte_of(0.25 + 0.7 * std::clamp(std::abs(at - 3) - 1, 0.0, 1.0));
  };
  return {side(0), side(4), side(2)};
}

/// The values of one pixel.
std::span<const float> pixel_of(const Film& film, int x, int y) {
  const auto channels = static_cast<size_t>(film.channels());
  const size_t at = (static_cast<size_t>(y - film.rect().y0) * static_cast<size_t>(film.width()) +
                     static_cast<size_t>(x - film.rect().x0)) *
                    channels;
  return film.values().subspan(at, channels);
}

/// The number on the scale; not a number where the pixel has none.
double scale_value(std::span<const float> pixel, AovSet aovs, ViewChannel channel,
                   double exposure) {
  const auto at = [&](Aov aov, size_t index) {
    return static_cast<double>(pixel[static_cast<size_t>(aovs.first_channel(aov)) + index]);
  };
  constexpr double kNone = std::numeric_limits<double>::quiet_NaN();
  switch (channel) {
    case ViewChannel::depth:
      return at(Aov::depth, 0) > 0 ? at(Aov::depth, 0) : kNone;
    case ViewChannel::samples:
      return at(Aov::samples, 0);
    case ViewChannel::cost:
      return static_cast<double>(pixel[0]);
    case ViewChannel::variance:
    case ViewChannel::error: {
      const double variance =
          (at(Aov::variance, 0) + at(Aov::variance, 1) + at(Aov::variance, 2)) / 3;
      // 1 is what is shown as white.
      return channel == ViewChannel::variance ? variance
                                              : std::sqrt(std::max(variance, 0.0)) * exposure;
    }
    default:
      return kNone;
  }
}

/// Where it is on the scale of colours: errors differ by magnitudes, which a root tells apart, and
/// depths by factors.
double share_of(double value, const Legend& legend) {
  if (legend.channel == ViewChannel::depth)
    return legend.high > legend.low
               ? std::log(value / legend.low) / std::log(legend.high / legend.low)
               : 0;
  const double range = legend.high - legend.low;
  const double share = range > 0 ? (value - legend.low) / range : 0;
  const bool has_magnitudes =
      legend.channel == ViewChannel::variance || legend.channel == ViewChannel::error;
  return has_magnitudes ? std::sqrt(std::max(share, 0.0)) : share;
}

double value_at(double share, const Legend& legend) {
  if (legend.channel == ViewChannel::depth)
    return legend.low * std::pow(legend.high / legend.low, share);
  const bool has_magnitudes =
      legend.channel == ViewChannel::variance || legend.channel == ViewChannel::error;
  return legend.low + (legend.high - legend.low) * (has_magnitudes ? share * share : share);
}

bool is_scale(ViewChannel channel) {
  return channel == ViewChannel::depth || channel == ViewChannel::variance ||
         channel == ViewChannel::error || channel == ViewChannel::samples ||
         channel == ViewChannel::cost;
}

std::vector<uint8_t> light_pixels(const Film& film, const PixelRect& rect,
                                  const OutputSettings& output) {
  Film part(rect);
  std::span<float> light = part.values();
  size_t at = 0;
  for (int y = rect.y0; y < rect.y1; ++y) {
    for (int x = rect.x0; x < rect.x1; ++x) {
      const auto pixel = pixel_of(film, x, y);
      for (size_t c = 0; c < kFilmChannels; ++c) light[at++] = pixel[c];
    }
  }
  const std::vector<uint8_t> rgb = shown_bytes(part, output);
  std::vector<uint8_t> rgba;
  rgba.reserve(rgb.size() / 3 * 4);
  for (size_t i = 0; i < rgb.size(); i += 3) {
    rgba.insert(rgba.end(), {rgb[i], rgb[i + 1], rgb[i + 2], uint8_t{255}});
  }
  return rgba;
}

Rgb vector_color(std::span<const float> pixel, const Film& film, const Legend& legend) {
  const auto first = static_cast<size_t>(film.aovs().first_channel(*aov_of(legend.channel)));
  Rgb color{};
  for (size_t c = 0; c < color.size(); ++c) {
    const double value = static_cast<double>(pixel[first + c]);
    switch (legend.channel) {
      case ViewChannel::albedo:
        color[c] = byte_of(std::pow(std::max(value, 0.0), 1 / 2.2));
        break;
      case ViewChannel::normal:
        color[c] = byte_of(0.5 + 0.5 * value);
        break;
      default:
        color[c] = legend.high > legend.low
                       ? byte_of((value - legend.low) / (legend.high - legend.low))
                       : uint8_t{0};
    }
  }
  return color;
}

}  // namespace

std::array<uint8_t, 3> scale_color(double share) {
  const double at = std::clamp(share, 0.0, 1.0) * (kScale.size() - 1);
  const auto below = std::min(static_cast<size_t>(at), kScale.size() - 2);
  const double part = at - static_cast<double>(below);
  Rgb color{};
  for (size_t c = 0; c < color.size(); ++c) {
    color[c] = static_cast<uint8_t>(
        std::lround(kScale[below][c] + part * (kScale[below + 1][c] - kScale[below][c])));
  }
  return color;
}

ViewChannel parse_channel(const std::string& name) {
  const auto names = channel_names();
  const auto at = std::find(names.begin(), names.end(), name);
  if (at != names.end()) return static_cast<ViewChannel>(at - names.begin());
  throw usage_error(
      fmt::format("channel: '{}'; expected one of {}{}", name, fmt::join(names, ", "),
                  suggestion(name, std::vector<std::string>(names.begin(), names.end()))));
}

std::optional<Aov> aov_of(ViewChannel channel) {
  switch (channel) {
    case ViewChannel::light:
    case ViewChannel::cost:
      return std::nullopt;
    case ViewChannel::albedo:
      return Aov::albedo;
    case ViewChannel::normal:
      return Aov::normal;
    case ViewChannel::depth:
      return Aov::depth;
    case ViewChannel::position:
      return Aov::position;
    case ViewChannel::id:
      return Aov::id;
    case ViewChannel::samples:
      return Aov::samples;
    case ViewChannel::variance:
    case ViewChannel::error:
      break;
  }
  return Aov::variance;
}

Legend legend_of(const Film& film, ViewChannel channel, const OutputSettings& output,
                 uint32_t samples) {
  Legend legend{.channel = channel, .is_scale = is_scale(channel)};
  legend.is_known = aov_of(channel) != Aov::variance || samples > 1;
  if (!legend.is_known) return legend;
  if (!legend.is_scale && channel != ViewChannel::position) return legend;
  const double exposure = std::exp2(output.exposure);
  double low = std::numeric_limits<double>::infinity(), high = -low, sum = 0;
  uint64_t count = 0;
  const auto note = [&](double value) {
    if (!std::isfinite(value)) return;
    low = std::min(low, value);
    high = std::max(high, value);
    sum += value;
    ++count;
  };
  for (int y = film.rect().y0; y < film.rect().y1; ++y) {
    for (int x = film.rect().x0; x < film.rect().x1; ++x) {
      const auto pixel = pixel_of(film, x, y);
      if (legend.is_scale) {
        note(scale_value(pixel, film.aovs(), channel, exposure));
        continue;
      }
      const auto first = static_cast<size_t>(film.aovs().first_channel(Aov::position));
      for (size_t c = 0; c < 3; ++c) note(static_cast<double>(pixel[first + c]));
    }
  }
  if (count == 0) return legend;
  legend.low = channel == ViewChannel::variance || channel == ViewChannel::error ? 0 : low;
  legend.high = high;
  legend.mean = sum / static_cast<double>(count);
  if (!legend.is_scale) return legend;
  for (int i = 0; i < kLegendSteps; ++i)
    legend.steps.push_back(value_at(static_cast<double>(i) / (kLegendSteps - 1), legend));
  return legend;
}

std::vector<uint8_t> channel_pixels(const Film& film, const PixelRect& rect, const Legend& legend,
                                    const OutputSettings& output) {
  const auto aov = aov_of(legend.channel);
  const bool lacks_channel = aov && !film.aovs().has(*aov);
  if (legend.channel == ViewChannel::light || lacks_channel)
    return light_pixels(film, rect, output);
  const double exposure = std::exp2(output.exposure);
  std::vector<uint8_t> rgba;
  rgba.reserve(4 * static_cast<size_t>(rect.area()));
  for (int y = rect.y0; y < rect.y1; ++y) {
    for (int x = rect.x0; x < rect.x1; ++x) {
      const auto pixel = pixel_of(film, x, y);
      Rgb color{};
      if (legend.is_scale) {
        const double value = scale_value(pixel, film.aovs(), legend.channel, exposure);
        if (std::isfinite(value)) color = scale_color(share_of(value, legend));
      } else if (legend.channel == ViewChannel::id) {
        color = color_of_id(pixel[static_cast<size_t>(film.aovs().first_channel(Aov::id))]);
      } else {
        color = vector_color(pixel, film, legend);
      }
      rgba.insert(rgba.end(), {color[0], color[1], color[2], uint8_t{255}});
    }
  }
  return rgba;
}

}  // namespace tessera
