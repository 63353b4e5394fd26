#include <fmt/format.h>

#include <nlohmann/json.hpp>

#include "bench/octree.h"

namespace tessera {

std::string octree_table(const std::vector<OctreeBenchRow>& rows) {
  constexpr const char* kLine =
      "{:19} {:24} {:>5} {:>7} {:>8} {:>9} {:>8} {:>8} {:>8} {:>8} {:>8} {:>7} {:>5}\n";
  std::string text =
      fmt::format(kLine, "scene", "accelerator", "depth", "voxels", "refs", "KiB", "obj/ray",
                  "prim/ray", "node/ray", "build s", "trace s", "seconds", "diff");
  const auto number = [](double x) { return fmt::format("{:.2f}", x); };
  const auto seconds = [](double x) { return fmt::format("{:.3f}", x); };
  for (const OctreeBenchRow& r : rows) {
    const std::string approximately = r.sampled ? "~" : "";
    text +=
        fmt::format(kLine, r.scene, r.accelerator, r.depth, r.voxels, r.references, r.bytes / 1024,
                    number(r.object_tests_per_ray), number(r.primitive_tests_per_ray),
                    number(r.node_visits_per_ray), fmt::format("{:.4f}", r.build_seconds),
                    approximately + seconds(r.trace_seconds), approximately + seconds(r.seconds),
                    r.differing_pixels);
    if (const auto& p = r.published)
      text += fmt::format(kLine, "", "  published", p->depth, p->voxels, "", "",
                          number(p->object_tests_per_ray), "", number(p->node_visits_per_ray), "",
                          "", seconds(p->seconds), "");
  }
  return text;
}

std::string octree_json(const std::vector<OctreeBenchRow>& rows) {
  nlohmann::ordered_json list = nlohmann::ordered_json::array();
  for (const OctreeBenchRow& r : rows) {
    nlohmann::ordered_json row{{"scene", r.scene},
                               {"accelerator", r.accelerator},
                               {"depth", r.depth},
                               {"voxels", r.voxels},
                               {"references", r.references},
                               {"bytes", r.bytes},
                               {"mesh_depth", r.mesh_depth},
                               {"mesh_voxels", r.mesh_voxels},
                               {"object_tests_per_ray", r.object_tests_per_ray},
                               {"primitive_tests_per_ray", r.primitive_tests_per_ray},
                               {"node_visits_per_ray", r.node_visits_per_ray},
                               {"build_seconds", r.build_seconds},
                               {"trace_seconds", r.trace_seconds},
                               {"seconds", r.seconds},
                               {"differing_pixels", r.differing_pixels},
                               {"sampled", r.sampled}};
    if (const auto& p = r.published)
      row["published"] = {{"depth", p->depth},
                          {"voxels", p->voxels},
                          {"object_tests_per_ray", p->object_tests_per_ray},
                          {"node_visits_per_ray", p->node_visits_per_ray},
                          {"seconds", p->seconds}};
    list.push_back(std::move(row));
  }
  return nlohmann::ordered_json{{"rows", list}}.dump(2) + "\n";
}

}  // namespace tessera
