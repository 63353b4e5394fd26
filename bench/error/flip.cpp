#include "bench/error/flip.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <numbers>

#include "base/core_count.h"
#include "base/parallel.h"

namespace tessera {
namespace {

/// One number a pixel.
struct Plane {
  Plane(int w, int h)
      : width(static_cast<size_t>(w)), height(static_cast<size_t>(h)), values(width * height) {}
  float* row(size_t y) { return values.data() + y * width; }
  const float* row(size_t y) const { return values.data() + y * width; }

  size_t width, height;
  std::vector<float> values;
};

/// Calls work(y) for each row on all processors.
template <typename Work>
void for_each_row(size_t height, const Work& work) {
  constexpr size_t kRowsOfPiece = 16;
  for_each_piece_parallel(height, kRowsOfPiece, core_count(), [&](size_t begin, size_t end) {
    for (size_t y = begin; y < end; ++y) work(y);
  });
}

/// Weights from -radius to radius along one axis.
using Kernel = std::vector<double>;
using Triple = std::array<double, 3>;
using Color = std::array<float, 3>;

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
Color hunt_lab(const Triple& rgb) {
  constexpr float kDelta = 6.F / 29;
  const Triple xyz = relative_xyz(rgb);
  Color t;
  for (size_t i = 0; i < 3; ++i) {
    const auto v = static_cast<float>(xyz[i]);
    t[i] = v > kDelta * kDelta * kDelta ? std::cbrt(v) : v / (3 * kDelta * kDelta) + 4.F / 29;
  }
  const float lightness = 116 * t[1] - 16;
  return {lightness, .01F * lightness * 500 * (t[0] - t[1]),
          .01F * lightness * 200 * (t[1] - t[2])};
}

/// HyAB: city block in lightness, Euclidean in colour.
float hyab(const Color& a, const Color& b) {
  const float u = a[1] - b[1], v = a[2] - b[2];
  return std::abs(a[0] - b[0]) + std::sqrt(u * u + v * v);
}

/// out[x] += weight * in[x]
void add_weighted(float* out, float weight, const float* in, size_t count) {
  for (size_t x = 0; x < count; ++x) out[x] += weight * in[x];
}

/// Rows through `along_x`, then columns through `along_y`, into `out`; the border's pixels go on
/// outside. `half`: a buffer of the same size for the intermediate plane.
void filter(const Plane& in, const Kernel& along_x, const Kernel& along_y, Plane& half,
            Plane& out) {
  const size_t width = in.width, height = in.height, radius = along_x.size() / 2;
  for_each_row(height, [&](size_t y) {
    std::vector<float> line(width + 2 * radius, in.row(y)[0]);
    std::copy_n(in.row(y), width, line.begin() + static_cast<std::ptrdiff_t>(radius));
    std::fill(line.end() - static_cast<std::ptrdiff_t>(radius), line.end(), in.row(y)[width - 1]);
    std::fill_n(half.row(y), width, 0.F);
    for (size_t k = 0; k < along_x.size(); ++k)
      add_weighted(half.row(y), static_cast<float>(along_x[k]), line.data() + k, width);
  });
  for_each_row(height, [&](size_t y) {
    std::fill_n(out.row(y), width, 0.F);
    for (size_t k = 0; k < along_y.size(); ++k) {
      const size_t place = std::clamp(y + k, radius, radius + height - 1) - radius;
      add_weighted(out.row(y), static_cast<float>(along_y[k]), half.row(place), width);
    }
  });
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
                           double pixels_per_degree, Plane& half, Plane& part) {
  constexpr double kWidest = .04;
  const int radius = static_cast<int>(std::ceil(
      3 * std::sqrt(kWidest / (2 * std::numbers::pi * std::numbers::pi)) * pixels_per_degree));
  double total = 0;
  std::vector<double> weights;
  for (const auto& [a, b] : terms) {
    const double sum = sum_of(gaussian(b, radius, pixels_per_degree));
    weights.push_back(a * std::sqrt(std::numbers::pi / b) * sum * sum);
    total += weights.back();
  }
  Plane out(static_cast<int>(in.width), static_cast<int>(in.height));
  size_t term = 0;
  for (const auto& [a, b] : terms) {
    const Kernel kernel = normalized(gaussian(b, radius, pixels_per_degree));
    filter(in, kernel, kernel, half, part);
    const auto weight = static_cast<float>(weights[term++] / total);
    for_each_row(out.height,
                 [&](size_t y) { add_weighted(out.row(y), weight, part.row(y), out.width); });
  }
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
Plane feature(const Plane& luminance, bool points, double pixels_per_degree, Plane& half,
              Plane& along_y) {
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
  Plane out(static_cast<int>(luminance.width), static_cast<int>(luminance.height));
  filter(luminance, derivative, smooth, half, out);
  filter(luminance, smooth, derivative, half, along_y);
  for_each_row(out.height, [&](size_t y) {
    for (size_t x = 0; x < out.width; ++x) {
      const float a = out.row(y)[x], b = along_y.row(y)[x];
      out.row(y)[x] = std::sqrt(a * a + b * b);
    }
  });
  return out;
}

/// All that FLIP wants to know of one picture.
struct Seen {
  std::array<Plane, 3> colors;  ///< as through the eye, in Hunt-adjusted L*a*b*
  Plane edges, points;
};

Seen see(const Picture& picture, double pixels_per_degree) {
  const Plane empty(picture.width, picture.height);
  std::array<Plane, 3> planes{empty, empty, empty};
  Plane luminance = empty;
  for_each_row(empty.height, [&](size_t y) {
    const float* value = picture.values.data() + 3 * y * empty.width;
    for (size_t x = 0; x < empty.width; ++x) {
      Triple rgb;
      for (double& v : rgb)
        v = std::isnan(*value) ? 0 : std::clamp(double{*value}, 0.0, 1.0), ++value;
      const Triple opponent = ycxcz(rgb);
      for (size_t c = 0; c < 3; ++c) planes[c].row(y)[x] = static_cast<float>(opponent[c]);
      luminance.row(y)[x] = static_cast<float>((opponent[0] + 16) / 116);
    }
  });
  Plane half = empty, part = empty;
  Seen out{{empty, empty, empty},
           feature(luminance, false, pixels_per_degree, half, part),
           feature(luminance, true, pixels_per_degree, half, part)};
  const auto filtered = [&](const Plane& in,
                            std::initializer_list<std::pair<double, double>> terms) {
    return sensitivity_filtered(in, terms, pixels_per_degree, half, part);
  };
  planes[0] = filtered(planes[0], {{1, .0047}});
  planes[1] = filtered(planes[1], {{1, .0053}});
  planes[2] = filtered(planes[2], {{34.1, .04}, {13.5, .025}});
  for_each_row(empty.height, [&](size_t y) {
    for (size_t x = 0; x < empty.width; ++x) {
      Triple rgb = rgb_of_ycxcz({planes[0].row(y)[x], planes[1].row(y)[x], planes[2].row(y)[x]});
      for (double& value : rgb) value = std::clamp(value, 0.0, 1.0);
      const Color lab = hunt_lab(rgb);
      for (size_t c = 0; c < 3; ++c) out.colors[c].row(y)[x] = lab[c];
    }
  });
  return out;
}

/// The colour difference raised to .7, its usual range spread over [0, .95].
float color_error(const Color& a, const Color& b) {
  constexpr float kExponent = .7F, kUsualShare = .4F, kUsualTop = .95F;
  static const float greatest = std::pow(hyab(hunt_lab({0, 1, 0}), hunt_lab({0, 0, 1})), kExponent);
  const float usual = kUsualShare * greatest, error = std::pow(hyab(a, b), kExponent);
  const float spread = error < usual
                           ? kUsualTop * error / usual
                           : kUsualTop + (1 - kUsualTop) * (error - usual) / (greatest - usual);
  return std::clamp(spread, 0.F, 1.F);
}

}  // namespace

std::vector<float> flip_map(const Picture& a, const Picture& b, double pixels_per_degree) {
  const Seen first = see(a, pixels_per_degree), second = see(b, pixels_per_degree);
  std::vector<float> out(a.pixels());
  const auto color = [](const Seen& seen, size_t i) {
    return Color{seen.colors[0].values[i], seen.colors[1].values[i], seen.colors[2].values[i]};
  };
  for_each_row(first.edges.height, [&](size_t y) {
    for (size_t i = y * first.edges.width; i < (y + 1) * first.edges.width; ++i) {
      const float difference = std::max(std::abs(first.edges.values[i] - second.edges.values[i]),
                                        std::abs(first.points.values[i] - second.points.values[i]));
      const float features =
          std::clamp(std::sqrt(difference / std::numbers::sqrt2_v<float>), 0.F, 1.F);
      out[i] = std::pow(color_error(color(first, i), color(second, i)), 1 - features);
    }
  });
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
