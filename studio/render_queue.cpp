#include "studio/render_queue.h"

#include <fmt/format.h>
#include <spdlog/spdlog.h>

#include <algorithm>
#include <nlohmann/json.hpp>
#include <set>
#include <utility>

#include "base/error.h"
#include "front/output_settings.h"
#include "front/picture.h"
#include "front/render_frame.h"
#include "studio/files/file_kind.h"
#include "studio/files/file_name.h"
#include "studio/page_answer.h"

namespace tessera {
namespace {

using Json = nlohmann::json;

/// Why a picture cannot have that name; empty: it can.
std::string fault_of_picture_name(const std::string& name) {
  if (std::string fault = fault_of_name(name); !fault.empty()) return fault;
  if (file_kind_of(name) == FileKind::picture) return {};
  return "no format of pictures; expected an ending such as .png or .exr";
}

}  // namespace

std::string RenderQueue::fault_of(const page::Render& wish) const {
  if (jobs_.size() - count_over() >= kMostJobs)
    return fmt::format("the queue is full; expected at most {} pictures", kMostJobs);
  if (std::string fault = fault_of_name(wish.file); !fault.empty()) return fault;
  std::set<std::string> names;
  for (const std::string& name : wish.outputs) {
    if (!names.insert(name).second) return "'" + name + "' is to be written twice; expected once";
    if (const std::string fault = fault_of_picture_name(name); !fault.empty())
      return "'" + name + "': " + fault;
  }
  return {};
}

bool RenderQueue::accepts(ClientId client, const page::Render& wish) {
  const std::string fault = fault_of(wish);
  if (!fault.empty()) orders_.push_back(refusal(client, "render", wish.file, fault, wish.number));
  return fault.empty();
}

size_t RenderQueue::count_over() const {
  return static_cast<size_t>(
      std::ranges::count_if(jobs_, [](const auto& each) { return each.second.is_over(); }));
}

void RenderQueue::add(ClientId client, const page::Render& wish, const OpenTexts& texts) {
  if (!accepts(client, wish)) return;
  Job job{.number = last_job_ + 1, .wish = wish, .texts = texts, .options = {}};
  try {
    job.options =
        std::make_shared<const RenderOptions>(full_options(wish, folder_ + "/" + wish.file));
  } catch (const Error& error) {
    orders_.push_back(refusal(client, "render", wish.file, error.what(), wish.number));
    return;
  }
  if (wish.number != 0)
    orders_.push_back(
        page_answer(client, "ordered", {{"number", wish.number}, {"job", job.number}}));
  if (wish.frames) job.animations = std::make_shared<AnimationFiles>();
  jobs_.emplace(++last_job_, std::move(job));
  is_changed_ = true;
}

void RenderQueue::order(ClientId client, const page::RenderOrder& order) {
  using What = page::RenderOrder::What;
  const auto at = jobs_.find(order.job);
  if (at == jobs_.end()) {
    orders_.push_back(refusal(client, "order", "", "there is no such picture in the queue"));
    return;
  }
  Job& job = at->second;
  is_changed_ = true;
  switch (order.what) {
    case What::pause:
      return pause(at->first, job);
    case What::resume:
      job.is_paused = false;
      return;
    case What::cancel:
      return cancel(at->first, job);
    case What::forget:
      if (job.is_over() && active_ != at->first) jobs_.erase(at);
      return;
  }
}

void RenderQueue::pause(uint64_t number, Job& job) {
  if (job.is_over()) return;
  job.is_paused = true;
  if (job.state != State::tracing) return;
  orders_.push_back(EndFrame{number, true});
  job.state = State::queued;
  active_ = 0;
}

void RenderQueue::cancel(uint64_t number, Job& job) {
  if (job.is_over()) return;
  // What was kept while it was paused goes too.
  orders_.push_back(EndFrame{number, false});
  if (job.state == State::queued || job.state == State::tracing) return end(job, State::cancelled);
  // Another thread works for it, whose answer is waited for.
  job.is_cancelled = true;
}

void RenderQueue::end(Job& job, State state, std::string why) {
  job.state = state;
  job.why = std::move(why);
  job.texts.clear();
  job.animations.reset();
  job.frame.reading.reset();
  is_changed_ = true;
  if (active_ == job.number) active_ = 0;
  const std::string name = fmt::format("full picture {} of '{}'", job.number, job.wish.file);
  if (state == State::failed) {
    spdlog::warn("{}: {}", name, job.why);
  } else {
    const size_t others = job.written_count - job.written.size();
    spdlog::info("{}: {}, {:.1f} s{}{}{}", name, name_of(job), job.seconds,
                 job.written.empty() ? "" : ", written to ", fmt::join(job.written, ", "),
                 others == 0 ? "" : fmt::format(" and {} before", others));
  }
}

RenderQueue::Job* RenderQueue::active(State state, uint64_t job) {
  const auto at = jobs_.find(job);
  return job == active_ && at != jobs_.end() && at->second.state == state ? &at->second : nullptr;
}

void RenderQueue::take(std::shared_ptr<const SceneReading> reading) {
  Job* const job = active(State::reading, reading->job);
  if (!job) return;
  is_changed_ = true;
  if (job->is_cancelled) return end(*job, State::cancelled);
  if (!reading->scene) {
    std::string why = "the scene cannot be read";
    for (const Problem& problem : reading->problems) {
      if (!problem.is_error) continue;
      why = problem.message;
      if (problem.line > 0)
        why = fmt::format("{}:{}:{}: {}", problem.file, problem.line, problem.column, why);
      break;
    }
    return end(*job, State::failed, std::move(why));
  }
  const std::optional<int> number =
      job->wish.frames ? job->next_number() : frame_number(*reading->scene, job->wish.frame);
  // Of an animation once, not once a frame.
  if (!job->wish.frames || number == job->wish.frames->first)
    spdlog::info("full picture {} of '{}': read in {:.3f} s", job->number, job->wish.file,
                 reading->scene->load_seconds);
  job->frame = {std::move(reading), job->options, job->wish.free_camera, number};
  if (job->is_paused) {
    job->state = State::queued;
    active_ = 0;
  } else {
    job->state = State::tracing;
    orders_.push_back(TraceFrame{active_, job->frame});
  }
}

void RenderQueue::take(uint64_t number, const JobProgress& progress) {
  Job* const job = active(State::tracing, number);
  if (!job) return;
  job->progress = progress;
  is_progressed_ = true;
}

void RenderQueue::take(const FrameEnd& frame_end) {
  Job* const job = active(State::tracing, frame_end.job);
  if (!job) return;
  job->seconds += frame_end.seconds;
  if (!frame_end.result) return end(*job, State::failed, frame_end.failure);
  job->state = State::finishing;
  is_changed_ = true;
  FileGoal goal{
      .names = job->wish.outputs, .statistics = job->wish.statistics, .force = job->wish.force};
  if (job->wish.frames) {
    goal.number = job->next_number();
    goal.animations = job->animations;
    goal.is_first_frame = job->next == 0;
    goal.is_last_frame = job->next + 1 == job->frames();
  }
  orders_.push_back(FinishFrame{.job = frame_end.job,
                                .frame = job->frame,
                                .result = frame_end.result,
                                .seconds = frame_end.seconds,
                                .goal = std::move(goal)});
}

void RenderQueue::take(const FrameFinished& finished) {
  Job* const job = active(State::finishing, finished.job);
  if (!job) return;
  job->picture = finished.picture;
  job->written.insert(job->written.end(), finished.written.begin(), finished.written.end());
  job->written_count += finished.written.size();
  while (job->written.size() > kMostNamed) job->written.pop_front();
  drop_old_pictures();
  if (!finished.failure.empty()) return end(*job, State::failed, finished.failure);
  ++job->next;
  if (job->next == job->frames()) return end(*job, State::done);
  if (job->is_cancelled) return end(*job, State::cancelled);
  job->frame.reading.reset();
  job->progress = {};
  job->state = State::queued;
  is_changed_ = true;
  active_ = 0;
}

void RenderQueue::drop_old_pictures() {
  uint64_t bytes = 0;
  for (auto job = jobs_.rbegin(); job != jobs_.rend(); ++job) {
    auto& picture = job->second.picture;
    if (!picture) continue;
    bytes += film_bytes(picture->film.rect(), picture->film.aovs());
    if (bytes > kKeptBytes && job->first != active_) picture.reset();
  }
}

void RenderQueue::begin_next() {
  if (active_ != 0) return;
  const auto at = std::find_if(jobs_.begin(), jobs_.end(), [](const auto& entry) {
    return entry.second.state == State::queued && !entry.second.is_paused;
  });
  if (at == jobs_.end()) return;
  auto& [number, job] = *at;
  active_ = number;
  is_changed_ = true;
  if (job.frame.reading) {
    job.state = State::tracing;
    orders_.push_back(TraceFrame{number, job.frame});
    return;
  }
  job.state = State::reading;
  orders_.push_back(ReadOrder{.file = job.wish.file,
                              .frame = job.next_number().value_or(0),
                              .revision = 0,
                              .texts = job.texts,
                              .job = number,
                              .options = job.options});
}

bool RenderQueue::tick(Time now) {
  for (size_t over = count_over(); over > kMostOver; --over) {
    jobs_.erase(
        std::ranges::find_if(jobs_, [](const auto& each) { return each.second.is_over(); }));
  }
  begin_next();
  deadline_ = Time::max();
  if (!is_changed_ && is_progressed_ && now < next_list_) {
    deadline_ = next_list_;
    return false;
  }
  if (!is_changed_ && !is_progressed_) return false;
  is_changed_ = is_progressed_ = false;
  next_list_ = now + kBetweenLists;
  return true;
}

std::string_view RenderQueue::name_of(const Job& job) {
  if (job.is_paused && !job.is_over()) return "paused";
  switch (job.state) {
    case State::queued:
      return "queued";
    case State::reading:
      return "reading";
    case State::tracing:
      return "tracing";
    case State::finishing:
      return "writing";
    case State::done:
      return "done";
    case State::failed:
      return "failed";
    case State::cancelled:
      break;
  }
  return "cancelled";
}

Json RenderQueue::json_of(uint64_t number, const Job& job) const {
  Json json{{"job", number},
            {"file", job.wish.file},
            {"state", name_of(job)},
            {"written", job.written},
            {"written_count", job.written_count},
            {"has_picture", job.picture != nullptr},
            {"elapsed", job.seconds}};
  if (job.wish.frames) {
    json["frames"] = {job.wish.frames->first, job.wish.frames->last};
    json["frames_done"] = job.next;
  }
  if (job.frame.reading || job.is_over()) {
    json["tiles_done"] = job.progress.tiles_done;
    json["tiles_total"] = job.progress.tiles_total;
  }
  if (job.state == State::tracing) {
    json["elapsed"] = job.seconds + job.progress.elapsed_seconds;
    if (job.progress.remaining_seconds >= 0) json["left"] = job.progress.remaining_seconds;
    if (!job.progress.waiting_for.empty()) json["waiting_for"] = job.progress.waiting_for;
  }
  if (job.picture) {
    json["size"] = {job.picture->film.width(), job.picture->film.height()};
    json["samples"] = job.picture->metadata.samples_per_pixel;
    json["digest"] = job.picture->metadata.scene_digest;
  }
  if (!job.why.empty()) json["why"] = job.why;
  if (std::string command = command_line(job.wish, folder_, assets_); !command.empty())
    json["command"] = std::move(command);
  return json;
}

Json RenderQueue::list() const {
  Json list = Json::array();
  for (const auto& [number, job] : jobs_) list.push_back(json_of(number, job));
  return {{"list", std::move(list)}};
}

std::optional<ExportFile> RenderQueue::unfinished_picture(uint64_t number) const {
  const auto at = jobs_.find(number);
  if (at == jobs_.end() || at->second.state != State::tracing) return std::nullopt;
  const Job& job = at->second;
  const v1::Output& of_scene = job.frame.reading->scene->loaded.scene.settings().output();
  return ExportFile{.frame = job.frame,
                    .output = output_settings(job.options->scene, of_scene, job.options->output)};
}

std::optional<ExportFile> RenderQueue::picture(uint64_t number) const {
  const auto at = jobs_.find(number);
  if (at == jobs_.end() || !at->second.picture) return std::nullopt;
  const Job& job = at->second;
  return ExportFile{.frame = job.frame,
                    .picture = job.picture,
                    .output = shown_settings(job.options->scene, *job.picture, job.options->output),
                    .goal = {}};
}

}  // namespace tessera
