// Who is let in by a server with keys, over real sockets of this machine.
#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <netinet/in.h>
#include <spdlog/spdlog.h>
#include <sys/socket.h>
#include <unistd.h>

#include <algorithm>
#include <memory>
#include <span>
#include <string>
#include <vector>

#include "base/error.h"
#include "proto/transport/endpoint.h"
#include "proto/transport/zmq_transport.h"
#include "tests/unit/proto/transport/bytes_of.h"

namespace tessera {
namespace {

using std::chrono::milliseconds;

/// A server that lets in one worker and one viewer, and those who come to it.
class Security : public ::testing::Test {
 protected:
  void SetUp() override { spdlog::set_level(spdlog::level::off); }
  void TearDown() override { spdlog::set_level(spdlog::level::info); }

  AllowList list(bool with_worker = true) const {
    std::string text = AllowList::line(viewer_.public_key, {Role::viewer, "wall"});
    if (with_worker) text += AllowList::line(worker_.public_key, {Role::worker, "node"});
    return AllowList::parse(text, "list");
  }
  std::unique_ptr<ClientTransport> client(const std::optional<KeyPair>& own, const Key& server) {
    auto result = connect_client(server_->endpoint(),
                                 own ? std::optional(ClientKeys{*own, server}) : std::nullopt);
    result->connect_bulk(server_->bulk_endpoint());
    for (const Channel channel : {Channel::control, Channel::bulk}) {
      result->send(channel, bytes_of("let me in"));
    }
    return result;
  }
  std::unique_ptr<ClientTransport> client(const KeyPair& own) {
    return client(own, server_keys_.public_key);
  }
  /// What comes until there are `wanted`, or nothing more comes.
  std::vector<ReceivedMessage> receive(ClientTransport* client, size_t wanted, int rounds = 400) {
    std::vector<ReceivedMessage> received;
    for (int i = 0; i < rounds && received.size() < wanted; ++i) {
      server_->wait(milliseconds(2));
      if (client) client->wait(milliseconds(1));
      while (auto message = server_->receive()) received.push_back(std::move(*message));
    }
    return received;
  }
  void expect_stays_out(ClientTransport& client, int rounds = 60) {
    EXPECT_TRUE(receive(&client, 1, rounds).empty());
  }
  /// Until it is told that it is not let in, at whichever attempt: a server may close the
  /// connection before the client has read why.
  void expect_refused(ClientTransport& client) {
    while (!client.trouble() || !client.trouble()->refused) expect_stays_out(client, 10);
  }
  /// A plain TCP connection to control or bulk that has sent `bytes`.
  int plain(bool bulk, std::string_view bytes) const {
    const std::string endpoint = server_->endpoint(), at_bulk = server_->bulk_endpoint();
    const std::string text = bulk ? at_bulk : endpoint;
    sockaddr_in address{};
    address.sin_family = AF_INET;
    address.sin_addr.s_addr = htonl(INADDR_LOOPBACK);
    address.sin_port = htons(static_cast<uint16_t>(std::stoi(text.substr(text.rfind(':') + 1))));
    const int descriptor = socket(AF_INET, SOCK_STREAM | SOCK_CLOEXEC, 0);
    EXPECT_EQ(::connect(descriptor, reinterpret_cast<sockaddr*>(&address), sizeof address), 0);
    EXPECT_EQ(write(descriptor, bytes.data(), bytes.size()), static_cast<ssize_t>(bytes.size()));
    return descriptor;
  }

