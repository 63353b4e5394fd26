#include "metrics/flip.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <numbers>
#include <numeric>
#include <utility>
#include <vector>

#include "base/core_count.h"
#include "base/parallel.h"
#include "base/targets.h"
#include "metrics/vector_math.h"
#include "metrics/weighted_sum.h"
// This file is compiled once for each instruction set.
#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "metrics/flip.cpp"
#include <hwy/foreach_target.h>
#include <hwy/highway.h>

HWY_BEFORE_NAMESPACE();
namespace tessera {
namespace HWY_NAMESPACE {
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
using Matrix = std::array<Triple, 3>;
using Color = std::array<float, 3>;

constexpr Matrix kXyzOfRgb{{{10135552. / 24577794, 8788810. / 24577794, 4435075. / 24577794},
                            {2613072. / 12288897, 8788810. / 12288897, 887015. / 12288897},
                            {1425312. / 73733382, 8788810. / 73733382, 70074185. / 73733382}}};
/// The paper's YCxCz without the offset of Y, which filters whose weights have the sum 1 pass on.
constexpr Matrix kOpponentOfXyz{{{0, 116, 0}, {500, -500, 0}, {0, 200, -200}}};
constexpr float kOpponentWhite = 116;

constexpr Matrix over_white(Matrix m) {
  for (Triple& row : m) {
    const double white = row[0] + row[1] + row[2];
    for (double& value : row) value /= white;
  }
  return m;
}

constexpr Matrix product(const Matrix& a, const Matrix& b) {
  Matrix out{};
  for (size_t i = 0; i < 3; ++i)
    for (size_t j = 0; j < 3; ++j)
      for (size_t k = 0; k < 3; ++k) out[i][j] += a[i][k] * b[k][j];
  return out;
}

constexpr Matrix inverse(const Matrix& m) {
  Matrix out{};
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

/// XYZ over its white.
constexpr Matrix kRelativeOfRgb = over_white(kXyzOfRgb);
constexpr Matrix kOpponentOfRgb = product(kOpponentOfXyz, kRelativeOfRgb);
constexpr Matrix kRgbOfOpponent = inverse(kOpponentOfRgb);

inline Color times(const Matrix& m, const Color& v) {
  const auto sum = [&](const Triple& row) {
    return static_cast<float>(row[0]) * v[0] + static_cast<float>(row[1]) * v[1] +
           static_cast<float>(row[2]) * v[2];
  };
  return {sum(m[0]), sum(m[1]), sum(m[2])};
}

/// What is no number is 0.
inline float clamped(float v) { return v > 0 ? smaller(v, 1) : 0; }

/// What CIE L*a*b* takes of each relative XYZ.
inline float lab_response(float v) {
  constexpr float kDelta = 6.F / 29, kKnee = kDelta * kDelta * kDelta;
  const float root = cube_root(larger(v, kKnee)), line = v / (3 * kDelta * kDelta) + 4.F / 29;
  return v > kKnee ? root : line;
}

/// CIE L*a*b* of such responses, its colourfulness made to fall with luminance as Hunt saw it.
inline Color hunt_lab(const Color& response) {
  const float lightness = 116 * response[1] - 16;
  return {lightness, .01F * lightness * 500 * (response[0] - response[1]),
          .01F * lightness * 200 * (response[1] - response[2])};
}

Color lab_of(const Color& rgb) {
  Color response = times(kRelativeOfRgb, rgb);
  for (float& value : response) value = lab_response(value);
  return hunt_lab(response);
}

/// HyAB: city block in lightness, Euclidean in colour.
inline float hyab(const Color& a, const Color& b) {
  const float u = a[1] - b[1], v = a[2] - b[2];
  return std::abs(a[0] - b[0]) + std::sqrt(u * u + v * v);
}

/// All rows of `in` through the kernel, into `out`; the border's pixels go on outside.
void filter_rows(const Rows& in, const Kernel& kernel, Rows& out) {
  const size_t width = in.width, radius = kernel.size() / 2;
  out.set(in.first, in.end);
  std::vector<float> line(width + 2 * radius);
  std::vector<const float*> rows;
  for (size_t k = 0; k < kernel.size(); ++k) rows.push_back(line.data() + k);
  for (size_t y = in.first; y < in.end; ++y) {
    const float* const row = in.row(y);
    std::fill_n(line.begin(), radius, row[0]);
    std::copy_n(row, width, line.begin() + static_cast<std::ptrdiff_t>(radius));
    std::fill_n(line.rbegin(), radius, row[width - 1]);
    weighted_sum(out.row(y), width, kernel, rows);
  }
}

/// Columns through the kernel, into the rows of `out`, of a picture of `height` rows. `in` has
/// those that are within reach.
void filter_columns(const Rows& in, size_t height, const Kernel& kernel, Rows& out) {
  const size_t radius = kernel.size() / 2;
  std::vector<const float*> rows(kernel.size());
  for (size_t y = out.first; y < out.end; ++y) {
    for (size_t k = 0; k < kernel.size(); ++k) {
      rows[k] = in.row(std::clamp(y + k, radius, radius + height - 1) - radius);
    }
    weighted_sum(out.row(y), in.width, kernel, rows);
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
  // Weights further out change the sum by less than its rounding where all is equally bright.
  constexpr double kLeastWeight = 0x1p-26;
  Sensitivity out;
  std::vector<double> weights;
  for (const auto& [a, b] : terms) {
    const double degrees = std::min(3 * std::sqrt(kWidest / (2 * kPi * kPi)),
                                    std::sqrt(-std::log(kLeastWeight) * b) / kPi);
    const int radius = static_cast<int>(std::ceil(degrees * pixels_per_degree));
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
    reach = smooth.size() / 2;
    for (const Sensitivity& each : opponent) {
      for (const Kernel& kernel : each.kernels) reach = std::max(reach, kernel.size() / 2);
    }
  }

  std::array<Sensitivity, 3> opponent;
  Kernel smooth, edge, point;
  size_t reach = 0;  ///< of the widest, in pixels
};

/// What FLIP compares, of some rows of one picture; its buffers serve for other rows later.
class FlipFeatures {
 public:
  FlipFeatures(const PictureView& picture, const Filters& filters, size_t most_rows)
      : picture_(picture),
        filters_(filters),
        width_(static_cast<size_t>(picture.width)),
        height_(static_cast<size_t>(picture.height)) {
    const size_t around = most_rows + 2 * filters.reach;
    for (Rows* rows : {&opponent_[0], &opponent_[1], &opponent_[2], &half_, &smooth_})
      *rows = Rows(width_, around);
    for (Rows* rows : {&colors[0], &colors[1], &colors[2], &edges, &points, &part_})
      *rows = Rows(width_, most_rows);
  }

  void compute(size_t begin, size_t end) {
    read(begin - std::min(begin, filters_.reach), std::min(height_, end + filters_.reach));
    for (Rows* rows : {&colors[0], &colors[1], &colors[2], &edges, &points, &part_})
      rows->set(begin, end);
    filter_rows(opponent_[0], filters_.smooth, smooth_);
    detect(filters_.edge, edges);
    detect(filters_.point, points);
    for (size_t c = 0; c < 3; ++c) filter_contrast(filters_.opponent[c], opponent_[c], colors[c]);
    for (size_t y = begin; y < end; ++y)
      to_lab(colors[0].row(y), colors[1].row(y), colors[2].row(y));
  }

  std::array<Rows, 3> colors;  ///< as through the eye, in Hunt-adjusted L*a*b*
  Rows edges, points;          ///< how strongly each pixel is part of one

 private:
  void read(size_t begin, size_t end) {
    for (Rows& rows : opponent_) rows.set(begin, end);
    for (size_t y = begin; y < end; ++y) {
      const float* const values = picture_.values.data() + 3 * y * width_;
      float *const first = opponent_[0].row(y), *const second = opponent_[1].row(y),
                   *const third = opponent_[2].row(y);
      for (size_t x = 0; x < width_; ++x) {
        const Color opponent =
            times(kOpponentOfRgb,
                  {clamped(values[3 * x]), clamped(values[3 * x + 1]), clamped(values[3 * x + 2])});
        first[x] = opponent[0];
        second[x] = opponent[1];
        third[x] = opponent[2];
      }
    }
  }

  void detect(const Kernel& derivative, Rows& out) {
    filter_rows(opponent_[0], derivative, half_);
    filter_columns(half_, height_, filters_.smooth, out);
    filter_columns(smooth_, height_, derivative, part_);
    for (size_t y = out.first; y < out.end; ++y) {
      float* const to = out.row(y);
      const float* const other = part_.row(y);
      for (size_t x = 0; x < width_; ++x)
        to[x] = std::sqrt(to[x] * to[x] + other[x] * other[x]) / kOpponentWhite;
    }
  }

  void filter_contrast(const Sensitivity& sensitivity, const Rows& in, Rows& out) {
    for (size_t term = 0; term < sensitivity.kernels.size(); ++term) {
      const Kernel& kernel = sensitivity.kernels[term];
      filter_rows(in, kernel, half_);
      filter_columns(half_, height_, kernel, part_);
      for (size_t y = out.first; y < out.end; ++y) {
        float* const to = out.row(y);
        const float* const from = part_.row(y);
        if (term == 0) std::fill_n(to, width_, 0.F);
        for (size_t x = 0; x < width_; ++x) to[x] += sensitivity.weights[term] * from[x];
      }
    }
  }

  /// A row of opponent colours.
  void to_lab(float* first, float* second, float* third) const {
    for (size_t x = 0; x < width_; ++x) {
      const Color rgb = times(kRgbOfOpponent, {first[x], second[x], third[x]});
      const Color xyz = times(kRelativeOfRgb, {clamped(rgb[0]), clamped(rgb[1]), clamped(rgb[2])});
      first[x] = xyz[0];
      second[x] = xyz[1];
      third[x] = xyz[2];
    }
    for (float* row : {first, second, third}) {
      for (size_t x = 0; x < width_; ++x) row[x] = lab_response(row[x]);
    }
    for (size_t x = 0; x < width_; ++x) {
      const Color lab = hunt_lab({first[x], second[x], third[x]});
      first[x] = lab[0];
      second[x] = lab[1];
      third[x] = lab[2];
    }
  }

  PictureView picture_;
  const Filters& filters_;
  size_t width_, height_;
  std::array<Rows, 3> opponent_;
  Rows half_, part_;
  Rows smooth_;  ///< luminance, smoothed along its rows
};

constexpr float kColorExponent = .7F;

/// Of the colour difference raised to .7, its usual range spread over [0, .95]. `greatest`: that of
/// any two colours.
inline float color_error(float error, float greatest) {
  constexpr float kUsualShare = .4F, kUsualTop = .95F;
  const float usual = kUsualShare * greatest;
  const float below = kUsualTop * error / usual;
  const float above = kUsualTop + (1 - kUsualTop) * (error - usual) / (greatest - usual);
  return smaller(larger(error < usual ? below : above, 0), 1);
}

/// Of a row of both pictures, in steps that each run for several pixels at a time. `exponents`: a
/// buffer.
void compare_row(const FlipFeatures& a, const FlipFeatures& b, size_t y, std::vector<float>& errors,
                 std::vector<float>& exponents) {
  static const float greatest = power(hyab(lab_of({0, 1, 0}), lab_of({0, 0, 1})), kColorExponent);
  const auto row = [y](const Rows& rows) { return rows.row(y); };
  const float *const a0 = row(a.colors[0]), *const a1 = row(a.colors[1]),
                     *const a2 = row(a.colors[2]), *const b0 = row(b.colors[0]),
                     *const b1 = row(b.colors[1]), *const b2 = row(b.colors[2]);
  const size_t width = errors.size();
  float* const error = errors.data();
  for (size_t x = 0; x < width; ++x) error[x] = hyab({a0[x], a1[x], a2[x]}, {b0[x], b1[x], b2[x]});
  for (size_t x = 0; x < width; ++x) error[x] = power(error[x], kColorExponent);
  for (size_t x = 0; x < width; ++x) error[x] = color_error(error[x], greatest);
  const float *const a_edges = row(a.edges), *const a_points = row(a.points),
                     *const b_edges = row(b.edges), *const b_points = row(b.points);
  float* const exponent = exponents.data();
  for (size_t x = 0; x < width; ++x) {
    const float difference =
        larger(std::abs(a_edges[x] - b_edges[x]), std::abs(a_points[x] - b_points[x]));
    exponent[x] = 1 - smaller(std::sqrt(difference / std::numbers::sqrt2_v<float>), 1);
  }
  for (size_t x = 0; x < width; ++x) error[x] = power(error[x], exponent[x]);
}

/// Calls take(y, errors) for each row of the pictures, on several threads.
template <typename Take>
void for_each_row(const PictureView& a, const PictureView& b, double pixels_per_degree,
                  const Take& take) {
  constexpr size_t kBand = 64;  // rows; with those around them, what a processor's cache may hold
  const Filters filters(pixels_per_degree);
  const auto width = static_cast<size_t>(a.width), height = static_cast<size_t>(a.height);
  const size_t bands = (height + kBand - 1) / kBand;
  const auto buffers = [&](const PictureView& of) {
    const size_t threads = std::min(bands, static_cast<size_t>(core_count()));
    return std::vector<FlipFeatures>(threads, {of, filters, kBand});
  };
  std::vector<FlipFeatures> all_first = buffers(a), all_second = buffers(b);
  for_each_of_thread(bands, core_count(), [&](size_t thread, size_t band) {
    FlipFeatures &first = all_first[thread], &second = all_second[thread];
    const size_t begin = band * kBand, end = std::min(height, begin + kBand);
    first.compute(begin, end);
    second.compute(begin, end);
    std::vector<float> errors(width), exponents(width);
    for (size_t y = begin; y < end; ++y) {
      compare_row(first, second, y, errors, exponents);
      take(y, errors);
    }
  });
}

}  // namespace

std::vector<float> flip_map(const PictureView& a, const PictureView& b, double pixels_per_degree) {
  std::vector<float> out(a.pixels());
  for_each_row(a, b, pixels_per_degree, [&](size_t y, const std::vector<float>& errors) {
    std::copy(errors.begin(), errors.end(), &out[y * errors.size()]);
  });
  return out;
}

double mean_flip(const PictureView& a, const PictureView& b, const PixelMask& mask,
                 double pixels_per_degree) {
  // By row, which are added in their order for any number of threads.
  std::vector<double> sums(static_cast<size_t>(a.height));
  std::vector<size_t> counted(sums.size());
  for_each_row(a, b, pixels_per_degree, [&](size_t y, const std::vector<float>& errors) {
    for (size_t x = 0; x < errors.size(); ++x) {
      if (!counts(mask, y * errors.size() + x)) continue;
      sums[y] += double{errors[x]};
      ++counted[y];
    }
  });
  return std::accumulate(sums.begin(), sums.end(), 0.) /
         static_cast<double>(std::accumulate(counted.begin(), counted.end(), size_t{0}));
}

}  // namespace HWY_NAMESPACE
}  // namespace tessera
HWY_AFTER_NAMESPACE();

#if HWY_ONCE
namespace tessera {

std::vector<float> flip_map(const PictureView& a, const PictureView& b, double pixels_per_degree) {
  static const auto best = best_code_of_machine(TESSERA_EACH_TARGET(flip_map));
  return best(a, b, pixels_per_degree);
}

double mean_flip(const PictureView& a, const PictureView& b, const PixelMask& mask,
                 double pixels_per_degree) {
  static const auto best = best_code_of_machine(TESSERA_EACH_TARGET(mean_flip));
  return best(a, b, mask, pixels_per_degree);
}

}  // namespace tessera
#endif  // HWY_ONCE
