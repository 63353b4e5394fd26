#include "renderer/math/mix_transforms.h"

#include <algorithm>
#include <cmath>

#include "renderer/math/elementary.h"

namespace tessera {
namespace {

struct Quaternion {
  double w;
  Vec3 v;
};

Quaternion operator*(const Quaternion& a, const Quaternion& b) {
  return {a.w * b.w - dot(a.v, b.v), a.w * b.v + b.w * a.v + cross(a.v, b.v)};
}

/// Of a turn's matrix: the largest of the four parts is found first, so that none is divided by
/// what rounding left (Shepperd 1978).
Quaternion to_quaternion(const Affine& turn) {
  const auto& m = turn.m;
  const double trace = m[0][0] + m[1][1] + m[2][2];
  const double squares[] = {1 + trace, 1 + 2 * m[0][0] - trace, 1 + 2 * m[1][1] - trace,
                            1 + 2 * m[2][2] - trace};
  const auto largest = std::max_element(std::begin(squares), std::end(squares));
  const double four = 2 * std::sqrt(*largest);  // four times the part
  switch (largest - std::begin(squares)) {
    case 0:
      return {four / 4,
              {(m[2][1] - m[1][2]) / four, (m[0][2] - m[2][0]) / four, (m[1][0] - m[0][1]) / four}};
    case 1:
      return {(m[2][1] - m[1][2]) / four,
              {four / 4, (m[0][1] + m[1][0]) / four, (m[0][2] + m[2][0]) / four}};
    case 2:
      return {(m[0][2] - m[2][0]) / four,
              {(m[0][1] + m[1][0]) / four, four / 4, (m[1][2] + m[2][1]) / four}};
    default:
      return {(m[1][0] - m[0][1]) / four,
              {(m[0][2] + m[2][0]) / four, (m[1][2] + m[2][1]) / four, four / 4}};
  }
}

/// The 3x3 part, without the shift.
Affine linear_part(const Affine& a) {
  Affine out = a;
  for (auto& row : out.m) row[3] = 0;
  return out;
}

Affine transposed(const Affine& a) {
  Affine out;
  for (size_t r = 0; r < 3; ++r)
    for (size_t c = 0; c < 3; ++c) out.m[r][c] = a.m[c][r];
  return out;
}

Affine mix_numbers(const Affine& from, const Affine& to, double s) {
  Affine out;
  for (size_t r = 0; r < 3; ++r)
    for (size_t c = 0; c < 4; ++c) out.m[r][c] = from.m[r][c] + s * (to.m[r][c] - from.m[r][c]);
  return out;
}

/// The turn that is nearest to a linear map that can be inverted, by Newton's iteration: the mean
/// with the inverse transpose, which leaves turns alone (Higham 1986). A map that mirrors is the
/// turn's with a stretch by less than 0.
Affine nearest_turn(const Affine& linear) {
  constexpr int kMostSteps = 100;  // each halves what is far from 1; condition() is at most 2^46
  double largest = 0;
  for (const auto& row : linear.m)
    for (const double value : row) largest = std::max(largest, std::abs(value));
  const double size = linear.determinant() < 0 ? -largest : largest;
  Affine turn = linear;
  for (auto& row : turn.m)
    for (double& value : row) value /= size;
  for (int step = 0; step < kMostSteps; ++step) {
    const Affine other = transposed(inverse(turn));
    double change = 0;
    for (size_t r = 0; r < 3; ++r) {
      for (size_t c = 0; c < 3; ++c) {
        const double mean = (turn.m[r][c] + other.m[r][c]) / 2;
        change = std::max(change, std::abs(mean - turn.m[r][c]));
        turn.m[r][c] = mean;
      }
    }
    constexpr double kSettled = 1e-15;
    if (change <= kSettled) break;
  }
  return turn;
}

}  // namespace

Affine mix_turns(const Affine& from, const Affine& to, double s) {
  const Quaternion a = to_quaternion(from);
  Quaternion turn = Quaternion{a.w, -a.v} * to_quaternion(to);
  if (turn.w < 0) turn = {-turn.w, -turn.v};
  const double sine = length(turn.v);
  if (!(sine > 0)) return from;
  return from * rotation(turn.v, s * 2 * portable::atan2(sine, turn.w));
}

Affine mix_matrices(const Affine& from, const Affine& to, double s) {
  const Affine mixed = mix_numbers(from, to, s);
  const Affine a = linear_part(from), b = linear_part(to);
  if (a == b || !is_invertible(a) || !is_invertible(b)) return mixed;
  const Affine turn_a = nearest_turn(a), turn_b = nearest_turn(b);
  const Affine stretch = mix_numbers(transposed(turn_a) * a, transposed(turn_b) * b, s);
  Affine out = mix_turns(turn_a, turn_b, s) * stretch;
  for (size_t r = 0; r < 3; ++r) out.m[r][3] = mixed.m[r][3];
  return out;
}

}  // namespace tessera
