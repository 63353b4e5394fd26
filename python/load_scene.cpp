#include <pybind11/stl.h>
#include <spdlog/spdlog.h>

#include <algorithm>
#include <memory>
#include <optional>

#include "base/error.h"
#include "front/check_buildable.h"
#include "front/load_frame.h"
#include "front/option_list.h"
#include "front/placement.h"
#include "front/read_options.h"
#include "front/texture_decoder.h"
#include "python/bindings.h"
#include "python/gil.h"
#include "python/interruptible.h"
#include "python/scene_values.h"
#include "renderer/scene/scene.h"
#include "renderer/scene/scene_builder.h"
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
  LoadedScene loaded = run_abandonably(
      [path, reading](const std::atomic<bool>&) { return read_scene(path, reading); });
  SceneWithBlobs read{std::move(loaded.scene), std::move(loaded.blobs)};
  const py::object scene = value_of(read);
  free_unlocked(std::move(read));
  return py::make_tuple(scene, loaded.warnings);
}

std::shared_ptr<const Scene> build(const SceneWithBlobs& made, const RenderOptions& options) {
  auto built = check_buildable(options, load_frame(options, made, 0));
  for (const std::string& warning : build_warnings(built->counters)) spdlog::warn(warning);
  return built;
}

/// Around every surface at the scene's instant; nothing where there is none, or where the scene
/// cannot be rendered.
std::optional<Bounds3> bounds_of(const SceneWithBlobs& made, const RenderOptions& options) {
  try {
    const auto built = build(made, options);
    if (!built->surfaces) return std::nullopt;
    const Bounds3 box = built->surfaces->bounds();
    return box.min.x <= box.max.x ? std::optional(box) : std::nullopt;
  } catch (const Error& error) {
    if (error.code() != ExitCode::bad_scene) throw;
    return std::nullopt;
  }
}

py::tuple corner_of(const Point3& corner) { return py::make_tuple(corner.x, corner.y, corner.z); }

/// (counts by what is counted, what is never used, what is used and never defined, bounds).
py::tuple summary_of(py::handle scene, const std::string& assets) {
  const auto [summary, bounds] = run_abandonably(
      [made = message_of(scene), options = options_of_python(assets)](const std::atomic<bool>&) {
        return std::pair(summarize(made.scene, made.blobs), bounds_of(made, options));
      });
  py::dict counts;
  for (const SceneSummary::Count& each : summary.counts) counts[py::str(each.what)] = each.count;
  py::object corners = py::none();
  if (bounds) corners = py::make_tuple(corner_of(bounds->min), corner_of(bounds->max));
  return py::make_tuple(counts, summary.unused, summary.undefined, corners);
}

/// Throws what a render of the scene would throw before it traces. Returns names that are used and
/// never defined.
std::vector<std::string> check(py::handle scene, const std::string& assets) {
  return run_abandonably(
      [made = message_of(scene), options = options_of_python(assets)](const std::atomic<bool>&) {
        build(made, options);
        return summarize(made.scene, made.blobs).undefined;
      });
}

}  // namespace

void bind_load(py::module_& module) {
  module.def("load", &load, "Reads a scene from a file.");
  module.def("check", &check, "Raises what a render of a scene would raise before it traces.");
  module.def("summary", &summary_of, "What a scene holds.");
}

}  // namespace tessera
