#pragma once

#include <cmath>
#include <cstdint>

#include "renderer/shapes/triangle_mesh.h"

namespace tessera {

/// Two triangles for each of `side` x `side` squares, 2 metres wide, fronts up (z).
inline TriangleMesh bumpy_sheet(uint32_t side) {
  TriangleMesh mesh;
  for (uint32_t i = 0; i <= side; ++i) {
    for (uint32_t j = 0; j <= side; ++j) {
      const double x = 2.0 * i / side - 1, y = 2.0 * j / side - 1;
      const double z = 0.15 * std::sin(7 * x) * std::cos(5 * y + x);
      mesh.positions.push_back(
          {static_cast<float>(x), static_cast<float>(y), static_cast<float>(z)});
    }
  }
  for (uint32_t i = 0; i < side; ++i) {
    for (uint32_t j = 0; j < side; ++j) {
      const uint32_t a = i * (side + 1) + j, b = a + side + 1;
      mesh.triangles.push_back({a, b, b + 1});
      mesh.triangles.push_back({a, b + 1, a + 1});
    }
  }
  return mesh;
}

/// A closed ball of that radius, `side` rings of twice as many squares, fronts out.
inline TriangleMesh ball_mesh(uint32_t side, double radius) {
  TriangleMesh mesh;
  constexpr double kPi = 3.141592653589793;
  for (uint32_t i = 0; i <= side; ++i) {
    for (uint32_t j = 0; j < 2 * side; ++j) {
      const double down = kPi * i / side, turn = kPi * j / side;
      const double across = i == 0 || i == side ? 0 : radius * std::sin(down);
      mesh.positions.push_back({static_cast<float>(across * std::cos(turn)),
                                static_cast<float>(across * std::sin(turn)),
                                static_cast<float>(radius * std::cos(down))});
    }
  }
  for (uint32_t i = 0; i < side; ++i) {
    for (uint32_t j = 0; j < 2 * side; ++j) {
      const uint32_t next = (j + 1) % (2 * side), row = 2 * side;
      const uint32_t a = i * row + j, b = a + row, c = (i + 1) * row + next, d = i * row + next;
      mesh.triangles.push_back({a, b, c});  // without an area at one pole
      mesh.triangles.push_back({a, c, d});  // and at the other
    }
  }
  return mesh;
}

/// A torus of radius 1 about z whose tube has the radius `tube`, in `around` x `across` squares,
/// fronts out.
inline TriangleMesh ring_mesh(uint32_t around, uint32_t across, double tube) {
  TriangleMesh mesh;
  constexpr double kPi = 3.141592653589793;
  for (uint32_t i = 0; i < around; ++i) {
    for (uint32_t j = 0; j < across; ++j) {
      const double turn = 2 * kPi * i / around, roll = 2 * kPi * j / across;
      const double out = 1 + tube * std::cos(roll);
      mesh.positions.push_back({static_cast<float>(out * std::cos(turn)),
                                static_cast<float>(out * std::sin(turn)),
                                static_cast<float>(tube * std::sin(roll))});
    }
  }
  for (uint32_t i = 0; i < around; ++i) {
    for (uint32_t j = 0; j < across; ++j) {
      const uint32_t next = (i + 1) % around * across, row = i * across, up = (j + 1) % across;
      mesh.triangles.push_back({row + j, next + j, next + up});
      mesh.triangles.push_back({row + j, next + up, row + up});
    }
  }
  return mesh;
}

}  // namespace tessera
