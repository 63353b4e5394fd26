#pragma once

#include "renderer/math/color.h"
#include "renderer/math/elementary.h"
#include "renderer/math/vec.h"

namespace tessera {

// What is written once, for one ray as for as many as a vector has lanes, stands in files that say
// so at their beginning. They call their numbers by these names, for which lanes-inl.h has vectors
// of the instruction set that it is compiled for. All operators are those of double, lane by lane.

using Num = double;
using Num2 = Vec2;
using Num3 = Vec3;
using NumColor = Color;
using NumMask = bool;  ///< what a comparison gives

/// Such functions run with the instruction set of their caller.
#define TESSERA_INLINE inline __attribute__((always_inline))

inline Num num(double value) { return value; }
inline NumColor num_color(double grey) { return {grey, grey, grey}; }
inline Num3 num3(double x, double y, double z) { return {x, y, z}; }
inline Num negated(Num x) { return -x; }
inline Num absolute(Num x) { return std::abs(x); }
inline Num floor_of(Num x) { return std::floor(x); }
inline Num square_root(Num x) { return std::sqrt(x); }
inline Num arc_tangent(Num y, Num x) { return portable::atan2(y, x); }
/// The size of `size` with the sign of `sign`.
inline Num copy_sign(Num size, Num sign) { return std::copysign(size, sign); }
/// std::max(a, b), of what is no number and of zeros too.
inline Num maximum(Num a, Num b) { return std::max(a, b); }
/// Whether it is so in every lane.
inline bool is_all(NumMask mask) { return mask; }
inline NumMask both(NumMask a, NumMask b) { return a && b; }
inline NumMask either(NumMask a, NumMask b) { return a || b; }
/// a and not b.
inline NumMask and_not(NumMask a, NumMask b) { return a && !b; }
inline Num select(NumMask mask, Num yes, Num no) { return mask ? yes : no; }
inline Num3 select(NumMask mask, const Num3& yes, const Num3& no) { return mask ? yes : no; }
inline NumColor select(NumMask mask, const NumColor& yes, const NumColor& no) {
  return mask ? yes : no;
}

}  // namespace tessera
