#include "studio/page_answer.h"

#include <filesystem>
#include <utility>

#include "base/lower_case.h"
#include "front/render_options.h"
#include "job/scene_motion.h"
#include "renderer/film/tile.h"
#include "studio/channel_view.h"
#include "studio/files/studio_settings.h"
#include "studio/files/templates.h"
#include "studio/open_documents.h"
#include "studio/scene_extent.h"
#include "studio/shell_word.h"
#include "web/web_socket.h"

namespace tessera {

namespace {

using Json = nlohmann::json;

template <typename Visit>
void for_each_render_option(const Visit& visit) {
  RenderOptions unused;
  OptionList list;
  add_render_options(list, unused);
  for (const Option& option : list) visit(option);
}

}  // namespace

SendText page_answer(ClientId client, std::string_view kind, Json fields) {
  const Json message{{std::string(kind), std::move(fields)}};
  return {client, message.dump(-1, ' ', false, Json::error_handler_t::replace)};
}

SendText refusal(ClientId client, std::string_view request, std::string_view file,
                 std::string_view why, uint64_t number, const ExistingFiles& existing) {
  Json fields{{"request", request}, {"why", why}};
  if (number != 0) fields["number"] = number;
  if (existing.count > 0)
    fields["existing"] = {{"first", existing.first}, {"count", existing.count}};
  if (!file.empty()) fields["file"] = file;
  return page_answer(client, "refused", std::move(fields));
}

std::string language_of(std::string_view file) {
  const std::string ending = lower_case(std::filesystem::path(file).extension().string());
  return ending.empty() ? "" : ending.substr(1);
}

Json draft_json(const TextDraft& draft) {
  return {{"text", draft.text}, {"saved_at", draft.saved_at}};
}

Json document_json(const std::string& file, const Document& document, const Digest& hash,
                   bool is_read_only, bool is_dirty, const TextDraft* draft) {
  Json fields{{"file", file},
              {"version", document.version()},
              {"text", document.text()},
              {"hash", hash.hex()},
              {"eol", document.line_ends()},
              {"bom", document.has_byte_order_mark()},
              {"encoding", document.encoding()},
              {"editable", document.is_editable()},
              {"read_only", is_read_only},
              {"dirty", is_dirty},
              {"language", language_of(file)}};
  if (!document.is_editable()) fields["why"] = document.why_not_editable();
  if (draft != nullptr) fields["draft"] = draft_json(*draft);
  return fields;
}

Json choices_json() {
  Json names{{"channel", std::vector<std::string>(channel_names().begin(), channel_names().end())}};
  for_each_render_option([&names](const Option& option) {
    if (!option.choices.empty()) names[option.long_name()] = option.choices;
  });
  return names;
}

Json limits_json() {
  Json most{{"text", Document::kMostBytes},
            {"message", WebSocketLimits().message_bytes},
            {"files", OpenDocuments::kMostOpen},
            {"nice", StudioSettings::kMostNice},
            {"side", kMaxFrameSide},
            {"view_side", page::kMostViewSide},
            {"pixels", page::kMostViewPixels},
            {"frames", page::kMostFrames}};
  for_each_render_option([&most](const Option& option) {
    if (option.most != 0) most[option.long_name()] = option.most;
  });
  return most;
}

Json templates_json() {
  Json list = Json::array();
  for (const SceneTemplate& each : scene_templates())
    list.push_back({{"id", each.id}, {"title", each.title}});
  return list;
}

Json recent_json(const std::vector<std::string>& folders, const std::string& served) {
  Json list = Json::array();
  for (const std::string& each : folders) {
    if (each != served)
      list.push_back({{"folder", each}, {"command", "tessera studio " + shell_word(each)}});
  }
  return list;
}

Json files_json(const FileList& list) {
  Json entries = Json::array();
  for (const FileEntry& entry : list.entries)
    entries.push_back({{"name", entry.name}, {"kind", name_of(entry.kind)}, {"size", entry.size}});
  return {{"entries", std::move(entries)}, {"truncated", list.is_truncated}};
}

Json problems_json(const SceneReading& reading) {
  Json list = Json::array();
  for (const Problem& problem : reading.problems) {
    const auto text = reading.texts.find(problem.file);
    list.push_back({{"severity", problem.is_error ? "error" : "warning"},
                    {"file", problem.file},
                    {"version", text == reading.texts.end() ? 0 : text->second.version()},
                    {"line", problem.line},
                    {"column", problem.column},
                    {"end_line", problem.end_line},
                    {"end_column", problem.end_column},
                    {"message", problem.message},
                    {"found", problem.found},
                    {"expected", problem.expected},
                    {"suggestion", problem.suggestion}});
  }
  return {{"file", reading.file}, {"version", reading.version}, {"list", std::move(list)}};
}

Json summary_json(const SceneReading& reading) {
  const v1::Scene& scene = reading.scene->loaded.scene;
  Json counts = Json::array(), cameras = Json::array();
  for (const SceneSummary::Count& count : reading.summary.counts)
    counts.push_back({count.what, count.count});
  for (const v1::Camera& camera : scene.cameras()) {
    const FreeCamera numbers = free_camera_of(camera, reading.bounds);
    cameras.push_back({{"name", camera.name()},
                       {"description", camera.description()},
                       {"eye", numbers.eye},
                       {"target", numbers.target},
                       {"up", numbers.up},
                       {"fov", numbers.fov},
                       {"axis", numbers.axis}});
    if (camera.has_spherical() || camera.has_cylindrical()) cameras.back()["panoramic"] = true;
    if (numbers.orthographic) cameras.back()["orthographic"] = *numbers.orthographic;
  }
  const Bounds3& box = reading.bounds;
  Json bounds;
  if (!box.empty()) bounds = {{box.min.x, box.min.y, box.min.z}, {box.max.x, box.max.y, box.max.z}};
  const v1::FrameSettings& settings = reading.settings;
  Json animation;
  if (scene.settings().has_frames()) {
    const v1::Frames& frames = scene.settings().frames();
    animation = {{"first", frames.first()}, {"last", frames.last()}};
    if (frames.per_second() > 0) animation["per_second"] = frames.per_second();
  }
  return {{"file", reading.file},
          {"version", reading.version},
          {"revision", reading.revision},
          {"size", {settings.width(), settings.height()}},
          {"samples", settings.samples_per_pixel()},
          {"integrator", settings.integrator()},
          {"bounds", std::move(bounds)},
          {"animation", std::move(animation)},
          {"digest", reading.scene->digest},
          {"counts", std::move(counts)},
          {"cameras", std::move(cameras)},
          {"depends_on_frame", reading.scene->loaded.depends_on_frame || moves(scene)},
          {"seconds", reading.seconds}};
}

Json probed_json(const ViewId& view, int x, int y,
                 const std::optional<PictureStream::Value>& value) {
  Json fields{{"pane", view.pane}, {"x", x}, {"y", y}};
  if (value) {
    fields["channels"] = value->channels;
    fields["values"] = value->values;
    fields["shown"] = value->shown;
  }
  return fields;
}

Json tiles_json(const ViewId& view, const PassTiles& tiles, int scale) {
  Json list = Json::array();
  for (size_t i = 0; i < tiles.tiles.size(); ++i) {
    const PixelRect& rect = tiles.tiles[i].rect;
    list.push_back({rect.x0, rect.y0, rect.width(), rect.height(), tiles.workers[i]});
  }
  return {
      {"pane", view.pane}, {"serial", tiles.serial}, {"scale", scale}, {"list", std::move(list)}};
}

Json legend_json(const ViewId& view, const Legend& legend) {
  return {{"pane", view.pane},        {"channel", name_of_channel(legend.channel)},
          {"scale", legend.is_scale}, {"known", legend.is_known},
          {"low", legend.low},        {"high", legend.high},
          {"mean", legend.mean},      {"steps", legend.steps}};
}

}  // namespace tessera
