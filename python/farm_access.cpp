#include "python/farm_access.h"

#include <fmt/format.h>

#include <nlohmann/json.hpp>

#include "base/error.h"
#include "client/refusal.h"
#include "front/job_name.h"
#include "front/job_status.h"
#include "front/order_outcome.h"
#include "job/job_messages.h"
#include "proto/wire/printable.h"

namespace tessera {

FarmAccess::FarmAccess(const FarmConnection& connection)
    : connection_(connection), transport_(connect(connection)) {
  check_host_is_known(connection.endpoint);
}

v1::JobStatus FarmAccess::known(FarmClient& client, const v1::JobQuery& query) {
  v1::JobStatus status = client.ask(query);
  if (status.state() != v1::JobStatus::UNKNOWN) return status;
  throw usage_error(fmt::format("job: {} is no job of the farm, or forgotten", query.job()));
}

uint64_t FarmAccess::submit(const SubmittedJob& job, const std::atomic<bool>& stop) {
  const std::lock_guard lock(mutex_);
  const v1::JobStatus status = client(stop).submit(job);
  if (status.job() != 0) return status.job();
  const auto code = to_exit_code(status.exit_code());
  throw Error(code == ExitCode::done ? ExitCode::render_failed : code, printable(status.failure()));
}

uint64_t FarmAccess::find(const std::string& text, const std::atomic<bool>& stop) {
  const std::lock_guard lock(mutex_);
  FarmClient asking = client(stop);
  return find_job(asking, text, [](const std::string&) {});
}

std::string FarmAccess::list(const std::atomic<bool>& stop) {
  const std::lock_guard lock(mutex_);
  const v1::JobList all = client(stop).list();
  nlohmann::ordered_json result{{"jobs", nlohmann::ordered_json::array()},
                                {"workers", all.workers()}};
  for (const v1::JobStatus& job : all.jobs()) {
    result["jobs"].push_back(status_json(job, all.workers()));
  }
  return result.dump();
}

std::string FarmAccess::status(uint64_t job, const std::atomic<bool>& stop) {
  const std::lock_guard lock(mutex_);
  FarmClient asking = client(stop);
  v1::JobQuery query;
  query.set_job(job);
  const v1::JobStatus status = known(asking, query);
  return status_json(status, status.workers()).dump();
}

void FarmAccess::order(uint64_t job, v1::JobQuery::Action action, std::optional<int> priority,
                       const std::atomic<bool>& stop) {
  const std::lock_guard lock(mutex_);
  FarmClient asking = client(stop);
  v1::JobQuery query;
  query.set_job(job);
  const v1::JobStatus before = known(asking, query);
  const bool ended = before.state() == v1::JobStatus::ENDED;
  const bool takes_ended = action == v1::JobQuery::RETRY || action == v1::JobQuery::FORGET;
  if (ended && !takes_ended) {
    throw usage_error(
        fmt::format("job: {} is {}; expected one that has not ended", job, state_name(before)));
  }
  query.set_action(action);
  if (priority) query.set_priority(*priority);
  const v1::JobStatus after = asking.ask(query);
  if (action == v1::JobQuery::FORGET) {
    if (after.state() == v1::JobStatus::UNKNOWN) return;
    throw render_error(
        fmt::format("job {} could not be forgotten: {}", job, printable(after.failure())));
  }
  if (const auto missed = unfulfilled(query, after)) {
    throw render_error(fmt::format("job {} {}", job, *missed));
  }
}

std::shared_ptr<RenderedPicture> FarmAccess::fetch(uint64_t job, uint32_t frame,
                                                   const std::atomic<bool>& stop) {
  const std::lock_guard lock(mutex_);
  FarmClient asking = client(stop);
  v1::JobQuery query;
  query.set_job(job);
  query.set_frame(frame);
  const v1::JobStatus status = known(asking, query);
  if (!status.has_end()) {
    const bool over = status.state() == v1::JobStatus::ENDED;
    if (over) throw render_error(fmt::format("job {}: {}", job, printable(status.failure())));
    return nullptr;
  }
  JobReport report = from_message(status.end());
  if (report.tiles_done == 0) {
    throw Error(report.end == JobReport::End::done ? ExitCode::render_failed : report.exit_code,
                fmt::format("job {}: {}", job, report.failure));
  }
  std::optional<Film> film = asking.fetch_film(status);
  if (!film) {
    throw render_error(
        fmt::format("job {}: its picture is damaged in the coordinator's store, or "
                    "gone; expected all that was kept: submit it again",
                    job));
  }
  const v1::JobFrame& of = status.frame();
  return std::make_shared<RenderedPicture>(RenderedPicture{
      .film = std::move(*film),
      .output = of.output(),
      .metadata = picture_metadata(of.settings(), false, of.output(), of.scene_digest()),
      .report = std::move(report)});
}

std::shared_ptr<RenderedPicture> FarmAccess::snapshot(uint64_t job, uint32_t frame,
                                                      const std::atomic<bool>& stop) {
  const std::lock_guard lock(mutex_);
  FarmClient asking = client(stop);
  v1::JobQuery query;
  query.set_job(job);
  query.set_frame(frame);
  const v1::JobStatus status = known(asking, query);
  std::optional<Film> film = asking.fetch_done(status, frame);
  if (!film) return nullptr;
  return std::make_shared<RenderedPicture>(
      RenderedPicture{.film = std::move(*film), .output = status.frame().output()});
}

std::vector<int> FarmAccess::frames(uint64_t job, const std::atomic<bool>& stop) {
  const std::lock_guard lock(mutex_);
  FarmClient asking = client(stop);
  v1::JobQuery query;
  query.set_job(job);
  std::vector<int> numbers;
  const uint32_t count = known(asking, query).frames_total();
  for (uint32_t frame = 0; frame < count; ++frame) {
    query.set_frame(frame);
    numbers.push_back(known(asking, query).frame().number());
  }
  return numbers;
}

}  // namespace tessera
