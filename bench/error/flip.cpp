#include "bench/error/flip.h"

#include <algorithm>
#include <array>
#include <bit>
#include <cmath>
#include <cstdint>
#include <numbers>
#include <numeric>
#include <utility>
#include <vector>

#include "base/core_count.h"
#include "base/parallel.h"
#include "bench/error/weighted_sum.h"

namespace tessera {
namespace {

/// Some rows of a picture, one number a pixel.
struct Rows {
  Rows() = default;
  Rows(size_t w, size_t most) : width(w), values(width * most) {}
  void set(size_t from, size_t until) { first = from, end = until; }
  float* row(size_t y) { return values.data() + (y - first) * width; }
  const float* row(size_t y) const { return values.data() + (y - first) * width; }

  size_t width = 0, first = 0, end = 0;
  std::vector<float> values;
};

/// Weights from -radius to radius along one axis.
using Kernel = std::vector<float>;
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

/// Of a positive number that is not tiny, within two units in the last place. Unlike std::cbrt,
/// compilers make it run for several numbers at a time.
float cube_root(float v) {
  constexpr uint32_t kThirdOfBias = 0x2a5137a0;
  auto root = std::bit_cast<float>(std::bit_cast<uint32_t>(v) / 3 + kThirdOfBias);
  for (int i = 0; i < 2; ++i) {  // Halley's steps
    const float cube = root * root * root;
    root *= (cube + 2 * v) / (2 * cube + v);
  }
  return root;
}

/// What CIE L*a*b* takes of each relative XYZ.
float lab_response(float v) {
  constexpr float kDelta = 6.F / 29, kKnee = kDelta * kDelta * kDelta;
  const float root = cube_root(std::max(v, kKnee)), line = v / (3 * kDelta * kDelta) + 4.F / 29;
  return v > kKnee ? root : line;
}

/// CIE L*a*b* of such responses, its colourfulness made to fall with luminance as Hunt saw it.
Color hunt_lab(const Color& response) {
  const float lightness = 116 * response[1] - 16;
  return {lightness, .01F * lightness * 500 * (response[0] - response[1]),
          .01F * lightness * 200 * (response[1] - response[2])};
}

Color lab_of(const Triple& rgb) {
  const Triple xyz = relative_xyz(rgb);
  Color response;
  for (size_t i = 0; i < 3; ++i) response[i] = lab_response(static_cast<float>(xyz[i]));
  return hunt_lab(response);
}

/// HyAB: city block in lightness, Euclidean in colour.
float hyab(const Color& a, const Color& b) {
  const float u = a[1] - b[1], v = a[2] - b[2];
  return std::abs(a[0] - b[0]) + std::sqrt(u * u + v * v);
}

/// Rows through `along_x`, then columns through `along_y`, into the rows of `out`, of a picture of
/// `height` rows, whose border's pixels go on outside. `in` has those that are within reach.
/// `half`: a buffer for the intermediate rows.
void filter(const Rows& in, size_t height, const Kernel& along_x, const Kernel& along_y, Rows& half,
            Rows& out) {
  const size_t width = in.width, radius = along_x.size() / 2;
  half.set(in.first, in.end);
  std::vector<float> line(width + 2 * radius);
  std::vector<const float*> rows;
  for (size_t k = 0; k < along_x.size(); ++k) rows.push_back(line.data() + k);
  for (size_t y = in.first; y < in.end; ++y) {
    const float* const row = in.row(y);
    std::fill_n(line.begin(), radius, row[0]);
    std::copy_n(row, width, line.begin() + static_cast<std::ptrdiff_t>(radius));
    std::fill_n(line.rbegin(), radius, row[width - 1]);
    weighted_sum(half.row(y), width, along_x, rows);
  }
  for (size_t y = out.first; y < out.end; ++y) {
    for (size_t k = 0; k < along_y.size(); ++k) {
      rows[k] = half.row(std::clamp(y + k, radius, radius + height - 1) - radius);
    }
    weighted_sum(out.row(y), width, along_y, rows);
  }
}

double sum_of(const std::vector<double>& weights) {
  return std::accumulate(weights.begin(), weights.end(), 0.);
}

/// Divides positive weights by their sum, negative ones by the size of theirs.
Kernel normalized(const std::vector<double>& weights) {
  double positive = 0, negative = 0;
  for (const double weight : weights) (weight > 0 ? positive : negative) += weight;
  Kernel out;
  for (const double weight : weights) {
    out.push_back(static_cast<float>(weight / (weight > 0 ? positive : -negative)));
  }
  return out;
}

/// The eye's contrast sensitivity in one opponent colour (the paper): Gaussians, each separable,
/// whose weights have the sum 1.
struct Sensitivity {
  std::vector<Kernel> kernels;
  Kernel weights;
};

/// `terms`: a and b of a sqrt(pi / b) exp(-pi^2 x^2 / b), x in degrees.
Sensitivity sensitivity(const std::vector<std::pair<double, double>>& terms,
                        double pixels_per_degree) {
  constexpr double kPi = std::numbers::pi, kWidest = .04;
  const int radius =
      static_cast<int>(std::ceil(3 * std::sqrt(kWidest / (2 * kPi * kPi)) * pixels_per_degree));
  Sensitivity out;
  std::vector<double> weights;
  for (const auto& [a, b] : terms) {
    std::vector<double> gaussian;
    for (int i = -radius; i <= radius; ++i) {
      const double x = i / pixels_per_degree;
      gaussian.push_back(std::exp(-kPi * kPi * x * x / b));
    }
    const double sum = sum_of(gaussian);
    weights.push_back(a * std::sqrt(kPi / b) * sum * sum);
    out.kernels.push_back(normalized(gaussian));
  }
  out.weights = normalized(weights);
  return out;
}

struct Filters {
  explicit Filters(double pixels_per_degree)
      : opponent{sensitivity({{1, .0047}}, pixels_per_degree),
                 sensitivity({{1, .0053}}, pixels_per_degree),
                 sensitivity({{34.1, .04}, {13.5, .025}}, pixels_per_degree)} {
    const double deviation = .5 * .082 * pixels_per_degree;
    const int radius = static_cast<int>(std::ceil(3 * deviation));
    std::vector<double> gaussian, first, second;
    for (int i = -radius; i <= radius; ++i) {
      const double g = std::exp(-i * i / (2 * deviation * deviation));
      gaussian.push_back(g);
      first.push_back(-i * g);
      second.push_back((i * i / (deviation * deviation) - 1) * g);
    }
    smooth = normalized(gaussian);
    edge = normalized(first);
    point = normalized(second);
    reach = std::max(smooth.size(), opponent[0].kernels[0].size()) / 2;
  }

