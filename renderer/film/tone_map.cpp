#include "renderer/film/tone_map.h"

#include <algorithm>
#include <cmath>
#include <limits>

#include "base/parallel.h"
#include "base/process.h"
#include "renderer/math/elementary.h"

namespace tessera {

namespace {

using Rgb = std::array<double, 3>;

double luminance(const Rgb& c) { return 0.2126 * c[0] + 0.7152 * c[1] + 0.0722 * c[2]; }

double reinhard(double x) { return x <= 0 ? x : x / (1 + x); }

double filmic(double x) {
  x = std::max(x, 0.0);
  return x * (2.51 * x + 0.03) / (x * (2.43 * x + 0.59) + 0.14);
}

Rgb apply_curve(ToneCurve curve, Rgb c) {
  switch (curve) {
    case ToneCurve::clamp:
    case ToneCurve::linear:
      break;
    case ToneCurve::reinhard:
      for (double& v : c) v = reinhard(v);
      break;
    case ToneCurve::reinhard_luminance: {
      const double y = luminance(c);
      if (y > 0) {
        for (double& v : c) v /= 1 + y;
      }
      break;
    }
    case ToneCurve::filmic:
      for (double& v : c) v = filmic(v);
      break;
  }
  return c;
}

double apply_transfer(const OutputSettings& settings, double v) {
  switch (settings.transfer) {
    case TransferCurve::display:
      return v;
    case TransferCurve::gamma:
      return portable::pow(v, 1 / settings.gamma);
    case TransferCurve::srgb:
      break;
  }
  // IEC 61966-2-1. White is exempt: 1.055 - 0.055 rounds to less than 1, which would truncate to
  // 254.
  if (v >= 1) return 1;
  return v <= 0.0031308 ? 12.92 * v : 1.055 * portable::pow(v, 1 / 2.4) - 0.055;
}

/// A finite stand-in, far above what any curve tells from its limit, so that no curve meets
/// inf/inf.
double finite(double v) {
  constexpr double kLargest = 1e30;
  return std::isnan(v) ? 0.0 : std::clamp(v, -kLargest, kLargest);
}

double exposure_scale(const OutputSettings& settings) {
  constexpr double kLogTwo = 0.69314718055994530942;
  return settings.exposure == 0 ? 1.0 : portable::exp(settings.exposure * kLogTwo);
}

/// All but the transfer curve, in [0, 1].
Rgb before_transfer(const OutputSettings& settings, double scale, const float* linear) {
  Rgb c{};
  for (size_t i = 0; i < c.size(); ++i) c[i] = finite(scale * finite(double{linear[i]}));
  c = apply_curve(settings.tone_curve, c);
  for (double& v : c) {
    v = std::clamp(v, 0.0, 1.0);
    if (settings.has_response) {
      const auto& [a, b, constant] = settings.response;
      v = std::clamp((a * v + b) * v + constant, 0.0, 1.0);
    }
  }
  return c;
}

template <typename Integer, typename Convert>
std::vector<Integer> convert(const Film& film, const OutputSettings& settings, Convert to_integer) {
  const std::span<const float> values = film.values();
  const double scale = exposure_scale(settings);
  std::vector<Integer> result(values.size());
  constexpr size_t kPart = size_t{1 << 15} * kFilmChannels;
  const bool is_plain =
      scale == 1 && !settings.has_response &&
      (settings.tone_curve == ToneCurve::clamp || settings.tone_curve == ToneCurve::linear);
  const auto convert_part = [&](size_t part) {
    const size_t end = std::min(values.size(), (part + 1) * kPart);
    if (is_plain) {  // what before_transfer() comes to
      for (size_t i = part * kPart; i < end; ++i) {
        const double v = values[i];
        result[i] = to_integer(v > 0 ? std::min(v, 1.0) : 0.0);
      }
      return;
    }
    for (size_t i = part * kPart; i < end; i += kFilmChannels) {
      const Rgb mapped = before_transfer(settings, scale, &values[i]);
      for (size_t c = 0; c < kFilmChannels; ++c) result[i + c] = to_integer(mapped[c]);
    }
  };
  for_each_parallel((values.size() + kPart - 1) / kPart, core_count(), convert_part);
  return result;
}

double transferred(const OutputSettings& settings, double v) {
  return std::clamp(apply_transfer(settings, v), 0.0, 1.0);
}

/// `value` in [0, 1] to an integer, whose largest value stands for 1.
template <typename Integer>
Integer quantize(double value, Quantization how) {
  const double scaled = value * std::numeric_limits<Integer>::max();
  return static_cast<Integer>(how == Quantization::round ? scaled + 0.5 : scaled);
}

/// The transfer curve and the quantization as a function from [0, 1] to bytes. A power a pixel
/// would take longer than tracing a simple scene.
class ByteTable {
 public:
  explicit ByteTable(const OutputSettings& settings)
      : transfer_(settings.transfer), gamma_(settings.gamma), quantization_(settings.quantization) {
    double low = 0;
    for (uint32_t byte = 1; byte <= 255; ++byte) {
      double high = 1;
      // Bisection down to neighbouring doubles.
      while (true) {
        const double middle = low + (high - low) / 2;
        if (middle <= low || middle >= high) break;
        const bool reached =
            quantize<uint8_t>(transferred(settings, middle), settings.quantization) >= byte;
        (reached ? high : low) = middle;
      }
      thresholds_[byte - 1] = high;
    }
    for (size_t cell = 0; cell <= kCells; ++cell) {
      const double value = static_cast<double>(cell) / kCells;
      first_[cell] = static_cast<uint8_t>(
          std::upper_bound(thresholds_.begin(), thresholds_.end(), value) - thresholds_.begin());
    }
  }

