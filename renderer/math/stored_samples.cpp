#include "renderer/math/stored_samples.h"

#include <algorithm>
#include <cmath>
#include <cstring>
#include <limits>
#include <string_view>
#include <utility>

#include "renderer/math/encodings.h"

namespace tessera {
namespace {

enum class Role : uint8_t { red, green, blue, alpha, luminance, red_chroma, blue_chroma, x, other };

std::string lower(std::string_view text) {
  std::string out(text);
  for (char& c : out) {
    if (c >= 'A' && c <= 'Z') c = static_cast<char>(c - 'A' + 'a');
  }
  return out;
}

Role role_of(std::string_view name) {
  constexpr std::array<std::pair<std::string_view, Role>, 15> kNames{{{"r", Role::red},
                                                                      {"red", Role::red},
                                                                      {"g", Role::green},
                                                                      {"green", Role::green},
                                                                      {"b", Role::blue},
                                                                      {"blue", Role::blue},
                                                                      {"a", Role::alpha},
                                                                      {"alpha", Role::alpha},
                                                                      {"y", Role::luminance},
                                                                      {"i", Role::luminance},
                                                                      {"grey", Role::luminance},
                                                                      {"gray", Role::luminance},
                                                                      {"ry", Role::red_chroma},
                                                                      {"by", Role::blue_chroma},
                                                                      {"x", Role::x}}};
  const std::string known = lower(name);
  const auto found =
      std::find_if(kNames.begin(), kNames.end(), [&](const auto& n) { return n.first == known; });
  return found == kNames.end() ? Role::other : found->second;
}

constexpr int kNoColor = 4;

/// The channels that have one layer's name before their own.
struct Layer {
  std::string_view name;  ///< empty: none
  std::array<std::optional<uint32_t>, static_cast<size_t>(Role::other)> channels{};

  std::optional<uint32_t> operator[](Role role) const {
    // Beside an X a Y is no luminance, but another coordinate.
    if (role == Role::luminance && channels[static_cast<size_t>(Role::x)]) return std::nullopt;
    return channels[static_cast<size_t>(role)];
  }
  int colors() const {
    return int{(*this)[Role::red].has_value()} + int{(*this)[Role::green].has_value()} +
           int{(*this)[Role::blue].has_value()};
  }
  bool has_color() const { return colors() > 0 || (*this)[Role::luminance]; }
  bool is_main() const {
    const size_t dot = name.rfind('.');
    const std::string last = lower(dot == name.npos ? name : name.substr(dot + 1));
    return last == "combined" || last == "rgba" || last == "beauty";
  }
  /// As color_rank() tells.
  int rank() const {
    if (!has_color()) return kNoColor;
    if (name.empty()) return 0;
    if (is_main()) return 1;
    return colors() == 3 ? 2 : 3;
  }
};

std::vector<Layer> layers_of(std::span<const std::string> names) {
  std::vector<Layer> layers;
  for (uint32_t i = 0; i < names.size(); ++i) {
    const std::string_view name = names[i];
    const size_t dot = name.rfind('.');
    const std::string_view layer = dot == name.npos ? "" : name.substr(0, dot);
    const Role role = role_of(dot == name.npos ? name : name.substr(dot + 1));
    if (role == Role::other) continue;
    auto at = std::find_if(layers.begin(), layers.end(),
                           [&](const Layer& known) { return known.name == layer; });
    if (at == layers.end()) at = layers.insert(layers.end(), Layer{.name = layer});
    auto& channel = at->channels[static_cast<size_t>(role)];
    if (!channel) channel = i;
  }
  return layers;
}

std::vector<Layer>::const_iterator best_of(const std::vector<Layer>& layers) {
  return std::min_element(layers.begin(), layers.end(),
                          [](const Layer& a, const Layer& b) { return a.rank() < b.rank(); });
}

ColorChannels channels_of(const Layer& layer) {
  using Kind = ColorChannels::Kind;
  ColorChannels out;
  out.alpha = layer[Role::alpha];
  const auto luminance = layer[Role::luminance];
  if (layer.colors() >= 2) {
    out.kind = Kind::rgb;
    out.colors = {layer[Role::red], layer[Role::green], layer[Role::blue]};
  } else if (luminance && layer[Role::red_chroma] && layer[Role::blue_chroma]) {
    out.kind = Kind::luminance_chroma;
    out.colors = {luminance, layer[Role::red_chroma], layer[Role::blue_chroma]};
  } else {
    for (const Role role : {Role::luminance, Role::red, Role::green, Role::blue}) {
      if (!out.colors[0]) out.colors[0] = layer[role];
    }
  }
  return out;
}

/// Decodes floats that mostly come again and again, as those from integers do.
class SrgbDecoder {
 public:
  float operator()(float code) {
    if (!(code >= 0 && code <= 1)) return decode(code);
    Known& known = known_[static_cast<size_t>(code * kMost)];
    if (!known.is_there || known.code != code) known = {true, code, decode(code)};
    return known.light;
  }

