#include "bench/error/flip.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <numbers>

namespace tessera {
namespace {

/// One number a pixel.
struct Plane {
  int width, height;
  std::vector<double> values;
};

/// Weights from -radius to radius along one axis.
using Kernel = std::vector<double>;
using Triple = std::array<double, 3>;

constexpr std::array<Triple, 3> kXyzOfRgb{
    {{10135552. / 24577794, 8788810. / 24577794, 4435075. / 24577794},
     {2613072. / 12288897, 8788810. / 12288897, 887015. / 12288897},
     {1425312. / 73733382, 8788810. / 73733382, 70074185. / 73733382}}};

Triple times(const std::array<Triple, 3>& m, const Triple& v) {
  Triple out{};
  for (size_t i = 0; i < 3; ++i) out[i] = m[i][0] * v[0] + m[i][1] * v[1] + m[i][2] * v[2];
  return out;
}

std::array<Triple, 3> inverse(const std::array<Triple, 3>& m) {
  std::array<Triple, 3> out{};
  for (size_t i = 0; i < 3; ++i) {
    for (size_t j = 0; j < 3; ++j) {
      const size_t a = (j + 1) % 3, b = (j + 2) % 3, c = (i + 1) % 3, d = (i + 2) % 3;
      out[i][j] = m[a][c] * m[b][d] - m[a][d] * m[b][c];
    }
  }
  const double determinant = m[0][0] * out[0][0] + m[0][1] * out[1][0] + m[0][2] * out[2][0];
  for (Triple& row : out)
    for (double& value : row) value /= determinant;
  return out;
}

const Triple kWhiteXyz = times(kXyzOfRgb, {1, 1, 1});
const std::array<Triple, 3> kRgbOfXyz = inverse(kXyzOfRgb);

/// XYZ over its white.
Triple relative_xyz(const Triple& rgb) {
  Triple out = times(kXyzOfRgb, rgb);
  for (size_t i = 0; i < 3; ++i) out[i] /= kWhiteXyz[i];
  return out;
}

/// Linear opponent colours.
Triple ycxcz(const Triple& rgb) {
  const Triple t = relative_xyz(rgb);
  return {116 * t[1] - 16, 500 * (t[0] - t[1]), 200 * (t[1] - t[2])};
}

Triple rgb_of_ycxcz(const Triple& c) {
  const double y = (c[0] + 16) / 116;
  return times(kRgbOfXyz, {(y + c[1] / 500) * kWhiteXyz[0], y * kWhiteXyz[1],
                           (y - c[2] / 200) * kWhiteXyz[2]});
}

/// CIE L*a*b*, its colourfulness made to fall with luminance as Hunt saw it.
Triple hunt_lab(const Triple& rgb) {
  constexpr double kDelta = 6. / 29;
  Triple t = relative_xyz(rgb);
  for (double& v : t)
    v = v > kDelta * kDelta * kDelta ? std::cbrt(v) : v / (3 * kDelta * kDelta) + 4. / 29;
  const double lightness = 116 * t[1] - 16;
  return {lightness, .01 * lightness * 500 * (t[0] - t[1]), .01 * lightness * 200 * (t[1] - t[2])};
}

/// HyAB: city block in lightness, Euclidean in colour.
double hyab(const Triple& a, const Triple& b) {
  return std::abs(a[0] - b[0]) + std::hypot(a[1] - b[1], a[2] - b[2]);
}

double dot_at(const Kernel& kernel, const double* line, int stride, int at, int size) {
  const int radius = static_cast<int>(kernel.size() / 2);
  double sum = 0;
  for (size_t k = 0; k < kernel.size(); ++k) {
    const int place = std::clamp(at + static_cast<int>(k) - radius, 0, size - 1);
    sum += kernel[k] * line[std::ptrdiff_t{place} * stride];
  }
  return sum;
}

/// Rows through `along_x`, then columns through `along_y`; the border's pixels go on outside.
Plane filtered(const Plane& in, const Kernel& along_x, const Kernel& along_y) {
  Plane half = in, out = in;
  for (int y = 0; y < in.height; ++y)
    for (int x = 0; x < in.width; ++x)
      half.values[static_cast<size_t>(y) * in.width + x] =
          dot_at(along_x, in.values.data() + static_cast<size_t>(y) * in.width, 1, x, in.width);
  for (int y = 0; y < in.height; ++y)
    for (int x = 0; x < in.width; ++x)
      out.values[static_cast<size_t>(y) * in.width + x] =
          dot_at(along_y, half.values.data() + x, in.width, y, in.height);
  return out;
}

/// exp(-pi^2 x^2 / b), x in degrees, not normalised.
Kernel gaussian(double b, int radius, double pixels_per_degree) {
  Kernel out;
  for (int i = -radius; i <= radius; ++i) {
    const double x = i / pixels_per_degree;
    out.push_back(std::exp(-std::numbers::pi * std::numbers::pi * x * x / b));
  }
  return out;
}

double sum_of(const Kernel& kernel) {
  double sum = 0;
  for (const double weight : kernel) sum += weight;
  return sum;
}

Kernel normalized(Kernel kernel) {
  const double sum = sum_of(kernel);
  for (double& weight : kernel) weight /= sum;
  return kernel;
}

/// The eye's contrast sensitivity in one opponent colour (the paper): Gaussians
/// of weight a sqrt(pi / b), together of sum 1.
Plane sensitivity_filtered(const Plane& in, std::initializer_list<std::pair<double, double>> terms,
                           double pixels_per_degree) {
  constexpr double kWidest = .04;
  const int radius = static_cast<int>(std::ceil(
      3 * std::sqrt(kWidest / (2 * std::numbers::pi * std::numbers::pi)) * pixels_per_degree));
  double total = 0;
  Plane out{in.width, in.height, std::vector<double>(in.values.size())};
  for (const auto& [a, b] : terms) {
    const Kernel kernel = gaussian(b, radius, pixels_per_degree);
    const double weight = a * std::sqrt(std::numbers::pi / b) * sum_of(kernel) * sum_of(kernel);
    const Plane part = filtered(in, normalized(kernel), normalized(kernel));
    for (size_t i = 0; i < out.values.size(); ++i) out.values[i] += weight * part.values[i];
    total += weight;
  }
  for (double& value : out.values) value /= total;
  return out;
}

/// Positive weights of sum 1, negative ones of sum -1.
Kernel balanced(Kernel kernel) {
  double positive = 0, negative = 0;
  for (const double weight : kernel) (weight > 0 ? positive : negative) += weight;
  for (double& weight : kernel) weight /= weight > 0 ? positive : -negative;
  return kernel;
}

/// How strongly each pixel is part of an edge, or of a point.
std::vector<double> feature(const Plane& luminance, bool points, double pixels_per_degree) {
  const double deviation = .5 * .082 * pixels_per_degree;
  const int radius = static_cast<int>(std::ceil(3 * deviation));
  Kernel smooth, derivative;
  for (int i = -radius; i <= radius; ++i) {
    const double g = std::exp(-i * i / (2 * deviation * deviation));
    smooth.push_back(g);
    derivative.push_back(points ? (i * i / (deviation * deviation) - 1) * g : -i * g);
  }
  smooth = normalized(smooth);
  derivative = balanced(derivative);
  const Plane along_x = filtered(luminance, derivative, smooth);
  const Plane along_y = filtered(luminance, smooth, derivative);
  std::vector<double> out(luminance.values.size());
  for (size_t i = 0; i < out.size(); ++i) out[i] = std::hypot(along_x.values[i], along_y.values[i]);
  return out;
}

/// All that FLIP wants to know of one picture.
struct Seen {
  std::vector<Triple> colors;  ///< as through the eye, in Hunt-adjusted L*a*b*
  std::vector<double> edges, points;
};

Seen see(const Picture& picture, double pixels_per_degree) {
  std::array<Plane, 3> planes;
  for (Plane& plane : planes)
    plane = {picture.width, picture.height, std::vector<double>(picture.pixels())};
  for (size_t i = 0; i < picture.pixels(); ++i) {
    Triple rgb;
    for (size_t c = 0; c < 3; ++c) {
      const float value = picture.values[3 * i + c];
      rgb[c] = std::isnan(value) ? 0 : std::clamp(double{value}, 0.0, 1.0);
    }
    const Triple opponent = ycxcz(rgb);
    for (size_t c = 0; c < 3; ++c) planes[c].values[i] = opponent[c];
  }
  Seen out;
  Plane luminance = planes[0];
  for (double& value : luminance.values) value = (value + 16) / 116;
  out.edges = feature(luminance, false, pixels_per_degree);
  out.points = feature(luminance, true, pixels_per_degree);
  planes[0] = sensitivity_filtered(planes[0], {{1, .0047}}, pixels_per_degree);
  planes[1] = sensitivity_filtered(planes[1], {{1, .0053}}, pixels_per_degree);
  planes[2] = sensitivity_filtered(planes[2], {{34.1, .04}, {13.5, .025}}, pixels_per_degree);
  for (size_t i = 0; i < picture.pixels(); ++i) {
    Triple rgb = rgb_of_ycxcz({planes[0].values[i], planes[1].values[i], planes[2].values[i]});
    for (double& value : rgb) value = std::clamp(value, 0.0, 1.0);
    out.colors.push_back(hunt_lab(rgb));
  }
  return out;
}

/// The colour difference raised to .7, its usual range spread over [0, .95].
double color_error(const Triple& a, const Triple& b) {
  constexpr double kExponent = .7, kUsualShare = .4, kUsualTop = .95;
  static const double greatest =
      std::pow(hyab(hunt_lab({0, 1, 0}), hunt_lab({0, 0, 1})), kExponent);
  const double usual = kUsualShare * greatest, error = std::pow(hyab(a, b), kExponent);
  const double spread = error < usual
                            ? kUsualTop * error / usual
                            : kUsualTop + (1 - kUsualTop) * (error - usual) / (greatest - usual);
  return std::clamp(spread, 0.0, 1.0);
}

}  // namespace

std::vector<float> flip_map(const Picture& a, const Picture& b, double pixels_per_degree) {
  const Seen first = see(a, pixels_per_degree), second = see(b, pixels_per_degree);
  std::vector<float> out;
  out.reserve(first.colors.size());
  for (size_t i = 0; i < first.colors.size(); ++i) {
    const double difference = std::max(std::abs(first.edges[i] - second.edges[i]),
                                       std::abs(first.points[i] - second.points[i]));
    const double features = std::clamp(std::sqrt(difference / std::numbers::sqrt2), 0.0, 1.0);
    out.push_back(
        static_cast<float>(std::pow(color_error(first.colors[i], second.colors[i]), 1 - features)));
  }
  return out;
}

double mean_flip(const Picture& a, const Picture& b, const PixelMask& mask,
                 double pixels_per_degree) {
  const std::vector<float> map = flip_map(a, b, pixels_per_degree);
  double sum = 0;
  size_t count = 0;
  for (size_t i = 0; i < map.size(); ++i) {
    if (!counts(mask, i)) continue;
    sum += double{map[i]};
    ++count;
  }
  return sum / static_cast<double>(count);
}

}  // namespace tessera
