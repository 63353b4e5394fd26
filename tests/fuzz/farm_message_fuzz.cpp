// Arbitrary bytes as frames, and arbitrary messages at each side of the farm. Input: any number of
// pieces, each a byte that says where it goes, two bytes of length, and so many bytes.
#include <cstddef>
#include <cstdint>
#include <cstring>
#include <span>
#include <string>

#include "base/log.h"
#include "client/job_client.h"
#include "coordinator/coordinator.h"
#include "proto/wire/frame.h"
#include "tests/farm/fake_renderer.h"
#include "worker/worker_session.h"

namespace {

using namespace tessera;

/// A piece of the input as an Envelope, whether or not its frame is sound: else the fuzzer would
/// have to guess checksums.
std::optional<v1::Envelope> message_of(std::span<const std::byte> bytes) {
  if (const auto framed = decode(bytes, max_message_bytes(Channel::control))) return framed;
  v1::Envelope message;
  if (!message.ParseFromArray(bytes.data(), static_cast<int>(bytes.size()))) return std::nullopt;
  return message;
}

/// Does what the session wants, at once.
void perform(WorkerSession& session, Time now) {
  for (SessionAction& action : session.take_actions()) {
    if (auto* build = std::get_if<StartBuild>(&action)) {
      BuildOutcome outcome;
      outcome.job = build->run->job;
      outcome.renderer =
          testing::make_fake_renderer(build->run->scene, build->run->blobs, build->run->frame, 1);
      session.on_built(std::move(outcome), now);
    } else if (auto* start = std::get_if<StartTrace>(&action)) {
      // A legal tile may be a whole frame of 2^28 pixels, which proves nothing more here.
      if (start->run->task.rect.area() < 4096) session.on_traced(trace(start->run), now);
    } else if (auto* send = std::get_if<SendMessage>(&action)) {
      encode(send->message);
    }
  }
}

}  // namespace

extern "C" int LLVMFuzzerInitialize(int*, char***) {
  spdlog::set_level(spdlog::level::off);
  return 0;
}

extern "C" int LLVMFuzzerTestOneInput(const uint8_t* data, size_t size) {
  Time now{0};
  Coordinator coordinator{CoordinatorOptions{}};
  const JobSpec job = tessera::testing::make_job(24, 24, 8);
  coordinator.submit(job, now);
  SessionOptions options;
  options.hello.set_worker_id(1);
  options.hello.set_credit(2);
  WorkerSession session(options, now);
  JobClient client(job, 1, now);
  auto input = std::as_bytes(std::span(data, size));
  while (input.size() >= 3) {
    const auto where = static_cast<unsigned>(input[0]);
    const size_t length = std::min(
        input.size() - 3, static_cast<size_t>(input[1]) << 8 | static_cast<size_t>(input[2]));
    const auto message = message_of(input.subspan(3, length));
    input = input.subspan(3 + length);
    now += std::chrono::milliseconds(where * 10);
    const Channel channel = where & 1 ? Channel::bulk : Channel::control;
    if (message) {
      if (where & 2) coordinator.on_message(channel, where & 4 ? "p" : "q", *message, now);
      if (where & 8) session.on_message(channel, *message, now);
      if (where & 16) client.on_message(channel, *message, now);
    }
    coordinator.on_tick(now);
    session.on_tick(now);
    client.on_tick(now);
    for (const auto& out : coordinator.take_outgoing()) encode(out.message);
    for (const auto& out : client.take_outgoing()) encode(out.second);
    perform(session, now);
  }
  return 0;
}
