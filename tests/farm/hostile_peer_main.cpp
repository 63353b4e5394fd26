// Somebody whom a farm lets in and who means it ill: says hello as a worker, or comes as a client,
// and then sends whatever a program could send. By hand and by tests/cli/hostile_test.py:
//   farm_hostile_peer ENDPOINT worker|client SEED SECONDS
// With `coordinator` it is the other end: it listens at ENDPOINT, and does the same to who comes.
#include <fmt/format.h>
#include <google/protobuf/message.h>

#include <cmath>
#include <cstdio>
#include <cstdlib>
#include <cstring>
#include <deque>
#include <random>

#include "base/monotonic.h"
#include "proto/transport/zmq_transport.h"
#include "proto/wire/frame.h"
#include "proto/wire/pixels.h"
#include "tests/farm/frame_names.h"
#include "tests/farm/played_hello.h"

namespace {

using namespace tessera;
namespace pb = google::protobuf;

/// Messages that might be meant: of every kind, with numbers and texts that were heard before.
class Inventor {
 public:
  explicit Inventor(uint64_t seed) : random_(seed) {}

  uint64_t draw(uint64_t below) { return random_() % below; }
  bool chance(double share) {
    return std::uniform_real_distribution<double>(0, 1)(random_) < share;
  }

  /// Remembers the numbers and texts of a message, and it.
  void hear(const v1::Envelope& message) {
    learn(message);
    keep(message);
  }
  void keep(const v1::Envelope& message) {
    heard_.push_back(message);
    if (heard_.size() > 64) heard_.pop_front();
  }

  v1::Envelope message() {
    v1::Envelope made;
    if (!heard_.empty() && chance(0.4)) {
      made = heard_[draw(heard_.size())];
      scramble(made, 0.1, 0);
    } else {
      const auto* body = made.GetDescriptor()->oneof_decl(0);
      const auto* kind = body->field(static_cast<int>(draw(body->field_count())));
      scramble(*made.GetReflection()->MutableMessage(&made, kind), 0.6, 1);
    }
    return made;
  }

  /// Its bytes, mostly whole.
  MessageBytes bytes() {
    if (chance(0.1)) return noise(draw(300));
    v1::Envelope made = message();
    // As long as a channel takes, and a little longer.
    while (made.ByteSizeLong() + kFrameHeaderSize > kMaxFrame) made = message();
    MessageBytes frame = encode(made);
    if (chance(0.1)) frame.resize(draw(frame.size() + 1));
    if (chance(0.1) && !frame.empty()) frame[draw(frame.size())] ^= std::byte{1};
    if (chance(0.02)) frame.resize((size_t{2} << 20) - 1 + draw(3));
    return frame;
  }

  std::mt19937_64& random() { return random_; }

 private:
  MessageBytes noise(size_t size) {
    MessageBytes bytes(size);
    for (std::byte& byte : bytes) byte = static_cast<std::byte>(draw(256));
    return bytes;
  }

  void learn(const pb::Message& message) {
    const pb::Reflection& about = *message.GetReflection();
    std::vector<const pb::FieldDescriptor*> fields;
    about.ListFields(message, &fields);
    for (const auto* field : fields) {
      using Kind = pb::FieldDescriptor::CppType;
      if (field->cpp_type() == Kind::CPPTYPE_MESSAGE) {
        if (!field->is_repeated()) learn(about.GetMessage(message, field));
        continue;
      }
      if (field->is_repeated()) continue;
      if (field->cpp_type() == Kind::CPPTYPE_UINT64) note(about.GetUInt64(message, field));
      if (field->cpp_type() == Kind::CPPTYPE_UINT32) note(about.GetUInt32(message, field));
      if (field->cpp_type() == Kind::CPPTYPE_STRING)
        texts_.push_back(about.GetString(message, field));
      if (texts_.size() > 64) texts_.pop_front();
    }
  }
  void note(uint64_t number) {
    numbers_.push_back(number);
    if (numbers_.size() > 256) numbers_.pop_front();
  }

