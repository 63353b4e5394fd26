// Arbitrary bytes as frames, and arbitrary messages at each side of the farm. Input: any number of
// pieces, each a byte that says where it goes, two bytes of length, and so many bytes. The first
// byte's highest bit says where it begins: at the door, or behind it, with a coordinator that was
// started anew on its store, two workers that it has welcomed, and messages of theirs that are
// given the numbers of jobs and leases that there are.
#include <google/protobuf/stubs/logging.h>

#include <cstddef>
#include <cstdint>
#include <cstring>
#include <span>
#include <string>

#include "base/error.h"
#include "base/log.h"
#include "client/job_client.h"
#include "client/partial_film.h"
#include "coordinator/coordinator.h"
#include "coordinator/jobs/memory_job_store.h"
#include "proto/wire/frame.h"
#include "proto/wire/pixels.h"
#include "tests/farm/fake_renderer.h"
#include "tests/farm/frame_names.h"
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
      try {
        outcome.renderer = testing::make_fake_renderer(build->run->scene(), build->run->blobs,
                                                       build->run->frame, 1);
      } catch (const Error& error) {
        outcome.failure = error.what();
      }
      session.on_built(std::move(outcome), now);
    } else if (auto* start = std::get_if<StartTrace>(&action)) {
      // A legal tile may be a whole frame of 2^28 pixels, which proves nothing more here.
      if (start->run->task.rect.area() < 4096) session.on_traced(trace(start->run), now);
    } else if (auto* send = std::get_if<SendMessage>(&action)) {
      encode(send->message);
    }
  }
}

/// A farm with a job of a client, from before, and one of its own, and workers "p" and "q" that
/// have built both scenes and hold tiles.
class Farm {
 public:
  explicit Farm(const JobSpec& job) {
    const auto store = std::make_shared<MemoryJobStore>(7);
    CoordinatorOptions options;
    options.opening = "the one before";
    options.verify = 0.5;
    {
      Coordinator before(options, store);
      submit(before, job);
    }
    options.opening = "this one, at last";
    coordinator = Coordinator(options, store);
    coordinator.submit(job, {});
    coordinator.on_tick({});
    for (const uint64_t worker : {1, 2}) {
      v1::Envelope message;
      v1::Hello& hello = *message.mutable_hello();
      hello.set_protocol_major(kProtocolMajor);
      hello.set_numerics_id(kNumericsId);
      hello.set_worker_id(worker);
      hello.set_session(1);
      hello.set_credit(4);
      hello.set_threads(2);
      coordinator.on_message(Channel::control, worker == 1 ? "p" : "q", message, {});
      listen();
    }
  }

  /// Takes what the coordinator says: workers build at once what they are told of.
  void listen() {
    for (auto told = coordinator.take_outgoing(); !told.empty();) {
      for (const OutgoingMessage& out : told) {
        encode(out.message);
        names_.note(out.message);
        if (out.message.has_assign() && assigns_.size() < 256) {
          assigns_.push_back(out.message.assign());
        }
        if (!out.message.has_job_start()) continue;
        v1::Envelope ready;
        ready.mutable_scene_ready()->set_session(1);
        ready.mutable_scene_ready()->set_job(out.message.job_start().job());
        names_.complete(ready);
        coordinator.on_message(Channel::control, out.peer, ready, {});
      }
      told = coordinator.take_outgoing();
    }
  }

  /// Gives it numbers that the coordinator knows. A lease that is small picks one that was given.
  void make_known(v1::Envelope& message) const {
    if (assigns_.empty()) return;
    if (message.has_heartbeat()) {
      message.mutable_heartbeat()->set_session(1);
      for (auto& held : *message.mutable_heartbeat()->mutable_progress()) make_known(held);
    } else if (message.has_tile_failed()) {
      message.mutable_tile_failed()->set_session(1);
      make_known(*message.mutable_tile_failed());
    } else if (message.has_scene_ready()) {
      message.mutable_scene_ready()->set_session(1);
      message.mutable_scene_ready()->set_job(job_of(message.scene_ready().job()));
    } else if (message.has_scene_failed()) {
      message.mutable_scene_failed()->set_job(job_of(message.scene_failed().job()));
    } else if (message.has_tile_band()) {
      make_known(*message.mutable_tile_band());
    }
    names_.complete(message);
  }

