#include "studio/live_views.h"

#include <fmt/format.h>
#include <spdlog/spdlog.h>

#include <algorithm>
#include <utility>

#include "base/error.h"
#include "front/render_frame.h"
#include "studio/files/file_name.h"
#include "studio/page_answer.h"
#include "studio/view_options.h"
#include "studio/view_panes.h"

namespace tessera {
namespace {

using Json = nlohmann::json;

LiveView::Mode mode_of(const std::string& name) {
  if (name == "save") return LiveView::Mode::on_save;
  if (name == "hand") return LiveView::Mode::by_hand;
  return LiveView::Mode::as_typed;
}

std::string_view name_of(LiveView::State state) {
  switch (state) {
    case LiveView::State::tracing:
      return "tracing";
    case LiveView::State::paused:
      return "paused";
    case LiveView::State::stopped:
      return "stopped";
    case LiveView::State::failed:
      return "failed";
    default:
      return "done";
  }
}

std::string first_error(const SceneReading& reading) {
  for (const Problem& problem : reading.problems) {
    if (problem.is_error) return problem.message;
  }
  return {};
}

}  // namespace

void LiveViews::set(ClientId client, const page::View& wish, Time now) {
  const ViewId id{client, wish.pane};
  std::shared_ptr<RenderOptions> options;
  try {
    parse_channel(wish.channel);
    if (const std::string fault = fault_of_name(wish.file); !fault.empty())
      throw scene_error(fmt::format("'{}' is no name of a file here: {}", wish.file, fault));
    if (wish.is_sample && samples_.empty())
      throw scene_error(fmt::format("'{}': no samples are installed", wish.file));
    const std::string& folder = wish.is_sample ? samples_ : folder_;
    options = std::make_shared<RenderOptions>(view_options(wish, folder + "/" + wish.file));
  } catch (const Error& error) {
    // The pane goes on showing what it shows.
    orders_.push_back(refusal(client, "view", wish.file, error.what()));
    return;
  }
  Pane& pane = panes_.try_emplace(id, serial_).first->second;
  const bool is_other_scene = key_of(pane) != key_of(wish);
  pane.wish = wish;
  pane.view.set_mode(mode_of(wish.mode));
  pane.has_aovs = pane.has_aovs || wish.aovs || aov_of(parse_channel(wish.channel));
  pane.settings = view_settings(wish, pane.has_aovs);
  if (pane.has_aovs) options->aovs = AovSet::all();
  pane.options = std::move(options);
  ask_for(key_of(pane));
  // Who comes later is told what those before were told as it was read.
  if (is_other_scene && scenes_[key_of(pane)].last)
    tell_reading(client, *scenes_[key_of(pane)].last);
  show_scene(id, pane, now);
  drop_unused_scenes();
}

void LiveViews::ask_for(const SceneKey& key) {
  const ReadScene& scene = scenes_[key];
  if (scene.asked != revision_ || scene.asked == 0) read(key);
}

void LiveViews::read(const SceneKey& key) {
  ReadScene& scene = scenes_[key];
  scene.asked = std::max<uint64_t>(revision_, 1);
  orders_.push_back(ReadOrder{.file = key.file,
                              .is_sample = key.is_sample,
                              .frame = key.frame,
                              .revision = scene.asked,
                              .texts = key.is_sample ? OpenTexts() : texts_,
                              .filter = key.filter,
                              .failure = scene.failure,
                              .failed_digest = scene.failed_digest});
}

void LiveViews::set_texts(uint64_t revision, const OpenTexts& texts) {
  revision_ = revision;
  texts_ = texts;
  for (const auto& [key, scene] : scenes_) {
    if (!key.is_sample) ask_for(key);
  }
}

void LiveViews::drop_unused_scenes() {
  std::erase_if(scenes_, [this](const auto& scene) {
    return std::none_of(panes_.begin(), panes_.end(),
                        [&](const auto& pane) { return key_of(pane.second) == scene.first; });
  });
}

void LiveViews::tell_reading(ClientId client, const SceneReading& reading) {
  if (reading.is_sample) return;  // nobody edits it
  orders_.push_back(page_answer(client, "problems", problems_json(reading)));
  if (reading.scene) orders_.push_back(page_answer(client, "summary", summary_json(reading)));
}

void LiveViews::take(std::shared_ptr<const SceneReading> reading, Time now) {
  const SceneKey key{reading->file, reading->frame, reading->is_sample, reading->filter};
  const auto at = scenes_.find(key);
  if (at == scenes_.end()) return;
  ReadScene& scene = at->second;
  if (scene.last && scene.last->revision > reading->revision) return;
  scene.last = reading;
  if (!reading->is_sample) log_.note(reading->file, reading->seconds, now);
  if (reading->scene) scene.good = reading;
  std::set<ClientId> told;
  for (auto& [id, pane] : panes_) {
    if (key_of(pane) != key) continue;
    if (told.insert(id.client).second) tell_reading(id.client, *reading);
    show_scene(id, pane, now);
  }
}

Json LiveViews::stale_json(const ReadScene& scene) {
  if (!scene.last || scene.last->scene) return {};
  return {{"as_of", scene.good ? Json(scene.good->read_at) : Json()},
          {"why", first_error(*scene.last)}};
}

void LiveViews::show_scene(const ViewId& id, Pane& pane, Time now) {
  const ReadScene& scene = scenes_[key_of(pane)];
  const bool is_asked_for = pane.asked_for.has_value();
  if (is_asked_for && scene.last && scene.last->revision >= *pane.asked_for) pane.asked_for.reset();
  const Json before = std::exchange(pane.stale, stale_json(scene));
  // What the page has is held against the newest text alone.
  const bool is_newest =
      scene.good == scene.last && scene.last && scene.last->revision >= scene.asked;
  if (!scene.good || (!pane.wish.known.empty() && !is_newest)) {
    pane.view.forget_look();
    if (pane.stale != before) tell(id, pane, name_of(pane.view.state()), {});
    return;
  }
  const FrameScene& frame_scene = *scene.good->scene;
  try {
    const OutputSettings output =
        view_output(pane.wish, pane.options->scene, frame_scene.loaded.scene.settings().output());
    const ViewChannel channel = parse_channel(pane.wish.channel);
    if (output != pane.output || channel != pane.channel) {
      orders_.push_back(ChangeOutput{id, output, channel});
      if (!std::exchange(pane.output_fault, {}).empty())
        tell(id, pane, name_of(pane.view.state()), {});
    }
    pane.output = output;
    pane.channel = channel;
    const FrameRender frame(*pane.options, frame_scene, frame_number(frame_scene, pane.wish.frame));
    pane.shows_cost = frame.settings().integrator() == "cost";
    pane.view.set_goal({pane.wish.width, pane.wish.height, frame.settings().samples_per_pixel()},
                       now);
  } catch (const Error& error) {
    pane.why_failed = error.what();
    tell(id, pane, "failed", {});
    return;
  }
  if (pane.wish.known == frame_scene.digest) {
    pane.view.forget_look();
    pane.shown = scene.good;
    return tell(id, pane, "done",
                {{"frame", pane.wish.frame}, {"digest", frame_scene.digest}, {"unchanged", true}});
  }
  pane.view.set_look({frame_scene.digest, pane.settings}, pane.wish.moving, now, is_asked_for);
  const bool is_shown =
      pane.shown && pane.shown != scene.good && pane.shown->scene->digest == frame_scene.digest;
  if (is_shown) pane.shown = scene.good;
  // No pass may come that tells so.
  if (is_shown || pane.stale != before) tell(id, pane, name_of(pane.view.state()), {});
}

void LiveViews::order(ClientId client, const page::PaneOrder& order) {
  const auto at = panes_.find({client, order.pane});
  if (at == panes_.end()) return;
  LiveView& view = at->second.view;
  switch (order.what) {
    case page::PaneOrder::What::pause:
      view.pause();
      return tell(at->first, at->second, "paused", Json::object());
    case page::PaneOrder::What::stop:
      view.stop();
      return tell(at->first, at->second, "stopped", Json::object());
    case page::PaneOrder::What::close:
      if (view.running()) orders_.push_back(EndPass{view.running()->serial});
      orders_.push_back(ForgetView{at->first});
      panes_.erase(at);
      return drop_unused_scenes();
    default:
      resume(at->first, at->second);
  }
}

void LiveViews::resume(const ViewId& id, Pane& pane) {
  const auto is_held = [&] {
    return pane.view.state() == LiveView::State::paused ||
           pane.view.state() == LiveView::State::stopped;
  };
  const bool was_held = is_held();
  note_asked(pane);
  pane.view.refresh();
  // Where nothing is left to trace, no pass will tell so.
  if (was_held && !is_held()) tell(id, pane, name_of(pane.view.state()), Json::object());
}

void LiveViews::note_asked(Pane& pane) {
  const ReadScene& scene = scenes_[key_of(pane)];
  const bool is_read = scene.last && scene.last->revision >= scene.asked;
  if (!is_read) pane.asked_for = scene.asked;
}

void LiveViews::leave(ClientId client) {
  for (const auto& [id, pane] : panes_) {
    if (id.client != client) continue;
    if (pane.view.running()) orders_.push_back(EndPass{pane.view.running()->serial});
    orders_.push_back(ForgetView{id});
  }
  std::erase_if(panes_, [client](const auto& pane) { return pane.first.client == client; });
  drop_unused_scenes();
}

void LiveViews::note_saved() {
  for (auto& [id, pane] : panes_) {
    if (mode_of(pane.wish.mode) != LiveView::Mode::on_save) continue;
    note_asked(pane);
    pane.view.note_saved();
  }
}

LiveViews::Pane* LiveViews::pane_of(uint32_t serial, ViewId& id) {
  for (auto& [each, pane] : panes_) {
    if (!pane.view.running() || pane.view.running()->serial != serial) continue;
    id = each;
    return &pane;
  }
  return nullptr;
}

void LiveViews::take(const PassEnd& end) {
  ViewId id;
  Pane* const pane = pane_of(end.serial, id);
  if (!pane) return;
  const LiveView::Start pass = *pane->view.running();
  if (end.how == PassEnd::How::done) {
    pane->view.pass_done(end.serial, end.overhead, end.trace);
    tell(id, *pane, pass.is_last ? "done" : "tracing",
         {{"serial", end.serial},
          {"scale", pass.pass.scale},
          {"samples", pass.pass.samples},
          {"ended", true},
          {"rays", end.rays},
          {"digest", pane->shown->scene->digest},
          {"times",
           {{"parse", pane->shown->seconds}, {"build", end.overhead}, {"trace", end.trace}}}});
  } else if (end.how == PassEnd::How::failed) {
    pane->view.pass_failed(end.serial);
    // Which line of which text is wrong is for the reader to find.
    if (end.why && end.why->code() == ExitCode::bad_scene) {
      ReadScene& scene = scenes_[key_of(*pane)];
      scene.failure = end.why->what();
      scene.failed_digest = pane->shown->scene->digest;
      read(key_of(*pane));
    }
    pane->why_failed = end.why ? end.why->what() : "it failed";
    tell(id, *pane, "failed", {{"serial", end.serial}});
  }
}

void LiveViews::take(uint32_t serial, const JobProgress& progress) {
  ViewId id;
  Pane* const pane = pane_of(serial, id);
  if (!pane) return;
  Json fields{{"pane", id.pane},
              {"serial", serial},
              {"tiles_done", progress.tiles_done},
              {"tiles_total", progress.tiles_total},
              {"waiting_for", progress.waiting_for},
              {"elapsed", progress.elapsed_seconds}};
  if (progress.remaining_seconds >= 0) fields["left"] = progress.remaining_seconds;
  orders_.push_back(page_answer(id.client, "progress", std::move(fields)));
}

void LiveViews::take(const PassTiles& tiles) {
  ViewId id;
  const Pane* const pane = pane_of(tiles.serial, id);
  if (pane && pane->wish.tiles)
    orders_.push_back(
        page_answer(id.client, "tiles", tiles_json(id, tiles, pane->view.running()->pass.scale)));
}

void LiveViews::take(const OutputRefused& refused) {
  const auto at = panes_.find(refused.view);
  if (at == panes_.end() || at->second.output != refused.output) return;
  at->second.output_fault = refused.why;
  tell(refused.view, at->second, name_of(at->second.view.state()), {});
}

std::optional<LiveViews::Seen> LiveViews::seen(const ViewId& id) const {
  const auto at = panes_.find(id);
  if (at == panes_.end() || !at->second.shown || !at->second.options) return std::nullopt;
  const Pane& pane = at->second;
  return Seen{pane.shown, pane.options, pane.wish.free_camera, pane.wish.width, pane.wish.height};
}

void LiveViews::tell(const ViewId& id, Pane& pane, std::string_view state, Json more) {
  if (more.is_null()) more = Json::object();
  if (!pane.output_fault.empty()) state = "failed";
  more.update({{"pane", id.pane},
               {"file", pane.wish.file},
               {"state", state},
               {"width", pane.wish.width},
               {"height", pane.wish.height}});
  if (state == "failed")
    more["why"] = pane.output_fault.empty() ? pane.why_failed : pane.output_fault;
  if (pane.shown)
    more.update({{"version", pane.shown->version}, {"revision", pane.shown->revision}});
  if (!pane.stale.is_null()) more["stale"] = pane.stale;
  SendText message = page_answer(id.client, "job", std::move(more));
  if (message.text == pane.told) return;
  pane.told = message.text;
  orders_.push_back(std::move(message));
}

void LiveViews::carry_out(const ViewId& id, Pane& pane, Time now) {
  const LiveView::Orders orders = pane.view.orders(now);
  if (orders.interrupt) orders_.push_back(EndPass{*orders.interrupt});
  if (orders.start) {
    const LiveView::Start& start = *orders.start;
    pane.shown = scenes_[key_of(pane)].good;
    orders_.push_back(TracePass{.view = id,
                                .order = {.serial = start.serial,
                                          .reading = pane.shown,
                                          .options = pane.options,
                                          .camera = pane.wish.free_camera,
                                          .pass = start.pass,
                                          .priority = priority_of_pane(id.pane)},
                                .picture = {.serial = start.serial,
                                            .pass = start.pass,
                                            .is_last = start.is_last,
                                            .shows_cost = pane.shows_cost,
                                            .version = static_cast<uint32_t>(pane.shown->version),
                                            .deflate = deflate_,
                                            .scene = pane.shown->scene->digest,
                                            .width = pane.wish.width,
                                            .height = pane.wish.height}});
    tell(id, pane, "tracing",
         {{"serial", start.serial},
          {"scale", start.pass.scale},
          {"samples", start.pass.samples},
          {"last", start.is_last}});
  }
}

std::shared_ptr<const SceneReading> LiveViews::reading_of(ClientId client,
                                                          const std::string& file) const {
  for (const auto& [id, pane] : panes_) {
    if (id.client != client || pane.wish.file != file || pane.wish.is_sample) continue;
    const auto scene = scenes_.find(key_of(pane));
    if (scene != scenes_.end() && scene->second.good) return scene->second.good;
  }
  return nullptr;
}

void LiveViews::tick(Time now) {
  for (const std::string& line : log_.due(now)) spdlog::info(line);
  deadline_ = log_.deadline();
  for (auto& [id, pane] : panes_) {
    carry_out(id, pane, now);
    deadline_ = std::min(deadline_, pane.view.deadline());
  }
}

}  // namespace tessera