 private:
  struct Known {
    bool is_there = false;
    float code = 0, light = 0;
  };
  /// Beyond 0 to 1 the curve goes on, and is odd.
  static float decode(float code) {
    const double light = srgb_to_linear(std::abs(double{code}));
    constexpr auto kMostFloat = double{std::numeric_limits<float>::max()};
    const float near =
        light > kMostFloat ? std::numeric_limits<float>::infinity() : static_cast<float>(light);
    return std::signbit(code) ? -near : near;
  }

  static constexpr float kMost = 65535;
  std::vector<Known> known_ = std::vector<Known>(65536);
};

}  // namespace

std::vector<std::optional<uint32_t>> ColorChannels::in_order() const {
  std::vector<std::optional<uint32_t>> order{colors[0]};
  if (kind != Kind::grey) order.insert(order.end(), {colors[1], colors[2]});
  if (alpha) order.push_back(alpha);
  return order;
}

ColorChannels color_channels_of(std::span<const std::string> names) {
  const std::vector<Layer> layers = layers_of(names);
  const auto best = best_of(layers);
  if (best != layers.end() && best->has_color()) return channels_of(*best);
  ColorChannels out;
  std::vector<uint32_t> others;
  for (uint32_t i = 0; i < names.size(); ++i) {
    const bool is_alpha = role_of(names[i]) == Role::alpha && names.size() > 1;
    if (is_alpha && !out.alpha)
      out.alpha = i;
    else
      others.push_back(i);
  }
  if (others.size() >= 3) out.kind = ColorChannels::Kind::rgb;
  for (size_t i = 0; i < (others.size() >= 3 ? 3 : 1); ++i) out.colors[i] = others[i];
  return out;
}

int color_rank(std::span<const std::string> names) {
  const std::vector<Layer> layers = layers_of(names);
  const auto best = best_of(layers);
  return best == layers.end() ? kNoColor : best->rank();
}

void samples_to_floats(std::span<const std::byte> samples, uint32_t bits, std::span<float> floats) {
  if (bits == 32) {
    std::memcpy(floats.data(), samples.data(), floats.size_bytes());
  } else if (bits == 16) {
    for (size_t i = 0; i < floats.size(); ++i) {
      uint16_t half = 0;
      std::memcpy(&half, &samples[i * sizeof half], sizeof half);
      floats[i] = half_to_float(half);
    }
  } else {
    for (size_t i = 0; i < floats.size(); ++i) floats[i] = static_cast<float>(samples[i]) / 255;
  }
}

void luminance_chroma_to_rgb(std::span<float> pixels, uint32_t channels) {
  constexpr float kRed = .2126f, kGreen = .7152f, kBlue = .0722f;
  for (size_t at = 0; at + channels <= pixels.size(); at += channels) {
    const float y = pixels[at];
    const float red = (pixels[at + 1] + 1) * y, blue = (pixels[at + 2] + 1) * y;
    pixels[at] = red;
    pixels[at + 1] = (y - kRed * red - kBlue * blue) / kGreen;
    pixels[at + 2] = blue;
  }
}

bool holds_codes(SampleMeaning meaning, SampleEncoding encoding) {
  return encoding == SampleEncoding::srgb ||
         (encoding == SampleEncoding::automatic && meaning.from_integers);
}

void decode_samples(std::span<float> samples, uint32_t channels, SampleMeaning meaning,
                    SampleEncoding encoding) {
  if (!holds_codes(meaning, encoding)) return;
  const bool has_alpha = channels % 2 == 0;
  const uint32_t colors = has_alpha ? channels - 1 : channels;
  SrgbDecoder light_of;
  for (size_t at = 0; at + channels <= samples.size(); at += channels) {
    const float alpha = has_alpha && meaning.is_associated ? samples[at + colors] : 1;
    for (size_t i = at; i < at + colors; ++i) {
      samples[i] = alpha > 0 ? light_of(samples[i] / alpha) * alpha : light_of(samples[i]);
    }
  }
}

}  // namespace tessera
