// bench_rays [--side N] [--rounds N] [--accel NAME] FILE.obj | ico:SUBDIVISIONS | soup:TRIANGLES |
// sub:FILE.obj | room ...
#include <fmt/format.h>

#include <cstdlib>
#include <string>

#include "bench/generated_meshes.h"
#include "bench/rays.h"

int main(int argc, char** argv) {
  tessera::RayBenchOptions options;
  std::vector<tessera::BenchMesh> meshes;
  for (int i = 1; i < argc; ++i) {
    const std::string argument = argv[i];
    if (argument == "--side" && i + 1 < argc) {
      options.image_side = std::atoi(argv[++i]);
    } else if (argument == "--rounds" && i + 1 < argc) {
      options.rounds = std::atoi(argv[++i]);
    } else if (argument == "--accel" && i + 1 < argc) {
      const auto kind = tessera::parse_accelerator(argv[++i]);
      if (kind) options.accelerators.push_back(*kind);
    } else if (argument.starts_with("ico:")) {
      meshes.push_back({argument, tessera::icosphere(std::atoi(argument.c_str() + 4))});
    } else if (argument.starts_with("soup:")) {
      meshes.push_back({argument, tessera::triangle_soup(std::atol(argument.c_str() + 5), 1)});
    } else if (argument.starts_with("sub:")) {
      meshes.push_back({"sub:" + argument.substr(argument.rfind('/') + 1),
                        tessera::subdivided(tessera::read_plain_obj(argument.substr(4)), 2)});
    } else if (argument == "room") {
      meshes.push_back({argument, tessera::furnished_room(1), true});
    } else {
      meshes.push_back(
          {argument.substr(argument.rfind('/') + 1), tessera::read_plain_obj(argument)});
    }
    if (!meshes.empty()) tessera::drop_degenerate(meshes.back().mesh);
  }
  if (meshes.empty()) meshes.push_back({"ico:6", tessera::icosphere(6)});
  fmt::print("{:24} {:16} {:9} {:>8} {:>7} {:>10} {:>9} {:>8}\n", "scene", "accelerator", "kind",
             "Mrays/s", "ratio", "mismatches", "build s", "B/tri");
  for (const tessera::RayBenchRow& row : tessera::bench_rays(meshes, options))
    fmt::print("{:24} {:16} {:9} {:8.2f} {:7.3f} {:10} {:9.4f} {:8.1f}\n", row.scene,
               row.accelerator, row.kind, row.mrays_per_second, row.ratio_to_embree, row.mismatches,
               row.build_seconds, row.bytes_per_triangle);
}
