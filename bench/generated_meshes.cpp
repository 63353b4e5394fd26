#include "bench/generated_meshes.h"

#include <fstream>
#include <map>
#include <random>
#include <sstream>
#include <stdexcept>
#include <utility>

namespace tessera {
namespace {

Float3 on_sphere(double x, double y, double z) {
  const double scale = 2 / std::sqrt(x * x + y * y + z * z);
  return {static_cast<float>(x * scale), static_cast<float>(y * scale),
          static_cast<float>(z * scale)};
}

}  // namespace

TriangleMesh icosphere(int subdivisions) {
  TriangleMesh mesh;
  const double g = (1 + std::sqrt(5.0)) / 2;
  for (const double s : {-1.0, 1.0}) {
    for (const double t : {-g, g}) {
      mesh.positions.push_back(on_sphere(s, t, 0));
      mesh.positions.push_back(on_sphere(0, s, t));
      mesh.positions.push_back(on_sphere(t, 0, s));
    }
  }
  // The faces are the triples of vertices at the edge's length, wound outward.
  const auto near = [&](uint32_t i, uint32_t j) {
    return distance(mesh.vertex(i), mesh.vertex(j)) < 2.2;
  };
  for (uint32_t i = 0; i < 12; ++i) {
    for (uint32_t j = i + 1; j < 12; ++j) {
      for (uint32_t k = j + 1; k < 12; ++k) {
        if (!(near(i, j) && near(j, k) && near(k, i))) continue;
        const Vec3 n = cross(mesh.vertex(j) - mesh.vertex(i), mesh.vertex(k) - mesh.vertex(i));
        if (dot(n, mesh.vertex(i) - Point3{}) > 0)
          mesh.triangles.push_back({i, j, k});
        else
          mesh.triangles.push_back({i, k, j});
      }
    }
  }
  for (int level = 0; level < subdivisions; ++level) {
    std::map<std::pair<uint32_t, uint32_t>, uint32_t> middles;
    const auto middle = [&](uint32_t i, uint32_t j) {
      const auto [at, added] = middles.try_emplace(std::minmax(i, j), mesh.positions.size());
      if (added) {
        const Vec3 sum = (mesh.vertex(i) - Point3{}) + (mesh.vertex(j) - Point3{});
        mesh.positions.push_back(on_sphere(sum.x, sum.y, sum.z));
      }
      return at->second;
    };
    std::vector<TriangleIndices> finer;
    for (const auto& [a, b, c] : mesh.triangles) {
      const uint32_t ab = middle(a, b), bc = middle(b, c), ca = middle(c, a);
      finer.insert(finer.end(), {{a, ab, ca}, {b, bc, ab}, {c, ca, bc}, {ab, bc, ca}});
    }
    mesh.triangles = std::move(finer);
  }
  return mesh;
}

TriangleMesh triangle_soup(size_t count, uint64_t seed) {
  TriangleMesh mesh;
  std::mt19937_64 random(seed);
  std::uniform_real_distribution<float> unit(0, 1);
  const float side = 1 / std::cbrt(static_cast<float>(count));
  for (uint32_t i = 0; i < count; ++i) {
    const Float3 at{unit(random), unit(random), unit(random)};
    for (int k = 0; k < 3; ++k)
      mesh.positions.push_back({at.x + side * (unit(random) - 0.5f),
                                at.y + side * (unit(random) - 0.5f),
                                at.z + side * (unit(random) - 0.5f)});
    mesh.triangles.push_back({3 * i, 3 * i + 1, 3 * i + 2});
  }
  return mesh;
}

namespace {

void add_box(TriangleMesh& mesh, const Float3& low, const Float3& high, double turn, bool inward) {
  const auto first = static_cast<uint32_t>(mesh.positions.size());
  const double cx = 0.5 * (double{low.x} + high.x), cz = 0.5 * (double{low.z} + high.z);
  const double c = std::cos(turn), s = std::sin(turn);
  for (int i = 0; i < 8; ++i) {
    const double x = (i & 1 ? high.x : low.x) - cx, z = (i & 4 ? high.z : low.z) - cz;
    mesh.positions.push_back({static_cast<float>(cx + c * x - s * z), i & 2 ? high.y : low.y,
                              static_cast<float>(cz + s * x + c * z)});
  }
  constexpr uint32_t kFaces[6][4] = {{0, 4, 6, 2}, {1, 3, 7, 5}, {0, 1, 5, 4},
                                     {2, 6, 7, 3}, {0, 2, 3, 1}, {4, 5, 7, 6}};
  for (const auto& f : kFaces) {
    const uint32_t a = first + f[0], b = first + f[1], d = first + f[2], e = first + f[3];
    if (inward) {
      mesh.triangles.insert(mesh.triangles.end(), {{a, d, b}, {a, e, d}});
    } else {
      mesh.triangles.insert(mesh.triangles.end(), {{a, b, d}, {a, d, e}});
    }
  }
}

}  // namespace

TriangleMesh furnished_room(uint64_t seed) {
  TriangleMesh mesh;
  std::mt19937_64 random(seed);
  std::uniform_real_distribution<float> unit(0, 1);
  add_box(mesh, {0, 0, 0}, {8, 3, 10}, 0, true);
  const auto box = [&](Float3 at, Float3 size, double turn) {
    add_box(mesh, {at.x - size.x / 2, at.y, at.z - size.z / 2},
            {at.x + size.x / 2, at.y + size.y, at.z + size.z / 2}, turn, false);
  };
  for (int shelf = 0; shelf < 24; ++shelf) {  // along two walls, with books
    const bool left = shelf % 2 == 0;
    const float x = left ? 0.2f : 7.8f, y = 0.4f * static_cast<float>(shelf / 2 % 6);
    const float z = shelf < 12 ? 2.5f : 6.5f;
    box({x, y, z}, {0.4f, 0.03f, 3}, 0);
    for (float along = -1.45f; along < 1.45f;) {
      const float thick = 0.02f + 0.05f * unit(random);
      box({x, y + 0.03f, z + along + thick / 2},
          {0.2f + 0.1f * unit(random), 0.2f + 0.12f * unit(random), thick * 0.95f}, 0);
      along += thick;
    }
  }
  for (int seat = 0; seat < 30; ++seat) {  // tables and chairs: a top on four legs
    const Float3 at{1.2f + 5.6f * unit(random), 0, 0.8f + 8.4f * unit(random)};
    const float width = 0.4f + 0.6f * unit(random), height = 0.4f + 0.4f * unit(random);
    const double turn = 6.3 * unit(random);
    box({at.x, height, at.z}, {width, 0.04f, width}, turn);
    for (int leg = 0; leg < 4; ++leg) {
      const double a = turn + 0.785 + 1.5708 * leg;
      box({at.x + 0.6f * width * static_cast<float>(std::cos(a)), 0,
           at.z + 0.6f * width * static_cast<float>(std::sin(a))},
          {0.04f, height, 0.04f}, turn);
    }
  }
  const TriangleMesh ball = icosphere(4);
  for (int i = 0; i < 18; ++i) {
    const float scale = 0.05f + 0.1f * unit(random);
    const Float3 at{1 + 6 * unit(random), 0.3f + 2 * unit(random), 1 + 8 * unit(random)};
    const auto first = static_cast<uint32_t>(mesh.positions.size());
    for (const Float3& p : ball.positions)
      mesh.positions.push_back({at.x + scale * p.x, at.y + scale * p.y, at.z + scale * p.z});
    for (const TriangleIndices& t : ball.triangles)
      mesh.triangles.push_back({first + t[0], first + t[1], first + t[2]});
  }
  return mesh;
}

TriangleMesh subdivided(const TriangleMesh& mesh, int times) {
  if (times == 0) return mesh;
  TriangleMesh finer;
  const auto middle = [](const Float3& a, const Float3& b) {
    return Float3{0.5f * a.x + 0.5f * b.x, 0.5f * a.y + 0.5f * b.y, 0.5f * a.z + 0.5f * b.z};
  };
  for (const TriangleIndices& t : mesh.triangles) {
    const Float3 a = mesh.positions[t[0]], b = mesh.positions[t[1]], c = mesh.positions[t[2]];
    const auto first = static_cast<uint32_t>(finer.positions.size());
    finer.positions.insert(finer.positions.end(),
                           {a, b, c, middle(a, b), middle(b, c), middle(c, a)});
    for (const TriangleIndices& part : {TriangleIndices{0, 3, 5}, {3, 1, 4}, {5, 4, 2}, {3, 4, 5}})
      finer.triangles.push_back({first + part[0], first + part[1], first + part[2]});
  }
  return subdivided(finer, times - 1);
}

TriangleMesh subdivided_to_a_million(const TriangleMesh& mesh) {
  int times = 0;
  for (size_t count = mesh.triangles.size(); count != 0 && count < 1'000'000; count *= 4) ++times;
  return subdivided(mesh, times);
}

}  // namespace tessera