  uint64_t number() {
    if (!numbers_.empty() && chance(0.6)) return numbers_[draw(numbers_.size())];
    switch (draw(5)) {
      case 0:
        return draw(4);
      case 1:
        return UINT64_MAX - draw(2);
      case 2:
        return uint64_t{1} << draw(64);
      default:
        return draw(1000);
    }
  }
  std::string text() {
    if (!texts_.empty() && chance(0.5)) return texts_[draw(texts_.size())];
    return std::string(chance(0.002) ? 100'000 : draw(70), static_cast<char>('0' + draw(70)));
  }
  double real() {
    constexpr double kStrange[] = {0, -1, 1e300, -1e300, HUGE_VAL, -HUGE_VAL, NAN, 1e-310};
    return kStrange[draw(std::size(kStrange))];
  }

  void scramble(pb::Message& message, double share, int depth) {
    const pb::Descriptor& kind = *message.GetDescriptor();
    for (int i = 0; i < kind.field_count(); ++i) {
      const auto* field = kind.field(i);
      if (field->containing_oneof() && field->containing_oneof()->field_count() > 1) continue;
      if (chance(share) && depth < 7) scramble(message, *field, share, depth);
    }
    // Into what is there, too.
    std::vector<const pb::FieldDescriptor*> there;
    const pb::Reflection& about = *message.GetReflection();
    about.ListFields(message, &there);
    for (const auto* field : there) {
      if (field->cpp_type() != pb::FieldDescriptor::CPPTYPE_MESSAGE || field->is_repeated())
        continue;
      scramble(*about.MutableMessage(&message, field), share, depth + 1);
    }
  }
  void scramble(pb::Message& message, const pb::FieldDescriptor& field, double share, int depth) {
    const pb::Reflection& about = *message.GetReflection();
    if (!field.is_repeated()) return set(message, field, share, depth);
    // Many of them have little in them, or one message would take all memory.
    const bool many = depth < 4 && chance(0.01);
    const size_t count = many ? 5'000 : draw(4);
    if (many) depth = 6;
    for (size_t i = 0; i < count; ++i) {
      using Kind = pb::FieldDescriptor::CppType;
      switch (field.cpp_type()) {
        case Kind::CPPTYPE_MESSAGE:
          scramble(*about.AddMessage(&message, &field), share, depth + 1);
          break;
        case Kind::CPPTYPE_STRING:
          about.AddString(&message, &field, text());
          break;
        case Kind::CPPTYPE_UINT64:
          about.AddUInt64(&message, &field, number());
          break;
        case Kind::CPPTYPE_FLOAT:
          about.AddFloat(&message, &field, static_cast<float>(real()));
          break;
        default:
          return;
      }
    }
  }
  void set(pb::Message& message, const pb::FieldDescriptor& field, double share, int depth) {
    const pb::Reflection& about = *message.GetReflection();
    using Kind = pb::FieldDescriptor::CppType;
    switch (field.cpp_type()) {
      case Kind::CPPTYPE_MESSAGE:
        return scramble(*about.MutableMessage(&message, &field), share, depth + 1);
      case Kind::CPPTYPE_STRING:
        return about.SetString(&message, &field, text());
      case Kind::CPPTYPE_UINT64:
        return about.SetUInt64(&message, &field, number());
      case Kind::CPPTYPE_UINT32:
        return about.SetUInt32(&message, &field, static_cast<uint32_t>(number()));
      case Kind::CPPTYPE_INT32:
        return about.SetInt32(&message, &field, static_cast<int32_t>(number()));
      case Kind::CPPTYPE_DOUBLE:
        return about.SetDouble(&message, &field, real());
      case Kind::CPPTYPE_FLOAT:
        return about.SetFloat(&message, &field, static_cast<float>(real()));
      case Kind::CPPTYPE_BOOL:
        return about.SetBool(&message, &field, draw(2) == 0);
      default:
        return;
    }
  }

  std::mt19937_64 random_;
  std::deque<v1::Envelope> heard_;
  std::deque<uint64_t> numbers_{1};
  std::deque<std::string> texts_;
};

/// A key is trusted to do this much: a submitter may end jobs and take all the places of clients,
/// a worker be any number of workers that fail tiles. What that does to a farm is no fault of it.
bool may_be_sent(const v1::Envelope& message, uint64_t worker) {
  if (message.has_job_query()) {
    return message.job_query().action() == v1::JobQuery::ASK && !message.job_query().has_priority();
  }
  if (message.has_hello()) return message.hello().worker_id() == worker;
  if (message.has_submit_job()) return message.submit_job().submission() < 8;
  return !message.has_job_release();
}

/// A tile as a liar would trace it.
v1::Envelope lie(const v1::Assign& assign, uint64_t session, Inventor& inventor) {
  const int width = assign.rect().x1() - assign.rect().x0();
  const int height = assign.rect().y1() - assign.rect().y0();
  const auto count = static_cast<size_t>(width) * static_cast<size_t>(height) * kWireChannels;
  const std::vector<float> values(count, static_cast<float>(inventor.draw(100)));
  v1::Envelope message;
  v1::TileBand& band = *message.mutable_tile_band();
  band = encode_bands(values, width, assign.rect().y0(), false)[0];
  band.set_session(session);
  band.set_job(assign.job());
  band.set_lease(assign.lease());
  band.set_tile(assign.tile());
  return message;
}

int attack(const std::string& endpoint, bool as_worker, uint64_t seed, Time end) {
  Inventor inventor(seed);
  const auto transport = connect_client(endpoint);
  const uint64_t worker = seed >> 1 | 1;
  uint64_t sent = 0, session = 1;
  tessera::testing::FrameNames names;
  const auto greet = [&] {
    v1::Envelope hello = tessera::testing::played_hello(worker);
    hello.mutable_hello()->set_session(session);
    transport->send(Channel::control, encode(hello));
  };
  if (as_worker) greet();
  while (monotonic_now() < end) {
    transport->wait(std::chrono::milliseconds(1));
    while (const auto received = transport->receive()) {
      const auto message = decode(received->bytes, max_message_bytes(received->channel));
      if (!message) continue;
      inventor.hear(*message);
      names.note(*message);
      if (message->has_welcome()) transport->connect_bulk(message->welcome().bulk_endpoint());
      if (message->has_job_status()) {
        transport->connect_bulk(message->job_status().bulk_endpoint());
      }
      if (message->has_hello_request()) {
        ++session;
        greet();
      }
      if (message->has_job_start() && inventor.chance(0.5)) {
        v1::Envelope ready;
        ready.mutable_scene_ready()->set_session(session);
        ready.mutable_scene_ready()->set_job(message->job_start().job());
        names.complete(ready);
        transport->send(Channel::control, encode(ready));
      }
      if (message->has_assign() && inventor.chance(0.3)) {
        v1::Envelope lied = lie(message->assign(), session, inventor);
        names.complete(lied);
        transport->send(Channel::control, encode(lied));
      }
    }
    for (int i = 0; i < 20; ++i) {
      MessageBytes bytes = inventor.bytes();
      const auto channel = inventor.chance(0.2) ? Channel::bulk : Channel::control;
      const auto message = decode(bytes, max_message_bytes(channel));
      if (message && !may_be_sent(*message, worker)) continue;
      transport->send(channel, std::move(bytes));
      ++sent;
    }
  }
  std::printf("%llu messages\n", static_cast<unsigned long long>(sent));
  return 0;
}

int mislead(const std::string& endpoint, uint64_t seed, Time end) {
  Inventor inventor(seed);
  const auto transport = bind_server(endpoint);
  std::printf("%s\n", transport->endpoint().c_str());
  std::fflush(stdout);
  uint64_t sent = 0;
  std::deque<std::pair<Channel, PeerId>> peers;
  while (monotonic_now() < end) {
    transport->wait(std::chrono::milliseconds(1));
    while (const auto received = transport->receive()) {
      const auto message = decode(received->bytes, max_message_bytes(received->channel));
      if (!message) continue;
      inventor.hear(*message);
      peers.emplace_back(received->channel, received->peer);
      if (peers.size() > 16) peers.pop_front();
      if (!message->has_hello()) continue;
      v1::Envelope welcome;
      welcome.mutable_welcome()->set_session(message->hello().session());
      welcome.mutable_welcome()->set_farm(seed);
      welcome.mutable_welcome()->set_heartbeat_ms(100);
      welcome.mutable_welcome()->set_lost_after_ms(2000);
      welcome.mutable_welcome()->set_bulk_endpoint(transport->bulk_endpoint());
      transport->send(Channel::control, received->peer, encode(welcome));
    }
    for (int i = 0; i < 10 && !peers.empty(); ++i) {
      MessageBytes bytes = inventor.bytes();
      const auto& [channel, peer] = peers[inventor.draw(peers.size())];
      const auto message = decode(bytes, max_message_bytes(channel));
      // A worker does what it is told: it ends.
      if (message && (message->has_shutdown() || message->has_reject())) continue;
      transport->send(channel, peer, std::move(bytes));
      ++sent;
    }
  }
  std::printf("%llu messages\n", static_cast<unsigned long long>(sent));
  return 0;
}

}  // namespace

int main(int argc, char** argv) {
  if (argc != 5) return 2;
  const uint64_t seed = std::strtoull(argv[3], nullptr, 10);
  const Time end = monotonic_now() + std::chrono::seconds(std::atoi(argv[4]));
  if (std::strcmp(argv[2], "coordinator") == 0) return mislead(argv[1], seed, end);
  return attack(argv[1], std::strcmp(argv[2], "worker") == 0, seed, end);
}