  KeyPair server_keys_ = make_key_pair(), worker_ = make_key_pair(), viewer_ = make_key_pair();
  std::unique_ptr<ServerTransport> server_ =
      bind_server("tcp://127.0.0.1:*", {.keys = server_keys_, .allowed = list()});
};

TEST_F(Security, WhoIsOnTheListIsLetInByBothChannelsAndKnown) {
  const auto worker = client(worker_);
  const auto received = receive(worker.get(), 2);
  ASSERT_EQ(received.size(), 2u);
  EXPECT_NE(received[0].channel, received[1].channel);
  for (const ReceivedMessage& message : received) {
    EXPECT_EQ(message.sender.role, Role::worker);
    EXPECT_EQ(message.sender.name, "node");
    EXPECT_EQ(server_->send(message.channel, message.peer, bytes_of("welcome")), SendResult::sent);
  }
  int answers = 0;
  for (int i = 0; i < 200 && answers < 2; ++i) {
    worker->wait(milliseconds(5));
    while (worker->receive()) ++answers;
  }
  EXPECT_EQ(answers, 2);
  EXPECT_FALSE(worker->trouble());
  const auto viewer = client(viewer_);
  const auto from_viewer = receive(viewer.get(), 1);
  ASSERT_FALSE(from_viewer.empty());
  EXPECT_EQ(from_viewer[0].sender.role, Role::viewer);
}

TEST_F(Security, AKeyThatIsNotListedIsRefusedAndToldSo) {
  const auto stranger = client(make_key_pair());
  expect_stays_out(*stranger);
  expect_refused(*stranger);
}

TEST_F(Security, NobodyComesInWithoutAKeyOrForAnotherServer) {
  const auto nobody = client(std::nullopt, {});
  expect_stays_out(*nobody);
  expect_refused(*nobody);
  // A listed key that takes this server for another one.
  expect_stays_out(*client(worker_, make_key_pair().public_key));
  // One who says that he has the public key of another, without the secret one.
  KeyPair thief = make_key_pair();
  thief.public_key = worker_.public_key;
  expect_stays_out(*client(thief));
}

TEST_F(Security, AClientWithKeysTalksToNoServerWithout) {
  server_ = bind_server("tcp://127.0.0.1:*");
  const auto worker = client(worker_);
  expect_stays_out(*worker);
  expect_refused(*worker);
}

TEST_F(Security, AKeyTakenOffTheListIsShutOutAtOnce) {
  const auto worker = client(worker_), viewer = client(viewer_);
  PeerId gone;
  for (const auto& message : receive(worker.get(), 2)) {
    if (message.channel == Channel::control) gone = message.peer;
  }
  const auto seen = receive(viewer.get(), 2);
  ASSERT_EQ(seen.size(), 2u);
  EXPECT_THAT(server_->set_allowed(list(false)), ::testing::ElementsAre(gone));
  EXPECT_EQ(server_->send(Channel::control, gone, bytes_of("secret")), SendResult::gone);
  worker->send(Channel::control, bytes_of("still here"));
  worker->send(Channel::bulk, bytes_of("still here"));
  expect_stays_out(*worker, 200);
  EXPECT_FALSE(worker->receive());
  // Its connection was ended, and no other is let in.
  expect_refused(*worker);
  // The other one stands as it was.
  viewer->send(Channel::control, bytes_of("and I"));
  const auto received = receive(viewer.get(), 1);
  ASSERT_EQ(received.size(), 1u);
  EXPECT_EQ(received[0].sender.name, "wall");
  // Listed again, it comes in again: bulk by itself, control when it is asked to.
  server_->set_allowed(list());
  worker->send(Channel::bulk, bytes_of("back"));
  const auto back = receive(worker.get(), 1, 2000);
  EXPECT_FALSE(back.empty());  // that, and what was kept of before
  for (const ReceivedMessage& message : back) EXPECT_EQ(message.channel, Channel::bulk);
  worker->reconnect();
  worker->send(Channel::control, bytes_of("back"));
  EXPECT_FALSE(receive(worker.get(), 1).empty());
}

TEST_F(Security, WhoseTimeIsOverIsLetInNoMore) {
  const auto lasts_until = [&](WallTime until) {
    return AllowList::parse(
        AllowList::line(
            worker_.public_key,
            {.role = Role::enrol, .name = "token", .grants = Role::worker, .until = until}),
        "list");
  };
  server_->set_allowed(lasts_until(wall_clock_now() + std::chrono::hours(1)));
  const auto lives = client(worker_);
  const auto received = receive(lives.get(), 2);
  const auto control = std::ranges::find(received, Channel::control, &ReceivedMessage::channel);
  ASSERT_NE(control, received.end());
  EXPECT_EQ(control->sender.role, Role::enrol);
  EXPECT_EQ(server_->address(control->peer), "127.0.0.1");
  server_->set_allowed(lasts_until(wall_clock_now() - std::chrono::seconds(1)));
  lives->send(Channel::control, bytes_of("still here"));
  expect_stays_out(*lives, 200);
  const auto late = client(worker_);
  expect_refused(*late);
}

TEST_F(Security, ScannersAndHalfOpenHandshakesReachNothing) {
  using namespace std::string_literals;
  const std::string greeting =
      "\xff\0\0\0\0\0\0\0\x01\x7f\x03\0CURVE\0\0\0\0\0\0\0\0\0\0\0\0\0\0\0\0"s +
      std::string(32, '\0');
  const std::string null_greeting = "\xff\0\0\0\0\0\0\0\x01\x7f\x03\0NULL"s + std::string(48, '\0');
  const std::string old = "\x01\0\x06\0hello"s;  // ZMTP 1.0
  const std::string hello = greeting + "\x04\xc8\x05HELLO\x01\0"s + std::string(192, 'x');
  const std::string huge = greeting + "\x02\x7f\xff\xff\xff\xff\xff\xff\xff"s;
  std::vector<int> open;
  for (const bool bulk : {false, true}) {
    for (const auto& bytes :
         {""s, "GET / HTTP/1.1\r\nHost: x\r\n\r\n"s, greeting, null_greeting, old, hello, huge,
          greeting + null_greeting, std::string(100'000, '\xff'), std::string(100'000, 'a')}) {
      open.push_back(plain(bulk, bytes));
    }
    for (int i = 0; i < 100; ++i) open.push_back(plain(bulk, i % 2 ? greeting : ""));
  }
  EXPECT_TRUE(receive(nullptr, 1, 50).empty());
  // Beside them, who has a key comes in.
  const auto worker = client(worker_);
  const auto received = receive(worker.get(), 2);
  EXPECT_EQ(received.size(), 2u);
  for (const ReceivedMessage& message : received) EXPECT_EQ(message.sender.name, "node");
  for (const int descriptor : open) close(descriptor);
}

TEST_F(Security, OnlyWithKeysOrOnPurposeCanOthersReachIt) {
  try {
    bind_server("tcp://0.0.0.0:*");
    ADD_FAILURE();
  } catch (const Error& error) {
    EXPECT_EQ(error.code(), ExitCode::bad_usage);
    EXPECT_THAT(error.what(), ::testing::HasSubstr("expected keys"));
  }
  EXPECT_NO_THROW(bind_server("tcp://0.0.0.0:*", {.keys = server_keys_, .allowed = {}}));
  EXPECT_NO_THROW(bind_server("tcp://0.0.0.0:*", {.keys = {}, .allowed = {}, .insecure = true}));
}

}  // namespace
}  // namespace tessera