  std::array<Sensitivity, 3> opponent;
  Kernel smooth, edge, point;
  size_t reach = 0;  ///< of the widest, in pixels
};

/// What FLIP compares, of some rows of one picture; its buffers serve for other rows later.
class FlipFeatures {
 public:
  FlipFeatures(const Picture& picture, const Filters& filters, size_t most_rows)
      : picture_(picture),
        filters_(filters),
        width_(static_cast<size_t>(picture.width)),
        height_(static_cast<size_t>(picture.height)) {
    const size_t around = most_rows + 2 * filters.reach;
    for (Rows* rows : {&opponent_[0], &opponent_[1], &opponent_[2], &luminance_, &half_})
      *rows = Rows(width_, around);
    for (Rows* rows : {&colors[0], &colors[1], &colors[2], &edges, &points, &part_})
      *rows = Rows(width_, most_rows);
  }

  void compute(size_t begin, size_t end) {
    read(begin - std::min(begin, filters_.reach), std::min(height_, end + filters_.reach));
    for (Rows* rows : {&colors[0], &colors[1], &colors[2], &edges, &points, &part_})
      rows->set(begin, end);
    detect(filters_.edge, edges);
    detect(filters_.point, points);
    for (size_t c = 0; c < 3; ++c) filter_contrast(filters_.opponent[c], opponent_[c], colors[c]);
    for (size_t y = begin; y < end; ++y)
      to_lab(colors[0].row(y), colors[1].row(y), colors[2].row(y));
  }

  Color color(size_t y, size_t x) const {
    return {colors[0].row(y)[x], colors[1].row(y)[x], colors[2].row(y)[x]};
  }

  std::array<Rows, 3> colors;  ///< as through the eye, in Hunt-adjusted L*a*b*
  Rows edges, points;          ///< how strongly each pixel is part of one

 private:
  void read(size_t begin, size_t end) {
    for (Rows* rows : {&opponent_[0], &opponent_[1], &opponent_[2], &luminance_})
      rows->set(begin, end);
    for (size_t y = begin; y < end; ++y) {
      const float* value = picture_.values.data() + 3 * y * width_;
      for (size_t x = 0; x < width_; ++x) {
        Triple rgb;
        for (double& v : rgb)
          v = std::isnan(*value) ? 0 : std::clamp(double{*value}, 0.0, 1.0), ++value;
        const Triple opponent = ycxcz(rgb);
        for (size_t c = 0; c < 3; ++c) opponent_[c].row(y)[x] = static_cast<float>(opponent[c]);
        luminance_.row(y)[x] = static_cast<float>((opponent[0] + 16) / 116);
      }
    }
  }

