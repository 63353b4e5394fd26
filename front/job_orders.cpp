#include "front/job_orders.h"

#include <fmt/format.h>
#include <pwd.h>
#include <unistd.h>

#include <array>
#include <nlohmann/json.hpp>
#include <string>
#include <utility>

#include "base/process.h"
#include "front/job_status.h"
#include "front/order_outcome.h"
#include "front/picture.h"
#include "front/render_options.h"
#include "front/statistics.h"
#include "job/job_messages.h"
#include "proto/wire/printable.h"
#include "renderer/denoise/denoiser.h"

namespace tessera {
namespace {

/// The status of a job that must be there while its pictures are fetched.
v1::JobStatus ask_while_fetching(FarmClient& client, const v1::JobQuery& query) {
  v1::JobStatus status = client.ask(query);
  if (status.state() != v1::JobStatus::UNKNOWN) return status;
  throw render_error(fmt::format(
      "job {} is forgotten; expected it to be there until its pictures are fetched", query.job()));
}

ExitCode code_of_failure(uint32_t told) {
  const ExitCode code = to_exit_code(told);
  return code == ExitCode::done ? ExitCode::render_failed : code;
}

/// What a frame that has ended failed with.
std::optional<Error> failure_of(uint64_t job, const JobReport& report) {
  if (report.end == JobReport::End::done) return std::nullopt;
  if (report.end == JobReport::End::interrupted) {
    return Error(report.exit_code, fmt::format("job {} was cancelled", job));
  }
  return Error(report.exit_code, report.failure);
}

void smooth(Film& film) {
  const AovSet needed = denoising_aovs();
  if ((film.aovs().bits() & needed.bits()) != needed.bits()) {
    throw usage_error(
        "--denoise: the job lacks what that looks at; expected one submitted with --aovs "
        "albedo,normal,depth,variance");
  }
  denoise(film, core_count());
}

/// The film of a frame that has ended; nothing where the coordinator has found it damaged, and is
/// to be asked how the job is now.
std::optional<Film> fetch_film(FarmClient& client, const v1::JobQuery& query,
                               const v1::JobStatus& status) {
  std::optional<Film> film = client.fetch_film(status);
  if (film) return film;
  const v1::JobStatus now = ask_while_fetching(client, query);
  if (now.end().film_digest() != status.end().film_digest()) return std::nullopt;
  throw render_error(fmt::format(
      "job {}: tiles of its picture are damaged in the coordinator's store, or gone; expected "
      "all that were kept: submit it again",
      status.job()));
}

RenderedPicture picture_of(const v1::JobFrame& frame, Film film, JobReport report, bool denoises) {
  if (denoises) check_denoisable(frame.settings());
  const bool denoised = is_denoised(denoises, report, frame.settings());
  if (denoised) smooth(film);
  return {.film = std::move(film),
          .output = frame.output(),
          .metadata =
              picture_metadata(frame.settings(), denoised, frame.output(), frame.scene_digest()),
          .report = std::move(report)};
}

/// "user@host", as much of it as is known.
std::string user_name() {
  std::array<char, 4096> strings{};
  passwd entry{};
  passwd* found = nullptr;
  ::getpwuid_r(::geteuid(), &entry, strings.data(), strings.size(), &found);
  std::array<char, 256> host{};
  if (::gethostname(host.data(), host.size() - 1) != 0) host[0] = '\0';
  return fmt::format("{}@{}", found ? found->pw_name : std::to_string(::geteuid()), host.data());
}

}  // namespace

v1::JobStatus submit_job(FarmClient& client, const SubmittedJob& job) {
  v1::JobStatus status = client.submit(job);
  if (status.job() != 0) return status;
  throw Error(code_of_failure(status.exit_code()), printable(status.failure()));
}

v1::JobStatus ask_job(FarmClient& client, const v1::JobQuery& query) {
  v1::JobStatus status = client.ask(query);
  if (status.state() != v1::JobStatus::UNKNOWN) return status;
  throw usage_error(fmt::format("JOB: {} is no job of the farm, or forgotten", query.job()));
}

nlohmann::ordered_json list_json(const v1::JobList& list) {
  nlohmann::ordered_json result{{"jobs", nlohmann::ordered_json::array()},
                                {"workers", list.workers()}};
  for (const v1::JobStatus& job : list.jobs()) {
    result["jobs"].push_back(status_json(job));
  }
  return result;
}

bool may_be_retried(const v1::JobStatus& status) {
  const bool failed = status.state() == v1::JobStatus::ENDED && status.how() == v1::JobEnd::FAILED;
  return failed || status.state() == v1::JobStatus::HELD;
}

v1::JobStatus give_order(FarmClient& client, const v1::JobQuery& order, bool ended_too) {
  const auto refuse = [](const v1::JobStatus& job, const char* expected) {
    throw usage_error(fmt::format("JOB: job {} is {}; expected one that {}", job.job(),
                                  state_name(job), expected));
  };
  const bool retries = order.action() == v1::JobQuery::RETRY;
  if (retries) {
    v1::JobQuery question;
    question.set_job(order.job());
    const v1::JobStatus before = ask_job(client, question);
    if (!may_be_retried(before)) refuse(before, "failed or is held");
  }
  v1::JobQuery in_our_name = order;
  in_our_name.set_by(user_name());
  v1::JobStatus status = ask_job(client, in_our_name);
  if (status.state() == v1::JobStatus::ENDED && !retries) {
    const bool cancelled = status.how() == v1::JobEnd::INTERRUPTED;
    const bool is_fine = order.action() == v1::JobQuery::CANCEL && (cancelled || ended_too);
    if (!is_fine) refuse(status, "has not ended");
  }
  if (const auto missed = unfulfilled(order, status)) {
    throw render_error(fmt::format("job {} {}", order.job(), *missed));
  }
  return status;
}

void forget_job(FarmClient& client, uint64_t job) {
  v1::JobQuery query;
  query.set_job(job);
  query.set_action(v1::JobQuery::FORGET);
  const v1::JobStatus after = client.ask(query);
  if (after.state() == v1::JobStatus::UNKNOWN) return;
  if (after.state() != v1::JobStatus::ENDED) {
    throw usage_error(
        fmt::format("JOB: job {} is {}; expected one that has ended, or was cancelled", job,
                    state_name(after)));
  }
  throw render_error(fmt::format("job {} is {}, but could not be forgotten{}", job,
                                 state_name(after),
                                 after.failure().empty() ? "" : ": " + printable(after.failure())));
}

FetchedFrame fetch_frame(FarmClient& client, const v1::JobQuery& query, bool denoises) {
  while (true) {
    FetchedFrame fetched{.status = ask_while_fetching(client, query)};
    const v1::JobStatus& status = fetched.status;
    if (!status.has_end()) {
      if (status.state() == v1::JobStatus::ENDED) {
        fetched.failure =
            Error(code_of_failure(status.exit_code()),
                  fmt::format("job {}: {}", status.job(), printable(status.failure())));
      }
      return fetched;
    }
    JobReport report = from_message(status.end());
    fetched.failure = failure_of(status.job(), report);
    if (report.tiles_done == 0) {
      if (!fetched.failure)
        fetched.failure = render_error("the farm has no tile of a frame that is done");
      return fetched;
    }
    if (std::optional<Film> film = fetch_film(client, query, status)) {
      fetched.picture = picture_of(status.frame(), std::move(*film), std::move(report), denoises);
      return fetched;
    }
  }
}

std::string fetched_statistics(const v1::JobFrame& frame, const RenderedPicture& picture) {
  const JobReport& report = picture.report;
  const double total = report.build_seconds + report.trace_seconds + report.assemble_seconds;
  return statistics_json({.scene_digest = frame.scene_digest(),
                          .frame = frame.settings(),
                          .width = picture.film.width(),
                          .height = picture.film.height(),
                          .seconds = {.parse = 0, .write = 0, .total = total},
                          .report = report,
                          .peak_worker_bytes = 0,
                          .pixels_sha256 = picture.film.pixels_sha256()})
      .dump();
}

}  // namespace tessera
