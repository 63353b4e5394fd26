// bench_octree [--size WxH] [--rounds N] [--accel A,B,...] [--compare A B] [--json FILE] [SCENE...]
// SCENE: uniform-diamonds, random-diamonds, concentric-spheres, clumped-diamonds, teapot, or an OBJ
// file, held as one object. --compare exits with 3 where any pixel differs.
#include <fmt/format.h>

#include <cstdio>
#include <fstream>

#include "base/error.h"
#include "bench/generated_meshes.h"
#include "bench/octree.h"

namespace {

using namespace tessera;

OctreeScene scene_of(const std::string& name) {
  if (!name.ends_with(".obj")) return make_octree_scene(name);
  OctreeScene scene;
  scene.name = name.substr(name.rfind('/') + 1);
  const TriangleMesh mesh = read_plain_obj(name);
  for (uint32_t i = 0; i < mesh.positions.size(); ++i)
    scene.mesh.positions.push_back(mesh.vertex(i));
  for (const TriangleIndices& t : mesh.triangles)
    scene.mesh.triangles.insert(scene.mesh.triangles.end(), t.begin(), t.end());
  look_at_box(mesh.bounds(), scene);
  return scene;
}

std::vector<std::string> split_at_commas(const std::string& text) {
  std::vector<std::string> parts;
  for (size_t begin = 0; begin <= text.size();) {
    const size_t end = std::min(text.find(',', begin), text.size());
    parts.push_back(text.substr(begin, end - begin));
    begin = end + 1;
  }
  return parts;
}

int run(int argc, char** argv) {
  OctreeBenchOptions options;
  std::vector<std::string> names;
  std::string json_file;
  bool compare = false;
  for (int i = 1; i < argc; ++i) {
    const std::string argument = argv[i];
    const bool more = i + 1 < argc;
    if (argument == "--size" && more) {
      if (std::sscanf(argv[++i], "%dx%d", &options.width, &options.height) != 2 ||
          options.width < 1 || options.height < 1 || options.width > 65536 ||
          options.height > 65536)
        throw usage_error("--size: expected WxH");
    } else if (argument == "--rounds" && more) {
      options.rounds = std::atoi(argv[++i]);
    } else if (argument == "--accel" && more) {
      options.accelerators = split_at_commas(argv[++i]);
    } else if (argument == "--compare" && i + 2 < argc) {
      options.accelerators = {argv[i + 1], argv[i + 2]};
      options.rounds = 1;
      compare = true;
      i += 2;
    } else if (argument == "--json" && more) {
      json_file = argv[++i];
    } else {
      names.push_back(argument);
    }
  }
  if (names.empty()) names = octree_scene_names();
  std::vector<OctreeBenchRow> rows;
  size_t differing = 0;
  for (const std::string& name : names)
    for (OctreeBenchRow& row : bench_octree(scene_of(name), options)) {
      differing += row.differing_pixels;
      rows.push_back(std::move(row));
    }
  fmt::print("{}", octree_table(rows));
  if (!json_file.empty()) std::ofstream(json_file) << octree_json(rows);
  return compare && differing > 0 ? 3 : 0;
}

}  // namespace

int main(int argc, char** argv) {
  try {
    return run(argc, argv);
  } catch (const std::exception& e) {
    fmt::print(stderr, "{}\n", e.what());
    return 2;
  }
}
