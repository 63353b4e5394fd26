#include "studio/view_options.h"

#include <fmt/format.h>

#include <algorithm>

#include "base/error.h"
#include "front/option_list.h"
#include "front/output_settings.h"

namespace tessera {
namespace {

using Overrides = std::vector<std::pair<std::string, std::string>>;

}  // namespace

void assign_options(const OptionList& list, const Overrides& overrides) {
  for (const auto& [name, text] : overrides) {
    const auto option = std::find_if(list.begin(), list.end(), [&name = name](const Option& each) {
      return each.long_name() == name;
    });
    const bool is_flag = option != list.end() && option->type.empty();
    assign_option(list, name, is_flag ? OptionValue(text == "true") : OptionValue(text));
  }
}

void take_denoise(Overrides& given, RenderOptions& options) {
  std::erase_if(given, [&options](const auto& option) {
    if (option.first != "denoise") return false;
    options.denoise = option.second != "false";
    return true;
  });
}

RenderOptions view_options(const page::View& wish, const std::string& scene_path) {
  RenderOptions options;
  options.scene = scene_path;
  Overrides overrides = wish.overrides;
  take_denoise(overrides, options);
  OptionList list;
  add_scene_options(list, options);
  assign_options(list, overrides);
  options.size = FrameSize{wish.width, wish.height};
  if (!wish.camera.empty()) options.camera = wish.camera;
  return options;
}

OutputSettings view_output(const page::View& wish, const std::string& scene_path,
                           const v1::Output& of_scene) {
  OutputOptions options;
  OptionList list;
  add_output_options(list, options);
  assign_options(list, wish.tone);
  return output_settings(scene_path, of_scene, options);
}

std::string view_settings(const page::View& wish, bool has_aovs) {
  std::string text = fmt::format("{}\n{}\n{}\n", wish.frame, wish.camera, has_aovs);
  if (const auto& camera = wish.free_camera) {
    text +=
        fmt::format("{} {} {} {} {}", fmt::join(camera->eye, " "), fmt::join(camera->target, " "),
                    fmt::join(camera->up, " "), camera->fov, camera->axis);
    if (camera->orthographic) text += fmt::format(" {}", *camera->orthographic);
  }
  Overrides overrides = wish.overrides;
  std::sort(overrides.begin(), overrides.end());
  for (const auto& [name, value] : overrides) text += fmt::format("\n{}={}", name, value);
  const auto add = [&text](std::string_view what, const std::vector<EntityRef>& entities) {
    for (const EntityRef& each : entities)
      text += fmt::format("\n{} {}: {}", what, each.file, each.entity);
  };
  add("hidden", wish.filter.hidden);
  add("solo", wish.filter.solo);
  return text;
}

}  // namespace tessera
