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

TriangleMesh read_plain_obj(const std::string& path) {
  std::ifstream file(path);
  if (!file) throw std::runtime_error("cannot read " + path);
  TriangleMesh mesh;
  for (std::string line; std::getline(file, line);) {
    std::istringstream words(line);
    std::string word;
    words >> word;
    if (word == "v") {
      Float3 p;
      words >> p.x >> p.y >> p.z;
      mesh.positions.push_back(p);
    } else if (word == "f") {
      std::vector<uint32_t> corners;
      for (std::string corner; words >> corner;) {
        const long index = std::stol(corner);
        corners.push_back(static_cast<uint32_t>(
            index > 0 ? index - 1 : static_cast<long>(mesh.positions.size()) + index));
      }
      for (size_t i = 2; i < corners.size(); ++i)
        mesh.triangles.push_back({corners[0], corners[i - 1], corners[i]});
    }
  }
  return mesh;
}

}  // namespace tessera
