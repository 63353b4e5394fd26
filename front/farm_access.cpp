#include "front/farm_access.h"

#include <nlohmann/json.hpp>
#include <utility>

#include "base/error.h"
#include "front/job_name.h"
#include "front/job_orders.h"
#include "front/job_status.h"

namespace tessera {
namespace {

constexpr std::chrono::milliseconds kLookAtStop{20};

v1::JobQuery question_about(uint64_t job, uint32_t frame = 0) {
  v1::JobQuery query;
  query.set_job(job);
  query.set_frame(frame);
  return query;
}

}  // namespace

FarmAccess::FarmAccess(const FarmConnection& connection)
    : connection_(connection), transport_(connect(connection)) {}

std::unique_lock<std::timed_mutex> FarmAccess::lock(const std::atomic<bool>& stop) {
  std::unique_lock lock(mutex_, std::defer_lock);
  while (!lock.try_lock_for(kLookAtStop)) {
    if (stop)
      throw Error(ExitCode::interrupted, "interrupted while the farm was asked other things");
  }
  return lock;
}

uint64_t FarmAccess::submit(const SubmittedJob& job, const std::atomic<bool>& stop) {
  const auto held = lock(stop);
  FarmClient asking = client(stop);
  return submit_job(asking, job).job();
}

uint64_t FarmAccess::find(const std::string& text,
                          const std::function<void(const std::string&)>& tell,
                          const std::atomic<bool>& stop) {
  const auto held = lock(stop);
  FarmClient asking = client(stop);
  return find_job(asking, text, tell);
}

std::string FarmAccess::list(const std::atomic<bool>& stop) {
  const auto held = lock(stop);
  return list_json(client(stop).list()).dump();
}

std::string FarmAccess::status(uint64_t job, const std::atomic<bool>& stop) {
  const auto held = lock(stop);
  FarmClient asking = client(stop);
  const v1::JobStatus status = ask_job(asking, question_about(job));
  return status_json(status).dump();
}

void FarmAccess::order(uint64_t job, v1::JobQuery::Action action, std::optional<int> priority,
                       const std::atomic<bool>& stop) {
  const auto held = lock(stop);
  FarmClient asking = client(stop);
  if (action == v1::JobQuery::FORGET) return forget_job(asking, job);
  v1::JobQuery query = question_about(job);
  query.set_action(action);
  if (priority) query.set_priority(*priority);
  give_order(asking, query);
}

FetchedPicture FarmAccess::fetch(uint64_t job, uint32_t frame, bool denoises,
                                 const std::atomic<bool>& stop) {
  const auto held = lock(stop);
  FarmClient asking = client(stop);
  FetchedFrame fetched = fetch_frame(asking, question_about(job, frame), denoises);
  FetchedPicture result{.has_ended = fetched.has_ended(), .failure = std::move(fetched.failure)};
  if (fetched.picture) {
    fetched.picture->statistics = fetched_statistics(fetched.status.frame(), *fetched.picture);
    result.picture = std::make_shared<RenderedPicture>(std::move(*fetched.picture));
  }
  return result;
}

std::shared_ptr<RenderedPicture> FarmAccess::snapshot(uint64_t job, uint32_t frame,
                                                      const std::atomic<bool>& stop) {
  const auto held = lock(stop);
  FarmClient asking = client(stop);
  const v1::JobStatus status = ask_job(asking, question_about(job, frame));
  std::optional<Film> film = asking.fetch_done(status, frame);
  if (!film) return nullptr;
  return std::make_shared<RenderedPicture>(
      RenderedPicture{.film = std::move(*film), .output = status.frame().output()});
}

std::vector<int> FarmAccess::frames(uint64_t job, const std::atomic<bool>& stop) {
  const auto held = lock(stop);
  FarmClient asking = client(stop);
  v1::JobQuery query = question_about(job);
  query.set_numbers(true);
  const v1::JobStatus status = ask_job(asking, query);
  return {status.numbers().begin(), status.numbers().end()};
}

}  // namespace tessera
