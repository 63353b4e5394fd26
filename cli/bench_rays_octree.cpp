#include <fmt/format.h>

#include <CLI/CLI.hpp>
#include <algorithm>
#include <memory>
#include <nlohmann/json.hpp>

#include "base/file.h"
#include "bench/octree.h"
#include "bench/rays.h"
#include "bench/scene_mesh.h"
#include "cli/command_line.h"
#include "cli/option_values.h"
#include "cli/say.h"
#include "scenes/formats/read_scene.h"
#include "scenes/generate/generate_scene.h"

namespace tessera {
namespace {

struct TracingBenchOptions {
  std::vector<std::string> scenes;
  std::string json_file;
  RayBenchOptions rays;
  OctreeBenchOptions octree;
  bool compare = false;
};

/// "icosphere:6" and the like are generated, all else is a file.
TriangleMesh mesh_named(const std::string& name) {
  const LoadedScene loaded =
      name.find(':') != std::string::npos ? generate_scene(name) : read_scene(name);
  return mesh_of_scene(loaded.scene, loaded.blobs);
}

ExitCode rays(const TracingBenchOptions& options) {
  if (!options.json_file.empty()) check_output_file(options.json_file, "--json");
  std::vector<BenchMesh> meshes;
  for (const std::string& name : options.scenes) meshes.push_back({name, mesh_named(name)});
  say("{:24} {:16} {:9} {:>8} {:>7} {:>10} {:>9} {:>8}\n", "scene", "accelerator", "kind",
      "Mrays/s", "ratio", "mismatches", "build s", "B/tri");
  auto rows = nlohmann::ordered_json::array();
  for (const RayBenchRow& row : bench_rays(meshes, options.rays)) {
    say("{:24} {:16} {:9} {:8.2f} {:7.3f} {:10} {:9.4f} {:8.1f}\n", row.scene, row.accelerator,
        row.kind, row.mrays_per_second, row.ratio_to_embree, row.mismatches, row.build_seconds,
        row.bytes_per_triangle);
    rows.push_back({{"scene", row.scene},
                    {"accelerator", row.accelerator},
                    {"kind", row.kind},
                    {"mrays_per_second", row.mrays_per_second},
                    {"ratio_to_embree", row.ratio_to_embree},
                    {"mismatches", row.mismatches},
                    {"build_seconds", row.build_seconds},
                    {"bytes_per_triangle", row.bytes_per_triangle}});
  }
  if (!options.json_file.empty())
    write_output_file(options.json_file, nlohmann::ordered_json{{"rows", rows}}.dump(2) + "\n");
  return ExitCode::done;
}

OctreeScene octree_scene(const std::string& name) {
  const auto& known = octree_scene_names();
  if (std::find(known.begin(), known.end(), name) != known.end()) return make_octree_scene(name);
  const TriangleMesh mesh = mesh_named(name);
  OctreeScene scene;
  scene.name = name;
  for (uint32_t i = 0; i < mesh.positions.size(); ++i)
    scene.mesh.positions.push_back(mesh.vertex(i));
  for (const TriangleIndices& t : mesh.triangles)
    scene.mesh.triangles.insert(scene.mesh.triangles.end(), t.begin(), t.end());
  look_at_box(mesh.bounds(), scene);
  return scene;
}

ExitCode octree(const TracingBenchOptions& options) {
  if (!options.json_file.empty()) check_output_file(options.json_file, "--json");
  OctreeBenchOptions bench = options.octree;
  if (options.compare) {
    bench.accelerators = {"bvh", "octree", "nonuniform-octree"};
    bench.rounds = 1;
  }
  std::vector<OctreeBenchRow> rows;
  size_t differing = 0;
  for (const std::string& name : options.scenes.empty() ? octree_scene_names() : options.scenes) {
    for (OctreeBenchRow& row : bench_octree(octree_scene(name), bench)) {
      differing += row.differing_pixels;
      rows.push_back(std::move(row));
    }
  }
  say("{}", octree_table(rows));
  if (!options.json_file.empty()) write_output_file(options.json_file, octree_json(rows));
  if (options.compare && differing > 0)
    throw render_error(fmt::format("{} pixels differ between accelerators", differing));
  return ExitCode::done;
}

void add_common(CLI::App& command, TracingBenchOptions& options, int& rounds) {
  command.add_option("--json", options.json_file, "Write the rows as JSON too")->type_name("FILE");
  command
      .add_option_function<std::string>(
          "--rounds",
          [&rounds](const std::string& text) {
            rounds = static_cast<int>(parse_whole("--rounds", text, 1, 1000));
          },
          "How often each is measured")
      ->type_name("N");
}

}  // namespace

void add_tracing_benches(CLI::App& bench, Action& action) {
  auto options = std::make_shared<TracingBenchOptions>();
  CLI::App* rays_command = bench.add_subcommand("rays", "Rays a second, beside Embree's");
  rays_command->add_option("SCENE", options->scenes, "Files, or as icosphere:6 [icosphere:6]");
  rays_command->footer(
      "Rays of each kind through each of our accelerators and Embree's, by turns; the hits that\n"
      "differ are counted. Scenes are of triangles only; icosphere:N and soup:N are made up.\n"
      "Examples:\n"
      "  tessera bench rays bunny.obj\n"
      "  tessera bench rays icosphere:6 soup:100000 --rounds 9 --json rays.json");
  add_common(*rays_command, *options, options->rays.rounds);
  rays_command->callback([options, &action] {
    if (options->scenes.empty()) options->scenes = {"icosphere:6"};
    action = [options] { return rays(*options); };
  });
  CLI::App* octree_command = bench.add_subcommand("octree", "The octree study's experiment");
  octree_command->add_option(
      "SCENE", options->scenes,
      fmt::format("{}, or files [the study's]", fmt::join(octree_scene_names(), ", ")));
  octree_command->footer(
      "Node visits and object tests a ray, and seconds, of the uniform and the non-uniform "
      "octree.\n"
      "Examples:\n"
      "  tessera bench octree teapot --size 960x540\n"
      "  tessera bench octree --compare                     every scene through every tree");
  add_common(*octree_command, *options, options->octree.rounds);
  octree_command
      ->add_option_function<std::string>(
          "--size",
          [options](const std::string& text) {
            const FrameSize size = parse_size("--size", text);
            options->octree.width = size.width;
            options->octree.height = size.height;
          },
          "Width and height in pixels [1920x1080]")
      ->type_name("WxH");
  octree_command->add_flag("--compare", options->compare,
                           "Once through each tree; exit code 3 where any pixel differs");
  octree_command->callback([options, &action] { action = [options] { return octree(*options); }; });
}

}  // namespace tessera
