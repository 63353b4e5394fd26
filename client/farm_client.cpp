#include "client/farm_client.h"

#include <fmt/format.h>

#include <algorithm>
#include <cstring>
#include <optional>
#include <utility>

#include "base/error.h"
#include "client/partial_film.h"
#include "client/refusal.h"
#include "job/job_messages.h"
#include "proto/wire/blob_transfer.h"
#include "proto/wire/frame.h"

namespace tessera {
namespace {

constexpr Time kAskAgain = std::chrono::seconds(1);
constexpr std::chrono::milliseconds kLongestWait{50};
/// How long an interrupted submission waits to hear that it is cancelled.
constexpr Time kWithdrawing = std::chrono::seconds(2);
// Where a wait takes longer, this process did not run.
constexpr Time kLongestRound = std::chrono::seconds(1);

/// Questions asked by any client: the answer to one of a client that is gone may still come over
/// the connection that the next one uses.
std::atomic<uint64_t> questions_asked{0};

/// The window of the job, or nothing where no job can have it.
std::optional<PixelRect> crop_of(const v1::JobStatus& status) {
  const PixelRect crop = rect_of(status.crop());
  const bool sane = !crop.empty() && crop.width() <= kMaxFrameSide &&
                    crop.height() <= kMaxFrameSide && crop.area() <= kMaxFramePixels;
  return sane ? std::optional(crop) : std::nullopt;
}

}  // namespace

FarmClient::FarmClient(ClientTransport& transport, std::string endpoint,
                       const std::atomic<bool>& stop, Time patience)
    : transport_(transport),
      endpoint_(std::move(endpoint)),
      stop_(stop),
      patience_(patience),
      silence_(monotonic_now()),
      first_word_(monotonic_now()) {}

void FarmClient::receive(const Handler& handle, bool& done) {
  const Time due = monotonic_now() + kLongestRound;
  transport_.wait(kLongestWait);
  silence_.listen(due, monotonic_now());
  while (const auto received = transport_.receive()) {
    const auto message = decode(received->bytes, max_message_bytes(received->channel));
    if (!message) continue;
    silence_.heard(monotonic_now());
    first_word_.heard();
    check_not_refused(*message, endpoint_);
    done |= handle(received->channel, *message);
  }
}

void FarmClient::converse(Channel channel, const v1::Envelope& question, const Handler& done,
                          const std::string& interrupted) {
  Time ask = monotonic_now();
  silence_.heard(ask);
  for (bool finished = false; !finished;) {
    if (const Time now = monotonic_now(); now >= ask) {
      transport_.send(channel, encode(question));
      ask = now + kAskAgain;
    }
    receive(done, finished);
    const Time now = monotonic_now();
    check_let_in(transport_, endpoint_);
    first_word_.check(transport_, endpoint_, now);
    if (stop_) throw Error(ExitCode::interrupted, interrupted);
    if (silence_.length(now) > patience_) {
      throw UnreachableError(
          endpoint_,
          fmt::format("no word from the coordinator at {} for {} s{}; expected an answer",
                      endpoint_, to_seconds(patience_), known_trouble(transport_)));
    }
  }
}

v1::JobStatus FarmClient::submit(const SubmittedJob& job) {
  v1::Envelope question;
  *question.mutable_submit_job() = job.request;
  v1::JobStatus result;
  TroublePatience trouble(patience_, monotonic_now());
  const auto hand_over = [&](Channel, const v1::Envelope& message) {
    trouble.check(transport_, endpoint_, true, monotonic_now());
    if (message.has_blob_request()) {
      const auto digest = Digest::parse(message.blob_request().digest());
      const v1::Envelope answer =
          answer_blob_request(message.blob_request(), digest ? job.blobs.find(*digest) : nullptr);
      bytes_sent_ += answer.blob_chunk().data().size();
      if (answer.has_blob_chunk() && answer.blob_chunk().offset() == 0) ++blobs_sent_;
      transport_.send(Channel::bulk, encode(answer));
    }
    if (!message.has_job_status() ||
        message.job_status().submission() != job.request.submission()) {
      return false;
    }
    result = message.job_status();
    transport_.connect_bulk(result.bulk_endpoint());
    return result.state() != v1::JobStatus::UNKNOWN && result.state() != v1::JobStatus::FETCHING;
  };
  try {
    converse(Channel::control, question, hand_over);
  } catch (const Error& error) {
    if (error.code() != ExitCode::interrupted) throw;
    throw Error(ExitCode::interrupted, withdraw(job.request.submission()));
  }
  return result;
}

std::string FarmClient::withdraw(uint64_t submission) {
  const uint64_t number = ++questions_asked;
  v1::Envelope order;
  order.mutable_job_query()->set_submission(submission);
  order.mutable_job_query()->set_action(v1::JobQuery::CANCEL);
  order.mutable_job_query()->set_question(number);
  std::optional<v1::JobStatus> status;
  const Time end = monotonic_now() + std::min(kWithdrawing, patience_);
  for (Time now = monotonic_now(), ask = now; !status && now < end; now = monotonic_now()) {
    if (now >= ask) {
      transport_.send(Channel::control, encode(order));
      ask = now + kAskAgain;
    }
    bool ignored = false;
    receive(
        [&](Channel, const v1::Envelope& message) {
          if (message.has_job_status() && message.job_status().question() == number)
            status = message.job_status();
          return false;
        },
        ignored);
  }
  if (!status) {
    return fmt::format(
        "interrupted, but the coordinator at {} has not confirmed within {} s that the job is "
        "cancelled: it may come; 'tessera status' lists it then",
        endpoint_, to_seconds(std::min(kWithdrawing, patience_)));
  }
  v1::Envelope release;
  release.mutable_job_release()->set_submission(submission);
  transport_.send(Channel::control, encode(release));
  const bool is_there =
      status->state() != v1::JobStatus::UNKNOWN && status->how() != v1::JobEnd::INTERRUPTED;
  return is_there ? fmt::format("interrupted; job {} has come and was not cancelled", status->job())
                  : "interrupted; the job is cancelled";
}

v1::JobStatus FarmClient::ask(const v1::JobQuery& query) {
  v1::Envelope question;
  *question.mutable_job_query() = query;
  // It is asked again while answers are on their way: those to an earlier question say how the job
  // was before this order.
  const uint64_t number = ++questions_asked;
  question.mutable_job_query()->set_question(number);
  v1::JobStatus result;
  const auto on_status = [&](Channel, const v1::Envelope& message) {
    if (!message.has_job_status()) return false;
    const v1::JobStatus& status = message.job_status();
    const bool same = status.question() == number;
    if (same) result = status;
    return same;
  };
  const bool orders = query.action() != v1::JobQuery::ASK || query.has_priority();
  converse(Channel::control, question, on_status,
           orders ? "interrupted; the order may be followed all the same" : "interrupted");
  return result;
}

v1::JobList FarmClient::list() {
  v1::JobList all;
  bool more = true;
  while (more) {
    v1::Envelope question;
    const uint64_t after = all.jobs().empty() ? 0 : all.jobs(all.jobs_size() - 1).job();
    question.mutable_job_list_query()->set_after(after);
    converse(Channel::control, question, [&](Channel, const v1::Envelope& message) {
      if (!message.has_job_list()) return false;
      const v1::JobList& part = message.job_list();
      // Questions are asked again while answers are on their way: of several, the first counts.
      const uint64_t last = all.jobs().empty() ? 0 : all.jobs(all.jobs_size() - 1).job();
      if (last != after || (!part.jobs().empty() && part.jobs(0).job() <= after)) return false;
      more = part.more();
      for (const v1::JobStatus& job : part.jobs()) *all.add_jobs() = job;
      all.set_workers(part.workers());
      all.set_threads(part.threads());
      all.set_last(part.last());
      return true;
    });
  }
  return all;
}

v1::EnrolAnswer FarmClient::enrol(const v1::Enrol& request) {
  v1::Envelope question;
  *question.mutable_enrol() = request;
  v1::EnrolAnswer result;
  const auto on_answer = [&](Channel, const v1::Envelope& message) {
    if (message.has_enrol_answer()) result = message.enrol_answer();
    return message.has_enrol_answer();
  };
  converse(Channel::control, question, on_answer,
           "interrupted; the key may be enrolled all the same: the same command asks again");
  return result;
}

std::optional<Film> FarmClient::fetch_film(const v1::JobStatus& status) {
  const auto crop = crop_of(status);
  const auto digest = Digest::parse(status.end().film_digest());
  const AovSet aovs(status.frame().settings().aovs());
  const uint64_t size = crop ? film_bytes(*crop, aovs) : 0;
  if (!digest || !crop || status.end().film_size() != size) {
    throw render_error("there is no picture; expected one that can be fetched");
  }
  transport_.connect_bulk(status.bulk_endpoint());
  BlobFetch fetch;
  fetch.want(*digest, size);
  BlobStore store;
  bool missing = false;
  silence_.heard(monotonic_now());
  TroublePatience trouble(patience_, monotonic_now());
  while (!fetch.finished()) {
    for (v1::BlobRequest& request : fetch.requests(monotonic_now())) {
      v1::Envelope message;
      *message.mutable_blob_request() = std::move(request);
      transport_.send(Channel::bulk, encode(message));
    }
    bool ignored = false;
    receive(
        [&](Channel, const v1::Envelope& message) {
          if (message.has_blob_chunk()) fetch.on_chunk(message.blob_chunk(), store);
          missing |= message.has_blob_missing() &&
                     message.blob_missing().digest() == status.end().film_digest();
          return false;
        },
        ignored);
    if (missing) return std::nullopt;
    if (!fetch.failure().empty()) {
      throw render_error("the picture could not be fetched: " + fetch.failure());
    }
    check_let_in(transport_, endpoint_);
    if (stop_) throw Error(ExitCode::interrupted, "interrupted");
    trouble.check(transport_, endpoint_, true, monotonic_now());
    if (silence_.length(monotonic_now()) > patience_) {
      throw UnreachableError(endpoint_,
                             fmt::format("no word from the coordinator at {}", endpoint_));
    }
  }
  Film film(*crop, aovs);
  std::memcpy(film.values().data(), store.find(*digest)->data(), static_cast<size_t>(size));
  return film;
}

std::optional<Film> FarmClient::fetch_done(const v1::JobStatus& status, uint32_t frame) {
  const auto crop = crop_of(status);
  if (!crop || status.state() != v1::JobStatus::RUNNING) return std::nullopt;
  transport_.connect_bulk(status.bulk_endpoint());
  v1::DoneTilesQuery query;
  query.set_job(status.job());
  query.set_frame(frame);
  PartialFilm partial(query, *crop);
  bool any = false;
  TroublePatience trouble(patience_, monotonic_now());
  while (!partial.is_up_to_date()) {
    v1::Envelope message;
    *message.mutable_done_tiles_query() = *partial.question(monotonic_now());
    converse(Channel::bulk, message, [&](Channel, const v1::Envelope& answer) {
      trouble.check(transport_, endpoint_, true, monotonic_now());
      if (!answer.has_done_tiles() ||
          answer.done_tiles().question() != message.done_tiles_query().question()) {
        return false;
      }
      any |= !partial.on_answer(answer.done_tiles(), monotonic_now()).empty();
      return true;
    });
  }
  return any ? std::optional(partial.film().with_only({})) : std::nullopt;
}

void FarmClient::wait(Time time) {
  const Time end = monotonic_now() + time;
  while (monotonic_now() < end && !stop_) {
    bool ignored = false;
    receive([](Channel, const v1::Envelope&) { return false; }, ignored);
  }
  if (stop_) throw Error(ExitCode::interrupted, "interrupted");
}

}  // namespace tessera