  bool is_of(const OutputSettings& settings) const {
    return transfer_ == settings.transfer && gamma_ == settings.gamma &&
           quantization_ == settings.quantization;
  }
  uint8_t byte_of(double value) const {
    uint8_t byte = first_[static_cast<size_t>(value * kCells)];
    while (byte < thresholds_.size() && thresholds_[byte] <= value) ++byte;
    return byte;
  }

 private:
  TransferCurve transfer_;
  double gamma_;
  Quantization quantization_;
  /// The smallest values whose transferred and quantized value is 1, 2, ... 255.
  std::array<double, 255> thresholds_{};
  /// A search for each value would be half of the time that a cheap picture takes to be written.
  /// The byte at which its cell of a fine grid begins is a step or two away at most.
  static constexpr size_t kCells = 4096;
  std::array<uint8_t, kCells + 1> first_{};
};

/// That of the settings. Making it takes milliseconds, which a view of many tiles would pay for
/// each: every thread keeps the one that it used last.
const ByteTable& byte_table(const OutputSettings& settings) {
  thread_local std::optional<ByteTable> last;
  if (!last || !last->is_of(settings)) last.emplace(settings);
  return *last;
}

}  // namespace

void expose(Film& film, const OutputSettings& settings) {
  const double scale = exposure_scale(settings);
  for (float& v : film.values()) v = static_cast<float>(finite(scale * finite(double{v})));
}

std::vector<uint8_t> to_8_bit(const Film& film, const OutputSettings& settings) {
  if (settings.transfer == TransferCurve::display) {
    return convert<uint8_t>(film, settings,
                            [&](double v) { return quantize<uint8_t>(v, settings.quantization); });
  }
  const ByteTable& table = byte_table(settings);
  return convert<uint8_t>(film, settings, [&](double v) { return table.byte_of(v); });
}

std::vector<uint16_t> to_16_bit(const Film& film, const OutputSettings& settings) {
  return convert<uint16_t>(film, settings, [&](double v) {
    return quantize<uint16_t>(transferred(settings, v), settings.quantization);
  });
}

}  // namespace tessera
