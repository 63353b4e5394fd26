#include "image/plain/icc_profile.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <string>
#include <string_view>

#include "renderer/math/elementary.h"

namespace tessera {
namespace {

using Bytes = std::span<const unsigned char>;
using Rgb = std::array<double, 3>;

uint32_t big_endian(Bytes bytes, size_t at, size_t size) {
  uint32_t value = 0;
  for (size_t i = 0; i < size; ++i) value = value << 8 | bytes[at + i];
  return value;
}
double fixed(Bytes bytes, size_t at) {
  return static_cast<int32_t>(big_endian(bytes, at, 4)) / 65536.0;
}
bool has_name(Bytes bytes, size_t at, std::string_view name) {
  return std::equal(name.begin(), name.end(), bytes.begin() + static_cast<std::ptrdiff_t>(at));
}

/// The data of a tag, at least `least` bytes; else empty.
Bytes tag(Bytes profile, std::string_view name, size_t least) {
  constexpr size_t kTable = 132, kEntry = 12;
  const size_t count = big_endian(profile, 128, 4);
  for (size_t at = kTable; at + kEntry <= profile.size() && at < kTable + count * kEntry;
       at += kEntry) {
    if (!has_name(profile, at, name)) continue;
    const size_t offset = big_endian(profile, at + 4, 4), size = big_endian(profile, at + 8, 4);
    const bool fits = offset <= profile.size() && size <= profile.size() - offset;
    return fits && size >= least ? profile.subspan(offset, size) : Bytes{};
  }
  return {};
}

/// parametricCurveType (10.15).
double parametric(uint32_t kind, const std::array<double, 7>& p, double x) {
  const auto power = [&](double v) { return portable::pow(std::max(v, 0.0), p[0]); };
  if (kind == 0) return power(x);
  const double a = p[1], b = p[2], c = p[3], e = p[5], f = p[6];
  const double start = kind <= 2 ? -b / a : p[4];
  if (x >= start) return power(a * x + b) + (kind == 2 ? c : kind == 4 ? e : 0);
  return kind == 1 ? 0 : kind == 2 ? c : kind == 3 ? c * x : c * x + f;
}

/// The linear values of the 256 codes by a tag of type curv or para.
std::optional<std::array<double, 256>> curve(Bytes data) {
  if (data.size() < 12) return std::nullopt;
  std::array<double, 256> linear{};
  const auto fill = [&](const auto& value) {
    for (size_t i = 0; i < 256; ++i) linear[i] = value(static_cast<double>(i) / 255);
    return linear;
  };
  if (has_name(data, 0, "para")) {
    constexpr std::array<size_t, 5> kCounts{1, 3, 4, 5, 7};
    const uint32_t kind = big_endian(data, 8, 2);
    if (kind >= kCounts.size() || data.size() < 12 + 4 * kCounts[kind]) return std::nullopt;
    std::array<double, 7> p{};
    for (size_t i = 0; i < kCounts[kind]; ++i) p[i] = fixed(data, 12 + 4 * i);
    return fill([&](double x) { return parametric(kind, p, x); });
  }
  if (!has_name(data, 0, "curv")) return std::nullopt;
  const size_t count = big_endian(data, 8, 4);
  if (count == 0) return fill([](double x) { return x; });
  if (count > (data.size() - 12) / 2) return std::nullopt;
  if (count == 1) {
    const double gamma = big_endian(data, 12, 2) / 256.0;
    return fill([&](double x) { return portable::pow(x, gamma); });
  }
  return fill([&](double x) {
    const double at = x * static_cast<double>(count - 1);
    const size_t i = std::min(static_cast<size_t>(at), count - 2);
    const double low = big_endian(data, 12 + 2 * i, 2), high = big_endian(data, 14 + 2 * i, 2);
    return (low + (high - low) * (at - static_cast<double>(i))) / 65535;
  });
}

/// The 8-bit code of light in 1/65535.
unsigned char srgb_code(size_t step) {
  const double v = static_cast<double>(step) / 65535;
  const double encoded = v <= 0.0031308 ? 12.92 * v : 1.055 * portable::pow(v, 1 / 2.4) - 0.055;
  return static_cast<unsigned char>(std::lround(encoded * 255));
}

}  // namespace

std::optional<SrgbConversion> SrgbConversion::from(Bytes profile) {
  if (profile.size() < 132 || !has_name(profile, 16, "RGB ") || !has_name(profile, 20, "XYZ ")) {
    return std::nullopt;
  }
  // From the XYZ of illuminant D50, in which profiles meet, to linear sRGB (IEC 61966-2-1,
  // adapted by Bradford's matrix).
  constexpr double kToSrgb[3][3] = {{3.1338561, -1.6168667, -0.4906146},
                                    {-0.9787684, 1.9161415, 0.0334540},
                                    {0.0719453, -0.2289914, 1.4052427}};
  SrgbConversion out;
  for (size_t c = 0; c < 3; ++c) {
    const char channel = "rgb"[c];
    const Bytes xyz = tag(profile, std::string{channel} + "XYZ", 20);
    const auto linear = curve(tag(profile, std::string{channel} + "TRC", 12));
    if (xyz.empty() || !linear) return std::nullopt;
    out.linear_[c] = *linear;
    for (size_t row = 0; row < 3; ++row) {
      for (size_t k = 0; k < 3; ++k) out.matrix_[row][c] += kToSrgb[row][k] * fixed(xyz, 8 + 4 * k);
    }
  }
  out.fill_codes(0, out.codes_.size() - 1, srgb_code(0), srgb_code(out.codes_.size() - 1));
  if (out.changes_nothing()) return std::nullopt;
  return out;
}

void SrgbConversion::fill_codes(size_t first, size_t last, unsigned char low, unsigned char high) {
  // They ascend: what lies between two alike is alike.
  if (low == high || last - first < 2) {
    std::fill(codes_.begin() + static_cast<std::ptrdiff_t>(first),
              codes_.begin() + static_cast<std::ptrdiff_t>(last), low);
    codes_[last] = high;
    return;
  }
  const size_t middle = first + (last - first) / 2;
  const unsigned char code = srgb_code(middle);
  fill_codes(first, middle, low, code);
  fill_codes(middle, last, code, high);
}

std::array<unsigned char, 3> SrgbConversion::converted(const unsigned char* rgb) const {
  std::array<unsigned char, 3> out{};
  const Rgb linear{linear_[0][rgb[0]], linear_[1][rgb[1]], linear_[2][rgb[2]]};
  for (size_t c = 0; c < 3; ++c) {
    const auto& row = matrix_[c];
    const double v = row[0] * linear[0] + row[1] * linear[1] + row[2] * linear[2];
    out[c] = codes_[static_cast<size_t>(std::lround(std::clamp(v, 0.0, 1.0) * kSteps))];
  }
  return out;
}

bool SrgbConversion::changes_nothing() const {
  for (int i = 0; i < 512; ++i) {
    const auto probe = [](int step) { return static_cast<unsigned char>(step * 255 / 7); };
    const unsigned char rgb[3] = {probe(i % 8), probe(i / 8 % 8), probe(i / 64)};
    const auto result = converted(rgb);
    for (size_t c = 0; c < 3; ++c) {
      if (std::abs(int{result[c]} - int{rgb[c]}) > 1) return false;
    }
  }
  return true;
}

void SrgbConversion::convert(std::span<char> pixels, size_t channels) const {
  auto* const values = reinterpret_cast<unsigned char*>(pixels.data());
  for (size_t at = 0; at + channels <= pixels.size(); at += channels) {
    const auto rgb = converted(values + at);
    std::copy(rgb.begin(), rgb.end(), values + at);
  }
}

}  // namespace tessera
