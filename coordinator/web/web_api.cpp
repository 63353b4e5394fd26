#include "coordinator/web/web_api.h"

#include <fmt/format.h>

#include <algorithm>
#include <charconv>
#include <limits>
#include <nlohmann/json.hpp>
#include <utility>

#include "base/monotonic.h"
#include "base/process_usage.h"
#include "coordinator/coordinator.h"
#include "coordinator/jobs/preview.h"
#include "coordinator/web/chrome_trace.h"
#include "coordinator/web/farm_json.h"
#include "coordinator/web/farm_page_files.h"
#include "coordinator/web/png_file.h"
#include "job/job.h"
#include "renderer/film/film.h"

namespace tessera {
namespace {

constexpr Time kSilent = std::chrono::seconds(10);
constexpr size_t kMostMade = 64;
constexpr char kApi[] = "/api/v1/";

HttpResponse plain(int status, std::string text) {
  return {status,
          "text/plain; charset=utf-8",
          std::make_shared<const std::string>(std::move(text)),
          {}};
}

HttpResponse json(std::shared_ptr<const std::string> body) {
  return {200, "application/json", std::move(body), {}};
}

/// Whether it is of a frame that is being traced, and no tile of it is done.
bool has_nothing_yet(const std::vector<TileSnapshot>& tiles) {
  return !tiles.empty() && std::none_of(tiles.begin(), tiles.end(), [](const auto& tile) {
    return tile.state == TileSnapshot::State::done;
  });
}

HttpResponse file(const char* type, std::string bytes) {
  return {200,
          type,
          std::make_shared<const std::string>(std::move(bytes)),
          {{"Cache-Control", "no-store"}}};
}

/// What is known already.
void tell(const HttpReply& reply, HttpResponse response) {
  reply([response = std::move(response)] { return response; });
}

template <typename Number>
std::optional<Number> whole(std::string_view text) {
  Number value{};
  const auto [end, error] = std::from_chars(text.data(), text.data() + text.size(), value);
  if (error != std::errc() || end != text.data() + text.size()) return std::nullopt;
  return value;
}

const FarmSnapshot::Job* find_job(const FarmSnapshot& snapshot, uint64_t id) {
  const auto it =
      std::lower_bound(snapshot.jobs.begin(), snapshot.jobs.end(), id,
                       [](const auto& job, uint64_t wanted) { return job.id < wanted; });
  return it != snapshot.jobs.end() && it->id == id ? &*it : nullptr;
}

/// Of the job, what there is to see: the frame that is being traced, else the last one begun.
uint32_t frame_to_show(const FarmSnapshot::Job& job) {
  if (!job.frames_running.empty()) return job.frames_running.front();
  return job.frames_done > 0 ? job.frames_done - 1 : 0;
}

const char* name_of(v1::JobStatus::State state) {
  switch (state) {
    case v1::JobStatus::PAUSED:
      return "paused";
    case v1::JobStatus::RUNNING:
      return "running";
    case v1::JobStatus::HELD:
      return "held";
    case v1::JobStatus::ENDED:
      return "ended";
    default:
      return "queued";
  }
}

/// What became of an order: 409 where the job had ended before, 503 where it could not be kept.
HttpResponse answer_order(const v1::JobQuery& query, const v1::JobStatus& status) {
  if (status.state() == v1::JobStatus::UNKNOWN) return http_error(404, "there is no such job");
  const bool ended = status.state() == v1::JobStatus::ENDED;
  const bool cancelled = ended && status.how() == v1::JobEnd::INTERRUPTED;
  const bool wanted = query.action() == v1::JobQuery::CANCEL ? cancelled : !ended;
  if (ended && !wanted) return http_error(409, fmt::format("job {} has ended", status.job()));
  const bool done =
      query.action() == v1::JobQuery::CANCEL   ? cancelled
      : query.action() == v1::JobQuery::PAUSE  ? status.state() == v1::JobStatus::PAUSED
      : query.action() == v1::JobQuery::RESUME ? status.state() != v1::JobStatus::PAUSED
                                               : status.priority() == query.priority();
  if (!done) return http_error(503, status.failure());
  const nlohmann::ordered_json body{{"job", status.job()},
                                    {"state", cancelled ? "cancelled" : name_of(status.state())},
                                    {"priority", status.priority()}};
  return json(std::make_shared<const std::string>(body.dump() + "\n"));
}

/// Nothing where it is no order, or has no number that it needs.
std::optional<v1::JobQuery> query_of(uint64_t job, const std::string& what,
                                     const std::string& body) {
  v1::JobQuery query;
  query.set_job(job);
  if (what == "priority") {
    const auto json = nlohmann::json::parse(body, nullptr, false);
    if (!json.is_object() || !json.contains("priority")) return std::nullopt;
    const auto& number = json["priority"];
    if (!number.is_number_integer()) return std::nullopt;
    // From 2^63 on it would wrap around as a signed one.
    if (number.is_number_unsigned() && number.get<uint64_t>() > kMostPriority) return std::nullopt;
    const auto priority = number.get<int64_t>();
    if (priority < -kMostPriority || priority > kMostPriority) return std::nullopt;
    query.set_priority(static_cast<int32_t>(priority));
    return query;
  }
  query.set_action(what == "cancel"  ? v1::JobQuery::CANCEL
                   : what == "pause" ? v1::JobQuery::PAUSE
                                     : v1::JobQuery::RESUME);
  return query;
}

bool is_order(const std::string& what) {
  return what == "cancel" || what == "pause" || what == "resume" || what == "priority";
}

}  // namespace

template <typename Make>
WebApi::Body WebApi::shared(const std::string& name, std::shared_ptr<const void> of, Make make) {
  const auto it = made_.find(name);
  if (it != made_.end() && it->second.of == of) return it->second.body;
  if (made_.size() >= kMostMade) made_.clear();
  auto body = std::make_shared<const std::string>(make());
  made_[name] = {std::move(of), body};
  return body;
}

void WebApi::set_access(WebAccess access) {
  const std::lock_guard lock(access_mutex_);
  parts_.access = std::move(access);
}

void WebApi::handle(const HttpRequest& request, const HttpReply& reply) {
  ++counts_.requests;
  const bool reads = request.method == "GET" || request.method == "HEAD";
  if (!reads && request.method != "POST")
    return tell(reply, http_error(405, "expected GET or POST"));
  // What holds no secret, and what asks whether we live, needs no token.
  if (reads) {
    if (request.path == "/healthz") return tell(reply, health());
    if (request.path == "/readyz") return tell(reply, readiness());
    if (const auto file = find_farm_page_file(request.path)) return tell(reply, response_of(*file));
  }
  const auto needed = reads ? WebAccess::Role::viewer : WebAccess::Role::submitter;
  std::unique_lock lock(access_mutex_);
  auto refused = parts_.access.refuse(request, needed);
  lock.unlock();
  if (refused) return tell(reply, std::move(*refused));
  if (!parts_.monitor->farm()) return tell(reply, http_error(503, "the coordinator is starting"));
  if (reads && request.path == "/metrics") return tell(reply, metrics());
  if (request.path.starts_with(kApi)) return handle_api(request, reply);
  tell(reply, http_error(404, "there is no such page"));
}

HttpResponse WebApi::health() const {
  const Time silent = monotonic_now() - parts_.monitor->last_look();
  if (parts_.monitor->farm() && silent > kSilent) {
    return plain(503, fmt::format("the coordinator is silent for {:.0f} s\n", to_seconds(silent)));
  }
  return plain(200, "ok\n");
}

HttpResponse WebApi::readiness() const {
  if (!parts_.monitor->farm()) return plain(503, "starting\n");
  if (parts_.stopping && *parts_.stopping) return plain(503, "ending\n");
  return health();
}

HttpResponse WebApi::metrics() const {
  return {200,
          "text/plain; version=0.0.4; charset=utf-8",
          std::make_shared<const std::string>(metrics_text(
              parts_.monitor->farm()->snapshot, parts_.monitor->work(), counts_, process_usage())),
          {}};
}

void WebApi::handle_api(const HttpRequest& request, const HttpReply& reply) {
  const std::string rest = request.path.substr(sizeof kApi - 1);
  if (rest.starts_with("jobs/")) return handle_job(request, rest.substr(5), reply);
  if (request.method == "POST") return tell(reply, http_error(405, "expected GET"));
  const auto farm = parts_.monitor->farm();
  const FarmSnapshot& snapshot = farm->snapshot;
  if (rest == "farm") {
    return tell(reply, json(shared(rest, farm, [&] { return farm_json(snapshot); })));
  }
  if (rest == "jobs") {
    return tell(reply, json(shared(rest, farm, [&] { return jobs_json(snapshot); })));
  }
  if (rest == "workers") {
    return tell(reply, json(shared(rest, farm, [&] { return workers_json(snapshot); })));
  }
  if (rest == "history") {
    return tell(reply,
                json(shared(rest, farm->history, [&] { return history_json(*farm->history); })));
  }
  if (rest == "news") return tell_news(request, reply);
  if (rest == "log") return tell(reply, log(request));
  tell(reply, http_error(404, "there is no such thing; docs/operating.md lists what there is"));
}

void WebApi::tell_news(const HttpRequest& request, const HttpReply& reply) {
  const auto after = request.query.find("after");
  // There is never so much: who knows nothing is answered at once.
  const auto known =
      after == request.query.end() ? std::optional(UINT64_MAX) : whole<uint64_t>(after->second);
  if (!known) return tell(reply, http_error(400, "after: expected a whole number"));
  const bool asked = parts_.monitor->ask_news(*known, [reply](uint64_t news) {
    reply([news] {
      return json(std::make_shared<const std::string>(fmt::format("{{\"news\":{}}}\n", news)));
    });
  });
  if (!asked) tell(reply, http_error(503, "too many ask"));
}

HttpResponse WebApi::log(const HttpRequest& request) const {
  const auto after = request.query.find("after");
  const auto number =
      after == request.query.end() ? std::optional<uint64_t>(0) : whole<uint64_t>(after->second);
  if (!number) return http_error(400, "after: expected a whole number");
  nlohmann::ordered_json lines = nlohmann::ordered_json::array();
  if (parts_.log) {
    for (const LogRing::Line& line : parts_.log->after(*number)) {
      lines.push_back({{"number", line.number},
                       {"milliseconds", line.milliseconds},
                       {"level", line.level},
                       {"text", line.text}});
    }
  }
  const nlohmann::ordered_json body{{"lines", std::move(lines)}};
  return json(std::make_shared<const std::string>(
      body.dump(-1, ' ', false, nlohmann::ordered_json::error_handler_t::replace) + "\n"));
}

void WebApi::handle_job(const HttpRequest& request, const std::string& rest,
                        const HttpReply& reply) {
  const size_t slash = rest.find('/');
  const auto id = whole<uint64_t>(rest.substr(0, slash));
  const std::string what = slash == std::string::npos ? "" : rest.substr(slash + 1);
  const bool known = what.empty() || what == "tiles" || what == "preview.png" ||
                     what == "trace.json" || what == "picture.png" || what == "scene.tessera" ||
                     what == "scene.tesserab" || is_order(what);
  if (!id || !known) return tell(reply, http_error(404, "there is no such thing of a job"));
  if (is_order(what) != (request.method == "POST")) {
    return tell(reply, http_error(405, is_order(what) ? "expected POST" : "expected GET"));
  }
  // What was submitted this moment is in no snapshot yet, but takes orders.
  if (is_order(what)) return order(*id, what, request, reply);
  const auto farm = parts_.monitor->farm();
  const FarmSnapshot::Job* const job = find_job(farm->snapshot, *id);
  if (!job) return tell(reply, http_error(404, "there is no such job"));
  if (what.empty()) return tell(reply, json(std::make_shared<const std::string>(job_json(*job))));
  uint32_t frame = frame_to_show(*job);
  if (const auto asked = request.query.find("frame"); asked != request.query.end()) {
    const auto number = whole<uint32_t>(asked->second);
    if (!number || *number >= job->frames_total) {
      return tell(reply, http_error(400, fmt::format("frame: expected a number from 0 to {}",
                                                     job->frames_total - 1)));
    }
    frame = *number;
  }
  if (what == "trace.json") return show_trace(*id, frame, reply);
  if (what == "picture.png") return show_picture(*id, frame, reply);
  if (const auto form = scene_encoding_of(what)) return show_scene(*id, frame, *form, reply);
  show_frame(*id, frame, what, request, reply);
}

void WebApi::show_frame(uint64_t job, uint32_t frame, const std::string& what,
                        const HttpRequest& request, const HttpReply& reply) {
  const bool picture = what == "preview.png";
  const bool asked =
      parts_.monitor->watch(job, frame,
                            [this, job, frame, picture, known = request.header("if-none-match"),
                             reply](const std::shared_ptr<const FrameShown>& shown) {
                              reply([this, job, frame, picture, known, shown] {
                                if (picture) return preview(job, frame, *shown, known);
                                return json(shared(fmt::format("tiles {} {}", job, frame), shown,
                                                   [&] { return tiles_json(job, frame, *shown); }));
                              });
                            });
  if (!asked) reply([] { return http_error(503, "too many ask"); });
}

HttpResponse WebApi::preview(uint64_t job, uint32_t frame, const FrameShown& shown,
                             const std::string& known) {
  if (!shown.preview) return {204, "", nullptr, {}};
  // Of a frame, a picture of more tiles is another; one of no frame is never made anew.
  const std::string tag = fmt::format("\"{}-{}-{}-{}\"", job, frame, shown.preview->tiles_done,
                                      shown.tiles.empty() ? "end" : "live");
  if (known == tag) return {304, "", nullptr, {{"ETag", tag}}};
  HttpResponse response{200, "image/png", nullptr, {{"ETag", tag}, {"Cache-Control", "no-cache"}}};
  response.body = shared(fmt::format("preview {} {}", job, frame), shown.preview, [&] {
    ++counts_.previews_encoded;
    return png_file(*shown.preview);
  });
  return response;
}

void WebApi::show_trace(uint64_t job, uint32_t frame, const HttpReply& reply) {
  const auto question = [job, frame, reply](Coordinator& coordinator, Time) {
    reply([job, number = coordinator.number_of(job, frame), trace = coordinator.trace(job, frame)] {
      if (!trace) return http_error(404, "of that frame there is no timeline, or no more");
      return json(std::make_shared<const std::string>(
          chrome_trace(*trace, fmt::format("job {} frame {}", job, number))));
    });
  };
  ask(question, reply);
}

void WebApi::show_picture(uint64_t job, uint32_t frame, const HttpReply& reply) {
  const auto question = [job, frame, reply](Coordinator& coordinator, Time now) {
    const auto view = coordinator.film(job, frame);
    if (!view || has_nothing_yet(coordinator.tiles(job, frame, now)))
      return reply([] { return http_error(404, "of that frame there is no picture"); });
    v1::JobQuery query;
    query.set_job(job);
    query.set_frame(frame);
    auto film = std::make_shared<const Film>(light_of(*view));
    reply([film, output = coordinator.ask(query, now).frame().output()] {
      return file("image/png", png_file(make_preview(*film, output, 0, kMaxFrameSide)));
    });
  };
  ask(question, reply);
}

void WebApi::show_scene(uint64_t job, uint32_t frame, SceneEncoding form, const HttpReply& reply) {
  const auto question = [job, frame, form, reply](Coordinator& coordinator, Time) {
    try {
      auto scene = coordinator.scene(job, frame);
      if (!scene) return reply([] { return http_error(404, "there is no such frame"); });
      uint64_t bytes = 0;
      for (const auto& [digest, blob] : scene->second.all()) bytes += blob->size();
      if (bytes > kMaxEmbeddedBlobBytes) {
        return reply([bytes] {
          return http_error(413, fmt::format("the scene has {} MB of meshes and textures; expected "
                                             "at most {}, which one file holds",
                                             bytes >> 20, kMaxEmbeddedBlobBytes >> 20));
        });
      }
      reply([form, scene = std::move(*scene)] {
        const auto& [packed, blobs] = scene;
        const auto read =
            parse_scene({reinterpret_cast<const char*>(packed->data()), packed->size()});
        if (!read) return http_error(503, "the stored bytes are no scene");
        return file("application/octet-stream", encode_scene(*read, blobs, form));
      });
    } catch (const std::exception& error) {
      reply([why = std::string(error.what())] { return http_error(503, why); });
    }
  };
  ask(question, reply);
}

void WebApi::ask(FarmMonitor::Question question, const HttpReply& reply) {
  if (!parts_.monitor->ask(std::move(question)))
    reply([] { return http_error(503, "too many ask"); });
}

void WebApi::order(uint64_t job, const std::string& what, const HttpRequest& request,
                   const HttpReply& reply) {
  auto query = query_of(job, what, request.body);
  if (!query) {
    return reply([] {
      return http_error(400, "expected {\"priority\": a whole number from -1000 to 1000}");
    });
  }
  std::unique_lock lock(access_mutex_);
  const std::string name = parts_.access.name_of(request);
  lock.unlock();
  query->set_by(name.empty() ? "whoever uses the page" : name);
  const bool asked =
      parts_.monitor->order(*query, [query = *query, reply](const v1::JobStatus& status) {
        reply([query, status] { return answer_order(query, status); });
      });
  if (!asked) reply([] { return http_error(503, "too many ask"); });
}

}  // namespace tessera
