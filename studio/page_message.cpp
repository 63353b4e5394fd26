#include "studio/page_message.h"

#include <fmt/format.h>

#include <cmath>
#include <functional>
#include <nlohmann/json.hpp>

#include "base/error.h"
#include "studio/files/studio_settings.h"
#include "studio/open_documents.h"
#include "studio/page_fields.h"
#include "studio/page_json.h"
#include "studio/view_panes.h"

namespace tessera::page {
namespace {

using Json = nlohmann::json;

constexpr int64_t kMostVersion = int64_t{1} << 53;
constexpr int kMostFrame = 999'999'999;
constexpr size_t kMostOutputs = 8;

template <typename OfFile>
OfFile of_file(const Fields& fields) {
  OfFile message;
  fields.get("file", message.file);
  return message;
}

Message hello(const Fields& fields) {
  Hello message;
  fields.get("token", message.token);
  fields.get("resume", message.resume);
  if (const Json* have = fields.find("have")) {
    if (!have->is_object() || have->size() > OpenDocuments::kMostOpen)
      throw wrong("have", "no list", fmt::format("at most {} files", OpenDocuments::kMostOpen));
    for (const auto& [file, known] : have->items()) {
      if (!known.is_array() || known.size() != 2 || !known[1].is_string())
        throw wrong(file, known.dump(), "[version, hash]");
      message.have[file] = {
          static_cast<uint64_t>(Fields::whole("version", known[0], 0, kMostVersion)),
          known[1].get<std::string>()};
    }
  }
  return message;
}

Message edit(const Fields& fields) {
  constexpr int64_t kMostOffset = int64_t{1} << 32;
  Edit message;
  fields.get("file", message.file);
  fields.get_whole("base", message.base, 0, kMostVersion);
  const Json* changes = fields.find("changes");
  if (!changes || !changes->is_array())
    throw wrong("changes", "none", "a list of [from, to, text]");
  for (const Json& change : *changes) {
    if (!change.is_array() || change.size() != 3 || !change[2].is_string())
      throw wrong("changes", change.dump(), "[from, to, text]");
    message.changes.push_back(
        {static_cast<size_t>(Fields::whole("from", change[0], 0, kMostOffset)),
         static_cast<size_t>(Fields::whole("to", change[1], 0, kMostOffset)),
         change[2].get<std::string>()});
  }
  return message;
}

Message save(const Fields& fields) {
  Save message;
  fields.get("file", message.file);
  fields.get("as", message.as);
  fields.get("force", message.force);
  return message;
}

Message close(const Fields& fields) {
  Close message;
  fields.get("file", message.file);
  fields.get("discard", message.discard);
  return message;
}

Message recover(const Fields& fields) {
  Recover message;
  fields.get("file", message.file);
  fields.get("take", message.take);
  return message;
}

FreeCamera free_camera(const Fields& fields) {
  FreeCamera camera;
  fields.get("eye", camera.eye);
  fields.get("target", camera.target);
  fields.get("up", camera.up);
  fields.get("fov", camera.fov);
  fields.get("axis", camera.axis);
  if (fields.find("orthographic")) fields.get("orthographic", camera.orthographic.emplace());
  if (!(camera.fov > 0 && camera.fov < 180))
    throw wrong("fov", fmt::format("{}", camera.fov), "degrees above 0 and below 180");
  return camera;
}

template <typename Seen>
void get_camera(const Json& json, Seen& view) {
  if (!json.is_object()) throw wrong("camera", json.dump(), "an object, or null");
  const Fields fields(json);
  fields.get("name", view.camera);
  if (view.camera.empty() || fields.find("eye")) view.free_camera = free_camera(fields);
}

Message view(const Fields& fields) {
  View message;
  fields.get_whole("pane", message.pane, 0, kPanes - 1);
  fields.get("file", message.file);
  fields.get("sample", message.is_sample);
  const Json* size = fields.find("size");
  if (!size || !size->is_array() || size->size() != 2)
    throw wrong("size", "none", "[width, height]");
  message.width = static_cast<int>(Fields::whole("size", (*size)[0], 1, kMostViewSide));
  message.height = static_cast<int>(Fields::whole("size", (*size)[1], 1, kMostViewSide));
  if (int64_t{message.width} * message.height > kMostViewPixels)
    throw wrong("size", size->dump(), fmt::format("at most {} pixels", kMostViewPixels));
  if (const Json* camera = fields.find("camera")) get_camera(*camera, message);
  fields.get("moving", message.moving);
  fields.get_whole("frame", message.frame, INT32_MIN, INT32_MAX);
  fields.get("mode", message.mode);
  if (message.mode != "typing" && message.mode != "save" && message.mode != "hand")
    throw wrong("mode", message.mode, "typing, save or hand");
  fields.get("overrides", message.overrides);
  fields.get("channel", message.channel);
  fields.get("aovs", message.aovs);
  fields.get("tiles", message.tiles);
  fields.get("tone", message.tone);
  fields.get("hidden", message.filter.hidden);
  fields.get("solo", message.filter.solo);
  fields.get("known", message.known);
  return message;
}

Message pane_order(const Fields& fields, PaneOrder::What what) {
  PaneOrder message{.what = what};
  fields.get_whole("pane", message.pane, 0, kPanes - 1);
  return message;
}

template <typename OfPixel>
OfPixel of_pixel(const Fields& fields) {
  OfPixel message;
  fields.get_whole("pane", message.pane, 0, kPanes - 1);
  fields.get_whole("x", message.x, 0, kMostViewSide);
  fields.get_whole("y", message.y, 0, kMostViewSide);
  return message;
}

template <typename OfPane>
OfPane of_pane(const Fields& fields) {
  OfPane message;
  fields.get_whole("pane", message.pane, 0, kPanes - 1);
  return message;
}

Message pin(const Fields& fields) {
  using What = Pin::What;
  auto message = of_pane<Pin>(fields);
  std::string what = "shown";
  fields.get("what", what);
  if (what != "shown" && what != "before" && what != "none")
    throw wrong("what", what, "shown, before or none");
  message.what = what == "shown" ? What::shown : what == "before" ? What::before : What::none;
  return message;
}

Render render_of(const Fields& fields, const Json* json) {
  Render message;
  fields.get("file", message.file);
  if (!json) return message;
  if (!json->is_object()) throw wrong("spec", json->dump(), "an object");
  const Fields spec(*json);
  if (const Json* camera = spec.find("camera")) get_camera(*camera, message);
  if (spec.find("frame")) spec.get_whole("frame", message.frame.emplace(), 0, kMostFrame);
  if (const Json* frames = spec.find("frames")) {
    if (!frames->is_array() || frames->size() != 2)
      throw wrong("frames", frames->dump(), "[first, last]");
    message.frames =
        FrameRange{static_cast<int>(Fields::whole("frames", (*frames)[0], 0, kMostFrame)),
                   static_cast<int>(Fields::whole("frames", (*frames)[1], 0, kMostFrame))};
    if (message.frames->first > message.frames->last)
      throw wrong("frames", frames->dump(), "the first before the last");
    if (message.frames->last - message.frames->first >= kMostFrames)
      throw wrong("frames", frames->dump(), fmt::format("at most {} of them", kMostFrames));
  }
  if (spec.find("per_second")) {
    spec.get("per_second", message.frame_rate.emplace());
    if (!(*message.frame_rate > 0)) throw wrong("per_second", "no such rate", "a number above 0");
  }
  spec.get("overrides", message.options);
  spec.get("tone", message.options);
  if (const Json* outputs = spec.find("outputs")) {
    if (!outputs->is_array() || outputs->size() > kMostOutputs)
      throw wrong("outputs", outputs->dump(),
                  fmt::format("a list of at most {} names", kMostOutputs));
    for (const Json& name : *outputs) {
      if (!name.is_string()) throw wrong("outputs", name.dump(), "a name");
      message.outputs.push_back(name.get<std::string>());
    }
  }
  spec.get("statistics", message.statistics);
  spec.get("force", message.force);
  return message;
}

Message render(const Fields& fields) {
  Render message = render_of(fields, fields.find("spec"));
  fields.get_whole("number", message.number, 0, kMostVersion);
  return message;
}

Message render_order(const Fields& fields) {
  using What = RenderOrder::What;
  static const std::map<std::string, What, std::less<>> words{{"pause", What::pause},
                                                              {"resume", What::resume},
                                                              {"cancel", What::cancel},
                                                              {"forget", What::forget}};
  RenderOrder message;
  fields.get_whole("job", message.job, 0, kMostVersion);
  std::string what;
  fields.get("what", what);
  const auto word = words.find(what);
  if (word == words.end()) throw wrong("what", what, "pause, resume, cancel or forget");
  message.what = word->second;
  return message;
}

Message export_file(const Fields& fields) {
  Export message;
  fields.get_whole("number", message.number, 0, kMostVersion);
  if (fields.find("job")) fields.get_whole("job", message.job.emplace(), 0, kMostVersion);
  fields.get_whole("pane", message.pane, 0, kPanes - 1);
  fields.get("file", message.file);
  fields.get("name", message.name);
  fields.get("download", message.is_download);
  fields.get("show", message.is_shown);
  fields.get("statistics", message.statistics);
  fields.get("force", message.force);
  if (const Json* spec = fields.find("command")) message.command = render_of(fields, spec);
  return message;
}

edit::Placement placement_of(const Json& json) {
  if (!json.is_object()) throw wrong("placement", json.dump(), "an object");
  const Fields fields(json);
  edit::Placement placement;
  fields.get("file", placement.file);
  fields.get("material", placement.material);
  fields.get_three("position", placement.position);
  fields.get_three("rotation", placement.rotation);
  fields.get_three("scale", placement.scale);
  fields.get_three("flip", placement.flip);
  return placement;
}

Message source(const Fields& fields, Source::What what) {
  Source message{.what = what, .file = {}};
  fields.get("file", message.file);
  fields.get_whole("base", message.base, 0, kMostVersion);
  fields.get("entity", message.entity);
  fields.get("field", message.field);
  fields.get("text", message.text);
  fields.get("kind", message.kind);
  fields.get("options", message.options);
  fields.get_whole("offset", message.offset, 0, int64_t{1} << 32);
  fields.get_whole("number", message.number, 0, kMostVersion);
  if (const Json* camera = fields.find("camera"); camera && camera->is_object())
    message.camera = free_camera(Fields(*camera));
  fields.get("aspect", message.aspect);
  if (const Json* placement = fields.find("placement"))
    message.placement = placement_of(*placement);
  if (fields.find("position")) fields.get("position", message.position.emplace());
  return message;
}

Message create(const Fields& fields) {
  Create message;
  fields.get("template", message.from_template);
  fields.get("model", message.model);
  fields.get("sample", message.sample);
  return message;
}

Message put(const Fields& fields) {
  Put message;
  fields.get("name", message.name);
  fields.get_whole("size", message.size, 0, kMostVersion);
  fields.get_whole("number", message.number, 0, UINT32_MAX);
  return message;
}

template <typename Kept>
Kept kept_object(const std::string& kind, const Json& fields) {
  Kept kept{fields.dump()};
  if (kept.json.size() > StudioSettings::kMostBytes)
    throw wrong(kind, fmt::format("{} bytes", kept.json.size()),
                fmt::format("at most {}", StudioSettings::kMostBytes));
  return kept;
}

using Parser = std::function<Message(const Fields&)>;

const std::map<std::string, Parser, std::less<>>& parsers() {
  using What = PaneOrder::What;
  const auto order = [](What what) {
    return [what](const Fields& fields) { return pane_order(fields, what); };
  };
  static const std::map<std::string, Parser, std::less<>> all{
      {"hello", hello},
      {"list", [](const Fields&) { return List{}; }},
      {"open", of_file<Open>},
      {"close", close},
      {"reload", of_file<Reload>},
      {"take_over", of_file<TakeOver>},
      {"edit", edit},
      {"save", save},
      {"recover", recover},
      {"view", view},
      {"pause", order(What::pause)},
      {"resume", order(What::resume)},
      {"stop", order(What::stop)},
      {"refresh", order(What::refresh)},
      {"close_view", order(What::close)},
      {"probe", of_pixel<Probe>},
      {"pick", of_pixel<Pick>},
      {"parts", of_pane<Parts>},
      {"centers", of_file<Centers>},
      {"pin", pin},
      {"compare", of_pane<Compare>},
      {"render", render},
      {"order", render_order},
      {"export", export_file},
      {"create", create},
      {"put", put},
  };
  return all;
}

/// The number of a message whose fields may be wrong; 0: it has none.
uint64_t number_of(const Json& fields) {
  const auto at = fields.find("number");
  return at != fields.end() && at->is_number_unsigned() ? at->get<uint64_t>() : 0;
}

/// Messages that change no text, no file and no job.
struct ForViewers {
  bool operator()(const page::Hello&) const { return true; }
  bool operator()(const page::List&) const { return true; }
  bool operator()(const page::Open&) const { return true; }
  bool operator()(const page::Close& close) const { return !close.discard; }
  bool operator()(const page::View&) const { return true; }
  bool operator()(const page::PaneOrder&) const { return true; }
  bool operator()(const page::Pin&) const { return true; }
  bool operator()(const page::Compare&) const { return true; }
  bool operator()(const page::Probe&) const { return true; }
  bool operator()(const page::Pick&) const { return true; }
  bool operator()(const page::Parts&) const { return true; }
  bool operator()(const page::Centers&) const { return true; }
  bool operator()(const page::Source& source) const { return !source.changes_text(); }
  /// Whatever is not named above changes something.
  template <typename Other>
  bool operator()(const Other&) const {
    return false;
  }
};

}  // namespace

std::optional<Message> parse_message(std::string_view text, MessageName* name) {
  const Json json = parse_object(text);
  const std::string& kind = json.begin().key();
  const Json& fields = json.begin().value();
  if (name) *name = {kind, number_of(fields)};
  if (kind == "settings") return kept_object<Settings>(kind, fields);
  if (kind == "workspace") return kept_object<Workspace>(kind, fields);
  const auto parser = parsers().find(kind);
  if (parser == parsers().end()) {
    const auto asked = source_of(kind);
    return asked ? std::optional(source(Fields(fields), *asked)) : std::nullopt;
  }
  return parser->second(Fields(fields));
}

bool is_for_viewers(const Message& message) { return std::visit(ForViewers(), message); }

}  // namespace tessera::page
