#include "client/run_remote_job.h"

#include <fmt/format.h>

#include <algorithm>
#include <utility>

#include "base/monotonic.h"
#include "client/job_client.h"
#include "client/refusal.h"
#include "job/check_job.h"
#include "proto/wire/frame.h"

namespace tessera {
namespace {

constexpr Time kTellProgress = std::chrono::milliseconds(100);
constexpr Time kLongestPause = std::chrono::milliseconds(50);

}  // namespace

JobResult run_remote_job(ClientTransport& transport, const std::string& endpoint,
                         const JobSpec& job, const ProgressCallback& progress,
                         const std::atomic<bool>& stop, Time patience) {
  check_job(job);
  JobClient client(job, draw_submission(), monotonic_now());
  TroublePatience trouble(patience, monotonic_now());
  FirstWord first_word(monotonic_now());
  Time next_progress{};
  while (true) {
    if (!client.bulk_endpoint().empty()) transport.connect_bulk(client.bulk_endpoint());
    for (auto& [channel, message] : client.take_outgoing()) {
      transport.send(channel, encode(message));
    }
    if (auto result = client.take_result()) return std::move(*result);
    const Time pause = std::clamp(client.next_deadline() - monotonic_now(), Time{0}, kLongestPause);
    transport.wait(std::chrono::ceil<std::chrono::milliseconds>(pause));
    while (const auto received = transport.receive()) {
      const auto message = decode(received->bytes, max_message_bytes(received->channel));
      if (!message) continue;
      first_word.heard();
      check_not_refused(*message, endpoint);
      client.on_message(received->channel, *message, monotonic_now());
    }
    const Time now = monotonic_now();
    check_let_in(transport, endpoint);
    first_word.check(endpoint, now);
    trouble.check(transport, endpoint, client.moves_blobs(), now);
    if (stop) client.cancel(now);
    if (now >= client.next_deadline()) client.on_tick(now);
    if (progress && now >= next_progress) {
      JobProgress told = client.progress();
      if (told.waiting_for == JobClient::kForCoordinator) told.waiting_for += " at " + endpoint;
      progress(told);
      next_progress = now + kTellProgress;
    }
    if (now - client.last_heard() > patience) {
      throw UnreachableError(fmt::format(
          "no word from the coordinator at {} for {} s{}; expected an answer to the job", endpoint,
          to_seconds(patience), known_trouble(transport)));
    }
  }
}

}  // namespace tessera
