#include <pybind11/stl.h>

#include <algorithm>

#include "base/error.h"
#include "front/check_buildable.h"
#include "front/load_frame.h"
#include "front/option_list.h"
#include "front/placement.h"
#include "front/read_options.h"
#include "front/texture_decoder.h"
#include "python/bindings.h"
#include "python/interruptible.h"
#include "python/scene_values.h"
#include "scenes/formats/read_scene.h"
#include "scenes/formats/scene_summary.h"

namespace py = pybind11;

namespace tessera {
namespace {

using OptionValues = std::vector<std::pair<std::string, OptionValue>>;

/// Reads a scene with the options of the group "Reading": (scene, warnings).
py::tuple load(const std::string& path, const OptionValues& values, int32_t frame) {
  ReadOptions reading{.decode_texture = decode_texture,
                      .decode_texture_bytes = decode_texture_bytes};
  reading.frame = frame;
  OptionList list;
  add_place_option(list, reading.placements);
  add_read_options(list, reading);
  for (const auto& [name, value] : values) assign_option(list, name, value);
  LoadedScene loaded =
      run_interruptibly([&](const std::atomic<bool>&) { return read_scene(path, reading); });
  return py::make_tuple(value_of({std::move(loaded.scene), std::move(loaded.blobs)}),
                        loaded.warnings);
}

/// (counts by what is counted, what is never used, what is used and never defined).
py::tuple summary_of(py::handle scene) {
  const SceneWithBlobs made = message_of(scene);
  const SceneSummary summary = run_interruptibly(
      [&](const std::atomic<bool>&) { return summarize(made.scene, made.blobs); });
  py::dict counts;
  for (const SceneSummary::Count& each : summary.counts) counts[py::str(each.what)] = each.count;
  return py::make_tuple(counts, summary.unused, summary.undefined);
}

/// Throws what a render of the scene would throw before it traces.
void check(py::handle scene) {
  const SceneWithBlobs made = message_of(scene);
  RenderOptions options;
  options.scene = kSceneOfPython;
  run_interruptibly(
      [&](const std::atomic<bool>&) { check_buildable(options, load_frame(options, made, 0)); });
}

}  // namespace

void bind_load(py::module_& module) {
  module.def("load", &load, "Reads a scene from a file.");
  module.def("check", &check, "Raises what a render of a scene would raise before it traces.");
  module.def("readable_endings", &readable_endings, "The endings of files that `load` reads.");
  module.def("summary", &summary_of, "What a scene holds.");
}

}  // namespace tessera
