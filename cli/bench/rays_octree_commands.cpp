#include <fmt/format.h>

#include <CLI/CLI.hpp>
#include <algorithm>
#include <memory>
#include <nlohmann/json.hpp>

#include "base/file.h"
#include "bench/generated_meshes.h"
#include "bench/octree.h"
#include "bench/rays.h"
#include "bench/scene_mesh.h"
#include "cli/add_options.h"
#include "cli/bench/bench_commands.h"
#include "cli/say.h"
#include "front/option_values.h"
#include "renderer/accel/make_accelerator.h"
#include "scenes/formats/read_scene.h"
#include "scenes/generate/generate_scene.h"
#include "scenes/generate/octree_scenes.h"

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

/// Stand-ins for what the kernels are judged by, as far as it can be made from nothing.
const std::vector<std::string> kRayScenes{"icosphere:6", "teapot", "room", "soup:1000000",
                                          "sub:teapot"};

/// Off the axes, so that the boxes of its walls hold all of it.
void turn(BenchMesh& scene) {
  const auto turned = [](auto p) {
    const auto x = 0.8f * p.x + 0.6f * p.y, y = 0.8f * p.y - 0.6f * p.x;
    return decltype(p){x, 0.8f * y + 0.6f * p.z, 0.8f * p.z - 0.6f * y};
  };
  for (Float3& p : scene.mesh.positions) p = turned(p);
  for (Point3* p : {&scene.view->eye, &scene.view->target, &scene.view->light}) *p = turned(*p);
}

BenchMesh ray_scene(const std::string& name) {
  BenchMesh scene{name, {}, {}};
  constexpr std::string_view kSub = "sub:", kSoup = "soup:";
  if (name == "room" || name == "turned-room") {
    scene.mesh = furnished_room(1);
    scene.view = view_inside(scene.mesh.bounds());
    if (name == "turned-room") turn(scene);
  } else if (name == "teapot") {
    scene.mesh = to_triangles(pot_mesh());
  } else if (name.starts_with(kSoup)) {
    scene.mesh = triangle_soup(
        static_cast<size_t>(parse_whole(name, name.substr(kSoup.size()), 1, 50'000'000)), 1);
  } else if (name.starts_with(kSub)) {
    const BenchMesh coarse = ray_scene(name.substr(kSub.size()));
    scene.view = coarse.view;
    scene.mesh = subdivided_to_a_million(coarse.mesh);
    drop_degenerate(scene.mesh);
  } else {
    scene.mesh = mesh_named(name);
  }
  return scene;
}

ExitCode rays(const TracingBenchOptions& options) {
  if (!options.json_file.empty()) check_output_file(options.json_file, "--json");
  std::vector<BenchMesh> meshes;
  for (const std::string& name : options.scenes.empty() ? kRayScenes : options.scenes)
    meshes.push_back(ray_scene(name));
  std::vector<RayBenchRow> measured = bench_rays(meshes, options.rays);
  if (meshes.size() > 1)
    for (RayBenchRow& mean : geometric_means(measured)) measured.push_back(std::move(mean));
  say("{:24} {:16} {:9} {:>8} {:>7} {:>10} {:>8} {:>13} {:>9} {:>8}\n", "scene", "accelerator",
      "kind", "Mrays/s", "ratio", "mismatches", "checked", "unlike_embree", "build s", "B/tri");
  auto rows = nlohmann::ordered_json::array();
  for (const RayBenchRow& row : measured) {
    say("{:24} {:16} {:9} {:8.2f} {:7.3f} {:10} {:8} {:13} {:9.4f} {:8.1f}\n", row.scene,
        row.accelerator, row.kind, row.mrays_per_second, row.ratio_to_embree, row.mismatches,
        row.rays_checked, row.unlike_embree, row.build_seconds, row.bytes_per_triangle);
    rows.push_back({{"scene", row.scene},
                    {"accelerator", row.accelerator},
                    {"kind", row.kind},
                    {"mrays_per_second", row.mrays_per_second},
                    {"ratio_to_embree", row.ratio_to_embree},
                    {"mismatches", row.mismatches},
                    {"rays_checked", row.rays_checked},
                    {"unlike_embree", row.unlike_embree},
                    {"node_visits_per_ray", row.node_visits_per_ray},
                    {"primitive_tests_per_ray", row.primitive_tests_per_ray},
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
  for (const Float3& p : mesh.positions)
    scene.mesh.positions.insert(scene.mesh.positions.end(), {p.x, p.y, p.z});
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
  add_whole(command, "--rounds", 1, 1000, "How often each is measured", rounds);
}

}  // namespace

void add_tracing_benches(CLI::App& bench, Action& action) {
  auto options = std::make_shared<TracingBenchOptions>();
  CLI::App* rays_command = bench.add_subcommand("rays", "Rays a second, beside Embree's");
  rays_command->add_option(
      "SCENE", options->scenes,
      fmt::format("Files; room, teapot; soup:N, icosphere:N and other generated ones; sub:SCENE, "
                  "subdivided to a million triangles [{}]",
                  fmt::join(kRayScenes, " ")));
  rays_command->footer(
      "Rays of each kind through each of our accelerators and Embree's, by turns; the hits that\n"
      "differ are counted. Scenes are of triangles only.\n"
      "Examples:\n"
      "  tessera bench rays bunny.obj\n"
      "  tessera bench rays icosphere:6 soup:100000 --rounds 9 --json rays.json");
  add_common(*rays_command, *options, options->rays.rounds);
  rays_command
      ->add_option_function<std::string>(
          "--accel",
          [options](const std::string& text) {
            options->rays.accelerators = {
                *parse_accelerator(parse_choice("--accel", text, available_accelerators()))};
          },
          "What to measure beside Embree's own kernels [bvh]")
      ->type_name("KIND");
  rays_command->callback([options, &action] { action = [options] { return rays(*options); }; });
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