  Coordinator coordinator{CoordinatorOptions{}};

 private:
  static void submit(Coordinator& to, const JobSpec& job) {
    JobClient client(job, 1, {});
    for (int turn = 0; turn < 8; ++turn) {
      client.on_tick(std::chrono::seconds(turn));
      for (auto& [channel, message] : client.take_outgoing()) {
        if (message.has_submit_job()) message.mutable_submit_job()->set_detached(true);
        to.on_message(channel, "c", message, {});
      }
      for (const auto& out : to.take_outgoing()) client.on_message(out.channel, out.message, {});
    }
  }
  uint64_t job_of(uint64_t pick) const { return assigns_[pick % assigns_.size()].job(); }
  template <typename Message>
  void make_known(Message& message) const {
    const v1::Assign& known = assigns_[message.lease() % assigns_.size()];
    message.set_job(known.job());
    if (message.lease() < 256) message.set_lease(known.lease());
  }
  /// Where it has no pixels of its own, it gets sound ones of its rows.
  void make_known(v1::TileBand& band) const {
    const v1::Assign known = assigns_[band.lease() % assigns_.size()];
    make_known<v1::TileBand>(band);
    band.set_tile(static_cast<uint32_t>(band.lease()) & 0xfffff);
    if (!band.pixels().empty()) return;
    const int width = known.rect().x1() - known.rect().x0();
    const int height = known.rect().y1() - known.rect().y0();
    const auto rows = static_cast<size_t>(band.rows()) % static_cast<size_t>(height) + 1;
    const std::vector<float> values(static_cast<size_t>(width) * rows * kWireChannels,
                                    static_cast<float>(band.trace_microseconds() % 2));
    const v1::TileBand sound = encode_bands(values, width, 0, false)[0];
    band.set_first_row(known.rect().y0() + static_cast<int>(band.first_row() % 8));
    band.set_rows(sound.rows());
    band.set_encoding(sound.encoding());
    band.set_pixels(sound.pixels());
    band.set_pixel_crc(sound.pixel_crc());
  }

  testing::FrameNames names_;
  std::vector<v1::Assign> assigns_;
};

/// Messages of welcomed workers alone.
void fuzz_behind_the_door(std::span<const std::byte> input) {
  Farm farm(testing::make_job(24, 24, 8));
  Time now{0};
  while (input.size() >= 3) {
    const auto where = static_cast<unsigned>(input[0]);
    const size_t length = std::min(
        input.size() - 3, static_cast<size_t>(input[1]) << 8 | static_cast<size_t>(input[2]));
    auto message = message_of(input.subspan(3, length));
    input = input.subspan(3 + length);
    now += std::chrono::milliseconds((where & 120) * 10);
    if (message) {
      if (where & 2) farm.make_known(*message);
      const Channel channel = message->has_done_tiles_query() ? Channel::bulk : Channel::control;
      farm.coordinator.on_message(channel, where & 4 ? "p" : "q", *message, now);
    }
    if (where & 1) farm.coordinator.on_tick(now);
    farm.listen();
    farm.coordinator.snapshot(now);
  }
}

}  // namespace

extern "C" int LLVMFuzzerInitialize(int*, char***) {
  spdlog::set_level(spdlog::level::off);
  google::protobuf::SetLogHandler(nullptr);
  return 0;
}

extern "C" int LLVMFuzzerTestOneInput(const uint8_t* data, size_t size) {
  if (size > 0 && data[0] & 128) {
    fuzz_behind_the_door(std::as_bytes(std::span(data, size)));
    return 0;
  }
  Time now{0};
  Coordinator coordinator{CoordinatorOptions{}};
  const JobSpec job = tessera::testing::make_job(24, 24, 8);
  coordinator.submit(job, now);
  SessionOptions options;
  options.hello.set_worker_id(1);
  options.hello.set_credit(2);
  WorkerSession session(options, now);
  JobClient client(job, 1, now);
  PartialFilm partial({}, job.crop);
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
      if (message->has_done_tiles() && partial.question(now)) {
        partial.on_answer(message->done_tiles(), now);
        partial.missing();
      }
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
