#include "studio/farm_frames.h"

#include <fmt/format.h>

#include <filesystem>
#include <nlohmann/json.hpp>
#include <utility>

#include "base/file.h"
#include "client/refusal.h"
#include "front/output_settings.h"

namespace tessera {
namespace {

using Json = nlohmann::json;

SubmittedJob submission_of(const FullFrame& frame) {
  const JobSpec spec = job_of(frame);
  SubmittedJob job;
  job.request.set_submission(draw_submission());
  job.request.set_detached(true);
  job.request.set_weight(1);
  std::string name = std::filesystem::path(frame.options->scene).stem().string();
  if (frame.number) name += fmt::format(" {}", *frame.number);
  job.request.set_name(to_utf8(name));
  add_frame(
      job, spec, frame.number.value_or(0),
      with_options(frame.reading->scene->loaded.scene.settings().output(), frame.options->output));
  return job;
}

/// What the status of a job tells of it, as far as a page shows that.
JobProgress progress_in(const Json& status) {
  JobProgress progress;
  progress.tiles_done = status.at("tiles").at("done");
  progress.tiles_total = status.at("tiles").at("total");
  progress.elapsed_seconds = status.at("elapsed_seconds");
  progress.remaining_seconds =
      status.at("remaining_seconds").is_null() ? -1 : status.at("remaining_seconds").get<double>();
  const std::string state = status.at("state");
  if (!status.at("waits_for").is_null()) {
    progress.waiting_for = status.at("waits_for");
  } else if (state != "running") {
    progress.waiting_for = fmt::format("the farm, where it is {}", state);
  }
  return progress;
}

bool has_ended(const Json& status) {
  const std::string state = status.at("state");
  return state == "done" || state == "failed" || state == "cancelled";
}

}  // namespace

FarmFrames::FarmFrames(const FarmConnection& connection, Events events)
    : events_(std::move(events)), farm_(connection), thread_([this] { run(); }) {}

FarmFrames::~FarmFrames() {
  is_ending_ = true;
  changed_.notify_one();
  thread_.join();
}

void FarmFrames::add(Request request) {
  {
    const std::lock_guard lock(mutex_);
    requests_.push_back(std::move(request));
  }
  changed_.notify_one();
}

void FarmFrames::start(const TraceFrame& order) {
  add([this, order] {
    auto [at, is_new] = tasks_.try_emplace(order.job);
    if (is_new) at->second.frame = order.frame;
    at->second.shall_pause = false;
  });
}

void FarmFrames::end(const EndFrame& order) {
  add([this, order] {
    const auto at = tasks_.find(order.job);
    if (at == tasks_.end()) return;
    (order.keeps_tiles ? at->second.shall_pause : at->second.is_dropped) = true;
  });
}

void FarmFrames::ask_picture(uint64_t job, std::function<void(Picture)> take) {
  add([this, job, take = std::move(take)] { show(job, take); });
}

void FarmFrames::run() {
  while (!is_ending_) {
    std::vector<Request> requests;
    {
      std::unique_lock lock(mutex_);
      changed_.wait_for(lock, kBetweenLooks, [this] { return is_ending_ || !requests_.empty(); });
      requests.swap(requests_);
    }
    if (is_ending_) return;
    for (const Request& request : requests) request();
    News news{.jobs = told_.jobs};
    try {
      look();
      if (Clock::now() >= next_list_) {
        next_list_ = Clock::now() + kBetweenLists;
        news.jobs = farm_.list(is_ending_);
      }
    } catch (const std::exception& error) {
      if (is_ending_) return;
      news = {.trouble = error.what()};
    }
    tell(std::move(news));
  }
}

void FarmFrames::tell(News news) {
  if (news == told_) return;
  told_ = std::move(news);
  events_.news(told_);
}

void FarmFrames::look() {
  for (auto at = tasks_.begin(); at != tasks_.end();) {
    auto& [number, task] = *at;
    bool is_over = true;
    try {
      is_over = advance(number, task);
    } catch (const UnreachableError& error) {
      // It is looked at again once the farm answers.
      if (!task.is_dropped) {
        events_.progress(
            number, {.remaining_seconds = -1, .waiting_for = "the farm, which does not answer"});
      }
      throw;
    } catch (const std::exception& error) {
      if (is_ending_) return;
      if (!task.is_dropped) events_.end({.job = number, .failure = error.what()});
    }
    at = is_over ? tasks_.erase(at) : std::next(at);
  }
}

bool FarmFrames::advance(uint64_t number, Task& task) {
  if (task.is_dropped) {
    drop(task);
    return true;
  }
  if (task.job == 0) {
    if (task.shall_pause) return false;
    submit(number, task);
  }
  if (task.shall_pause != task.is_paused) {
    order(task, task.shall_pause ? v1::JobQuery::PAUSE : v1::JobQuery::RESUME);
    task.is_paused = task.shall_pause;
  }
  return !task.is_paused && follow(number, task);
}

void FarmFrames::submit(uint64_t number, Task& task) {
  if (!task.submission)
    task.submission = std::make_shared<const SubmittedJob>(submission_of(task.frame));
  events_.progress(number, {.remaining_seconds = -1, .waiting_for = "the farm"});
  task.job = farm_.submit(*task.submission, is_ending_);
  task.submission.reset();
}

void FarmFrames::drop(const Task& task) {
  if (task.job == 0) return;
  order(task, v1::JobQuery::CANCEL);
  farm_.order(task.job, v1::JobQuery::FORGET, {}, is_ending_);
}

void FarmFrames::order(const Task& task, v1::JobQuery::Action action) {
  try {
    farm_.order(task.job, action, {}, is_ending_);
  } catch (const UnreachableError&) {
    throw;
  } catch (const Error& error) {
    if (error.code() == ExitCode::interrupted) throw;
  }
}

bool FarmFrames::follow(uint64_t number, Task& task) {
  const Json status = Json::parse(farm_.status(task.job, is_ending_));
  events_.progress(number, progress_in(status));
  if (!has_ended(status)) return false;
  // Smoothed here, as the options of the frame ask for it.
  FetchedPicture fetched = farm_.fetch(task.job, 0, false, is_ending_);
  if (!fetched.has_ended) return false;
  const std::chrono::duration<double> taken = Clock::now() - task.begun;
  FrameEnd end{.job = number, .seconds = taken.count()};
  if (fetched.picture) {
    end.result = std::make_shared<JobResult>(
        JobResult{.report = fetched.picture->report, .film = std::move(fetched.picture->film)});
  } else {
    end.failure = fetched.failure ? fetched.failure->what() : "the farm has no picture of it";
  }
  events_.end(std::move(end));
  task.is_dropped = true;  // also where the farm does not hear of it now
  drop(task);
  return true;
}

void FarmFrames::show(uint64_t number, const std::function<void(Picture)>& take) {
  const auto at = tasks_.find(number);
  Picture picture;
  try {
    if (at != tasks_.end() && at->second.job != 0)
      picture = farm_.snapshot(at->second.job, 0, is_ending_);
  } catch (const std::exception&) {
    // That it does not answer is told by look().
  }
  take(std::move(picture));
}

}  // namespace tessera
