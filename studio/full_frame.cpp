#include "studio/full_frame.h"

#include <fmt/format.h>

#include <algorithm>
#include <filesystem>
#include <nlohmann/json.hpp>
#include <utility>

#include "base/error.h"
#include "front/load_frame.h"
#include "front/output_settings.h"
#include "front/picture.h"
#include "front/render_frame.h"
#include "proto/wire/scene_codec.h"
#include "studio/render_orders.h"
#include "studio/shell_word.h"
#include "studio/view_options.h"

namespace tessera {
namespace {

/// The scene that was read, with the digest of what was rendered.
FrameScene rendered_scene(const FullFrame& frame) {
  FrameScene scene = *frame.reading->scene;
  scene.digest = scene_digest(job_of(frame).scene);
  return scene;
}

}  // namespace

RenderOptions full_options(const page::Render& wish, const std::string& scene_path) {
  RenderOptions options;
  options.scene = scene_path;
  auto given = wish.options;
  take_denoise(given, options);
  OptionList list;
  add_scene_options(list, options);
  assign_options(list, given);
  if (!wish.camera.empty()) options.camera = wish.camera;
  // Where files are read is the program's business, and frames are jobs of their own here.
  options.reading = {};
  options.frames.reset();
  options.frames_per_second = wish.frame_rate;
  return options;
}

std::optional<int> frame_number(const FrameScene& scene, std::optional<int> frame) {
  const bool is_animated = scene.loaded.depends_on_frame || frame.value_or(0) != 0;
  return is_animated ? frame : std::nullopt;
}

JobSpec job_of(const FullFrame& frame) {
  const FrameScene& scene = *frame.reading->scene;
  JobSpec job = FrameRender(*frame.options, scene, frame.number).job(scene.loaded);
  apply_scene_options(*frame.options, job.scene);
  hide_nodes(frame.reading->hidden, job.scene);
  if (frame.camera) {
    use_free_camera(job.scene, job.frame.camera(), *frame.camera);
    job.frame.clear_camera();
  }
  return job;
}

std::shared_ptr<const RenderedPicture> picture_of(const FullFrame& frame, JobResult result,
                                                  double seconds) {
  const FrameScene scene = rendered_scene(frame);
  const FrameRender render(*frame.options, scene, frame.number);
  if (const auto failure = render.failure(result.report)) throw Error(*failure);
  auto picture = std::make_shared<RenderedPicture>(render.picture(result));
  FrameStatistics statistics = render.statistics(
      *picture, {.parse = scene.load_seconds, .write = 0, .total = scene.load_seconds + seconds},
      0);
  statistics.pixels_sha256 = picture->film.pixels_sha256();
  picture->statistics = statistics_json(statistics).dump(2) + "\n";
  return picture;
}

std::shared_ptr<const RenderedPicture> picture_of(const FullFrame& frame, const Film& film) {
  const FrameScene scene = rendered_scene(frame);
  const v1::Output& output = scene.loaded.scene.settings().output();
  const FrameRender render(*frame.options, scene, frame.number);
  return std::make_shared<RenderedPicture>(RenderedPicture{
      .film = film.with_only(film.aovs()),
      .output = output,
      .metadata =
          picture_metadata(render.settings(), frame.options->denoise, output, scene.digest)});
}

std::shared_ptr<const Film> denoised(const FullFrame& frame, const Film& film) {
  const FrameRender render(*frame.options, *frame.reading->scene, frame.number);
  JobResult result{.report = {}, .film = film.with_only(film.aovs())};
  finish_picture(*frame.options, render.settings(), result);
  return std::make_shared<const Film>(std::move(result.film));
}

std::string command_line(const page::Render& wish, const std::string& folder,
                         const std::string& assets) {
  if (wish.free_camera) return "";
  const std::string scene = folder + "/" + wish.file;
  std::string text = "tessera render " + shell_word(scene);
  // What `render` takes without being told is the scene's own folder.
  const std::string& named_in = assets.empty() ? folder : assets;
  if (std::filesystem::path(scene).parent_path() != named_in)
    text += " --assets " + shell_word(named_in);
  if (!wish.camera.empty()) text += " --camera " + shell_word(wish.camera);
  if (wish.frames) {
    text += fmt::format(" --frames {}-{}", wish.frames->first, wish.frames->last);
    if (wish.frame_rate) text += fmt::format(" --fps {}", *wish.frame_rate);
  } else if (wish.frame.value_or(0) != 0) {
    text += fmt::format(" --frames {0}-{0}", *wish.frame);
  }
  RenderOptions unused;
  OptionList list;
  add_render_options(list, unused);
  for (const auto& [name, value] : wish.options) {
    const auto option = std::find_if(list.begin(), list.end(), [&name = name](const Option& each) {
      return each.long_name() == name;
    });
    if (option == list.end()) continue;
    const bool is_flag = option->type.empty();
    if (is_flag && value == "false") continue;
    text += " --" + name;
    if (!is_flag) text += " " + shell_word(value);
  }
  for (const std::string& name : wish.outputs) text += " -o " + shell_word(folder + "/" + name);
  if (wish.statistics && !wish.outputs.empty())
    text += " --stats " + shell_word(folder + "/" + statistics_name(wish.outputs.front()));
  return text;
}

}  // namespace tessera
