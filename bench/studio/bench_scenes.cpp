#include "bench/studio/bench_scenes.h"

#include <fmt/format.h>

#include <cmath>
#include <fstream>
#include <string>

namespace tessera {
namespace {

void write(const std::filesystem::path& file, const std::string& text) {
  std::ofstream(file) << text;
}

/// A wavy surface of about so many triangles, beside the file of its material.
void write_mesh(const std::filesystem::path& folder, size_t triangles) {
  const auto side = static_cast<size_t>(std::sqrt(static_cast<double>(triangles) / 2));
  std::string text = fmt::format("mtllib {}\nusemtl paint\n", kMeshMaterials);
  for (size_t y = 0; y <= side; ++y)
    for (size_t x = 0; x <= side; ++x) {
      const double u = static_cast<double>(x) / static_cast<double>(side) * 4 - 2;
      const double v = static_cast<double>(y) / static_cast<double>(side) * 4 - 2;
      text +=
          fmt::format("v {:.5f} {:.5f} {:.5f}\n", u, 0.1 * std::sin(9 * u) * std::cos(7 * v), v);
    }
  for (size_t y = 0; y < side; ++y)
    for (size_t x = 0; x < side; ++x) {
      const size_t a = y * (side + 1) + x + 1, b = a + side + 1;
      text += fmt::format("f {} {} {} {}\n", a, b, b + 1, a + 1);
    }
  write(folder / "mesh.obj", text);
  write(folder / kMeshMaterials, "newmtl paint\nKd 0.5 0.5 0.5\n");
  write(folder / kMesh, "includes { file: \"mesh.obj\" }\n");
}

}  // namespace

void write_bench_scenes(const std::filesystem::path& folder, size_t triangles) {
  write(folder / kDragged,
        "nodes { light { directional { direction { y: -1 z: -1 } } } }\n"
        "nodes { shape { sphere { radius: 0.5 } } }\n");
  write_mesh(folder, triangles);
}

}  // namespace tessera
