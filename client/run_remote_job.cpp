#include "client/run_remote_job.h"

#include <fmt/format.h>

#include <algorithm>
#include <optional>
#include <utility>
#include <vector>

#include "base/monotonic.h"
#include "client/job_client.h"
#include "client/partial_film.h"
#include "client/refusal.h"
#include "job/check_job.h"
#include "proto/wire/frame.h"

namespace tessera {
namespace {

constexpr Time kTellProgress = std::chrono::milliseconds(100);
constexpr Time kLongestPause = std::chrono::milliseconds(50);

void tell(const TileCallback& tiles, const Film& film, std::vector<PixelRect> done) {
  if (!done.empty()) tiles({film.rect(), film.channels(), film.values(), std::move(done)});
}

void ask(PartialFilm& partial, ClientTransport& transport) {
  const auto question = partial.question(monotonic_now());
  if (!question) return;
  v1::Envelope message;
  *message.mutable_done_tiles_query() = *question;
  transport.send(Channel::bulk, encode(message));
}

}  // namespace

JobResult run_remote_job(ClientTransport& transport, const std::string& endpoint,
                         const JobSpec& job, const ProgressCallback& progress,
                         const std::atomic<bool>& stop, Time patience, const TileCallback& tiles) {
  check_job(job);
  v1::DoneTilesQuery frame;
  frame.set_submission(draw_submission());
  JobClient client(job, frame.submission(), monotonic_now());
  std::optional<PartialFilm> partial;
  if (tiles) partial.emplace(frame, job.crop);
  TroublePatience trouble(patience, monotonic_now());
  FirstWord first_word(monotonic_now());
  Time next_progress{};
  while (true) {
    if (!client.bulk_endpoint().empty()) transport.connect_bulk(client.bulk_endpoint());
    for (auto& [channel, message] : client.take_outgoing()) {
      transport.send(channel, encode(message));
    }
    if (auto result = client.take_result()) {
      if (partial) tell(tiles, result->film, partial->missing(result->report.holes));
      return std::move(*result);
    }
    if (partial && client.is_traced()) ask(*partial, transport);
    const Time pause = std::clamp(client.next_deadline() - monotonic_now(), Time{0}, kLongestPause);
    transport.wait(std::chrono::ceil<std::chrono::milliseconds>(pause));
    while (const auto received = transport.receive()) {
      const auto message = decode(received->bytes, max_message_bytes(received->channel));
      if (!message) continue;
      first_word.heard();
      check_not_refused(*message, endpoint);
      client.on_message(received->channel, *message, monotonic_now());
      if (partial && message->has_done_tiles()) {
        tell(tiles, partial->film(), partial->on_answer(message->done_tiles(), monotonic_now()));
      }
    }
    const Time now = monotonic_now();
    check_let_in(transport, endpoint);
    first_word.check(transport, endpoint, now);
    trouble.check(transport, endpoint, client.moves_blobs(), now);
    if (stop) client.cancel(now);
    if (now >= client.next_deadline()) client.on_tick(now);
    if (progress && now >= next_progress) {
      JobProgress told = client.progress();
      if (told.waiting_for == JobClient::kForCoordinator) told.waiting_for += " at " + endpoint;
      progress(told);
      next_progress = now + kTellProgress;
    }
    if (client.silence(now) > patience) {
      throw UnreachableError(
          endpoint,
          fmt::format(
              "no word from the coordinator at {} for {} s{}; expected an answer to the job",
              endpoint, to_seconds(patience), known_trouble(transport)));
    }
  }
}

}  // namespace tessera