  void detect(const Kernel& derivative, Rows& out) {
    filter(luminance_, height_, derivative, filters_.smooth, half_, out);
    filter(luminance_, height_, filters_.smooth, derivative, half_, part_);
    for (size_t y = out.first; y < out.end; ++y) {
      for (size_t x = 0; x < width_; ++x) {
        const float a = out.row(y)[x], b = part_.row(y)[x];
        out.row(y)[x] = std::sqrt(a * a + b * b);
      }
    }
  }

  void filter_contrast(const Sensitivity& sensitivity, const Rows& in, Rows& out) {
    for (size_t term = 0; term < sensitivity.kernels.size(); ++term) {
      const Kernel& kernel = sensitivity.kernels[term];
      filter(in, height_, kernel, kernel, half_, part_);
      for (size_t y = out.first; y < out.end; ++y) {
        for (size_t x = 0; x < width_; ++x) {
          const float before = term == 0 ? 0 : out.row(y)[x];
          out.row(y)[x] = before + sensitivity.weights[term] * part_.row(y)[x];
        }
      }
    }
  }

  /// A row of opponent colours.
  void to_lab(float* first, float* second, float* third) const {
    const std::array<float*, 3> rows{first, second, third};
    for (size_t x = 0; x < width_; ++x) {
      Triple rgb = rgb_of_ycxcz({first[x], second[x], third[x]});
      for (double& value : rgb) value = std::clamp(value, 0.0, 1.0);
      const Triple xyz = relative_xyz(rgb);
      for (size_t c = 0; c < 3; ++c) rows[c][x] = static_cast<float>(xyz[c]);
    }
    for (float* row : rows) {
      for (size_t x = 0; x < width_; ++x) row[x] = lab_response(row[x]);
    }
    for (size_t x = 0; x < width_; ++x) {
      const Color lab = hunt_lab({first[x], second[x], third[x]});
      for (size_t c = 0; c < 3; ++c) rows[c][x] = lab[c];
    }
  }

  const Picture& picture_;
  const Filters& filters_;
  size_t width_, height_;
  std::array<Rows, 3> opponent_;
  Rows luminance_, half_, part_;
};

/// The colour difference raised to .7, its usual range spread over [0, .95].
float color_error(const Color& a, const Color& b) {
  constexpr float kExponent = .7F, kUsualShare = .4F, kUsualTop = .95F;
  static const float greatest = std::pow(hyab(lab_of({0, 1, 0}), lab_of({0, 0, 1})), kExponent);
  const float usual = kUsualShare * greatest, error = std::pow(hyab(a, b), kExponent);
  const float spread = error < usual
                           ? kUsualTop * error / usual
                           : kUsualTop + (1 - kUsualTop) * (error - usual) / (greatest - usual);
  return std::clamp(spread, 0.F, 1.F);
}

}  // namespace

std::vector<float> flip_map(const Picture& a, const Picture& b, double pixels_per_degree) {
  constexpr size_t kBand = 64;  // rows; with those around them, what a processor's cache may hold
  const Filters filters(pixels_per_degree);
  const auto width = static_cast<size_t>(a.width), height = static_cast<size_t>(a.height);
  const size_t bands = (height + kBand - 1) / kBand;
  const auto buffers = [&](const Picture& of) {
    const size_t threads = std::min(bands, static_cast<size_t>(core_count()));
    return std::vector<FlipFeatures>(threads, {of, filters, kBand});
  };
  std::vector<FlipFeatures> all_first = buffers(a), all_second = buffers(b);
  std::vector<float> out(a.pixels());
  for_each_of_thread(bands, core_count(), [&](size_t thread, size_t band) {
    FlipFeatures &first = all_first[thread], &second = all_second[thread];
    const size_t begin = band * kBand, end = std::min(height, begin + kBand);
    first.compute(begin, end);
    second.compute(begin, end);
    for (size_t y = begin; y < end; ++y) {
      for (size_t x = 0; x < width; ++x) {
        const float difference =
            std::max(std::abs(first.edges.row(y)[x] - second.edges.row(y)[x]),
                     std::abs(first.points.row(y)[x] - second.points.row(y)[x]));
        const float features =
            std::clamp(std::sqrt(difference / std::numbers::sqrt2_v<float>), 0.F, 1.F);
        out[y * width + x] =
            std::pow(color_error(first.color(y, x), second.color(y, x)), 1 - features);
      }
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
