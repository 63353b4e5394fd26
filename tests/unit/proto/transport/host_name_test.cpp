// Hosts that are given by name, with name servers that are silent, slow, wrong, or change their
// answer.
#include <arpa/inet.h>
#include <fmt/format.h>
#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <netinet/in.h>
#include <poll.h>
#include <sys/socket.h>
#include <unistd.h>

#include <condition_variable>
#include <cstdio>
#include <functional>
#include <memory>
#include <mutex>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "base/error.h"
#include "proto/transport/address_finder.h"
#include "proto/transport/listening.h"
#include "proto/transport/resolve_host.h"
#include "proto/transport/socket_address.h"
#include "proto/transport/zmq_transport.h"
#include "tests/unit/proto/transport/bytes_of.h"

namespace tessera {
namespace {

using namespace std::chrono_literals;
using ::testing::ElementsAre;
using ::testing::HasSubstr;

/// Name servers that say what the test wants, or nothing until it ends.
class FakeNames {
 public:
  explicit FakeNames(ResolvedHost answer) : state_(std::make_shared<State>()) {
    state_->answer = std::move(answer);
  }
  FakeNames() : state_(std::make_shared<State>()) {}
  ~FakeNames() { say({}); }
  FakeNames(const FakeNames&) = delete;
  FakeNames& operator=(const FakeNames&) = delete;

  /// From now on, and to those who wait.
  void say(ResolvedHost answer) {
    const std::scoped_lock lock(state_->mutex);
    state_->answer = std::move(answer);
    state_->changed.notify_all();
  }
  void fall_silent() {
    const std::scoped_lock lock(state_->mutex);
    state_->answer.reset();
  }
  /// Waits until so many questions were asked in all.
  void wait_for_questions(int count) {
    std::unique_lock lock(state_->mutex);
    state_->changed.wait(lock, [&] { return state_->asked >= count; });
  }
  int asked() {
    const std::scoped_lock lock(state_->mutex);
    return state_->asked;
  }

  ResolveHost resolver() {
    return [state = state_](const std::string& host) {
      EXPECT_EQ(host, "farm.test");
      std::unique_lock lock(state->mutex);
      ++state->asked;
      state->changed.notify_all();
      state->changed.wait(lock, [&] { return state->answer.has_value(); });
      return *state->answer;
    };
  }

 private:
  struct State {
    std::mutex mutex;
    std::condition_variable changed;
    std::optional<ResolvedHost> answer;
    int asked = 0;
  };
  std::shared_ptr<State> state_;
};

/// A port at an address of this machine, on which connections are taken, or made to wait for ever.
class Listener {
 public:
  explicit Listener(const std::string& host, int port = 0, int backlog = 9)
      : file_(socket(AF_INET, SOCK_STREAM | SOCK_CLOEXEC, 0)) {
    const SocketAddress address = *socket_address(host, port);
    const int yes = 1;
    setsockopt(file_, SOL_SOCKET, SO_REUSEADDR, &yes, sizeof yes);
    is_bound_ = bind(file_, address.get(), address.size) == 0 && listen(file_, backlog) == 0;
  }
  ~Listener() { close(file_); }
  Listener(const Listener&) = delete;
  Listener& operator=(const Listener&) = delete;

  bool is_bound() const { return is_bound_; }
  int port() const {
    sockaddr_in address{};
    socklen_t size = sizeof address;
    getsockname(file_, reinterpret_cast<sockaddr*>(&address), &size);
    return ntohs(address.sin_port);
  }

 private:
  int file_;
  bool is_bound_ = false;
};

/// An address whose packets are lost: its queue of connections is full.
class BlackHole {
 public:
  BlackHole(const std::string& host, int port) : listener_(host, port, 0) {
    const SocketAddress address = *socket_address(host, port);
    for (int& filler : fillers_) {
      filler = socket(AF_INET, SOCK_STREAM | SOCK_NONBLOCK | SOCK_CLOEXEC, 0);
      connect(filler, address.get(), address.size);
    }
  }
  ~BlackHole() {
    for (const int filler : fillers_) close(filler);
  }
  bool is_bound() const { return listener_.is_bound(); }

 private:
  Listener listener_;
  int fillers_[4];
};

bool has_ipv6() {
  const int file = socket(AF_INET6, SOCK_STREAM | SOCK_CLOEXEC, 0);
  if (file < 0) return false;
  const SocketAddress address = *socket_address("[::1]", 0);
  const bool bound = bind(file, address.get(), address.size) == 0;
  close(file);
  return bound;
}

/// A finder under a virtual clock.
class AddressFinderTest : public ::testing::Test {
 protected:
  void make(int port) {
    finder_ = std::make_unique<AddressFinder>(
        Endpoint{.tcp = true, .path = {}, .host = "farm.test", .port = port}, names_.resolver(),
        wake_, now_);
  }
  /// Lets it take the news that a thread has for it.
  bool hear(bool connected = false) {
    pollfd item{wake_->descriptor(), POLLIN, 0};
    EXPECT_EQ(poll(&item, 1, -1), 1);
    wake_->clear();
    return finder_->update(connected, now_);
  }
  std::string host() const { return finder_->address() ? finder_->address()->host : ""; }
  std::string trouble() const {
    const auto trouble = finder_->trouble(now_);
    return trouble ? trouble->why : "";
  }

  FakeNames names_;
  std::shared_ptr<WakeUp> wake_ = std::make_shared<WakeUp>();
  Time now_ = 1h;
  std::unique_ptr<AddressFinder> finder_;
};

TEST_F(AddressFinderTest, AnAddressIsNotResolved) {
  for (const char* host : {"127.0.0.1", "[::1]", "10.1.2.3"}) {
    const Endpoint endpoint{.tcp = true, .path = {}, .host = host, .port = 7};
    AddressFinder finder(endpoint, names_.resolver(), wake_, now_);
    ASSERT_TRUE(finder.address());
    EXPECT_EQ(finder.address()->str(), endpoint.str());
    EXPECT_FALSE(finder.update(true, now_));
    EXPECT_FALSE(finder.update(false, now_ + 1s)) << "once the connection is gone";
    EXPECT_FALSE(finder.trouble(now_ + 1h));
  }
  EXPECT_EQ(names_.asked(), 0);
}

TEST_F(AddressFinderTest, ASilentNameServerIsToldAndALateAnswerTaken) {
  make(7);
  EXPECT_FALSE(finder_->address());
  now_ += 1999ms;
  EXPECT_FALSE(finder_->update(false, now_));
  EXPECT_EQ(trouble(), "");
  now_ += 1ms;
  EXPECT_EQ(trouble(), "no name server answers for the host of tcp://farm.test:7");
  now_ += 10s;
  names_.say({{"[fd77::1]"}});
  EXPECT_TRUE(hear());
  EXPECT_EQ(finder_->address()->str(), "tcp://[fd77::1]:7");
  EXPECT_EQ(trouble(), "");
}

TEST_F(AddressFinderTest, ALookupThatHangsDoesNotKeepOthersFromAnAnswer) {
  make(7);
  for (const int questions : {2, 3}) {
    now_ += 20s;
    finder_->update(false, now_);
    names_.wait_for_questions(questions);
  }
  // No more of them: each has a thread.
  for (int i = 0; i < 5; ++i) finder_->update(false, now_ += 20s);
  names_.say({{"127.0.0.1"}});
  EXPECT_TRUE(hear());
  EXPECT_EQ(names_.asked(), 3);
}

TEST_F(AddressFinderTest, TheLastAddressStaysWhileNamesAreNotAnswered) {
  names_.say({{"127.0.0.9"}});
  make(7);
  ASSERT_TRUE(hear());
  finder_->update(true, now_);
  names_.fall_silent();
  now_ += 1h;
  EXPECT_FALSE(finder_->update(true, now_));
  EXPECT_EQ(names_.asked(), 1) << "nobody asks while there is a connection";
  EXPECT_FALSE(finder_->update(false, now_));
  names_.wait_for_questions(2);
  now_ += 2s;
  EXPECT_EQ(host(), "127.0.0.9");
  EXPECT_EQ(trouble(),
            "no name server answers for the host of tcp://farm.test:7; its last address, "
            "127.0.0.9, is tried");
  names_.say({.failure = "Temporary failure"});
  EXPECT_FALSE(hear());
  EXPECT_EQ(host(), "127.0.0.9");
  EXPECT_THAT(trouble(), HasSubstr("Temporary failure; its last address, 127.0.0.9, is tried"));
}

TEST_F(AddressFinderTest, AnUnknownNameMayComeToBeKnownAndBecomeUnknownAgain) {
  names_.say({.is_unknown = true});
  make(7);
  EXPECT_FALSE(hear());
  ASSERT_TRUE(finder_->trouble(now_));
  EXPECT_TRUE(finder_->trouble(now_)->is_unknown_host);
  EXPECT_EQ(trouble(), "the name of the host of tcp://farm.test:7 is unknown");
  names_.say({{"127.0.0.1"}});
  finder_->update(false, now_ += 1s);
  EXPECT_TRUE(hear());
  EXPECT_EQ(trouble(), "");
  names_.say({.is_unknown = true});
  finder_->update(false, now_ += 5s);
  EXPECT_FALSE(hear());
  EXPECT_EQ(host(), "127.0.0.1");
  EXPECT_FALSE(finder_->trouble(now_)->is_unknown_host) << "it was known: that may pass";
}

TEST_F(AddressFinderTest, FollowsANameThatMoves) {
  const Listener there("127.0.0.3");
  ASSERT_TRUE(there.is_bound());
  names_.say({{"127.0.0.2"}});  // where nothing listens
  make(there.port());
  ASSERT_TRUE(hear());
  EXPECT_EQ(host(), "127.0.0.2");
  names_.say({{"127.0.0.3"}});
  EXPECT_FALSE(finder_->update(false, now_ += 999ms));
  finder_->update(false, now_ += 1ms);
  EXPECT_TRUE(hear());
  EXPECT_EQ(host(), "127.0.0.3");
}

TEST_F(AddressFinderTest, AWrongAnswerDoesNotTakeTheLastGoodAddressAway) {
  auto there = std::make_unique<Listener>("127.0.0.3");
  const int port = there->port();
  names_.say({{"127.0.0.3"}});
  make(port);
  ASSERT_TRUE(hear());
  EXPECT_FALSE(finder_->update(true, now_));
  names_.say({{"127.0.0.2", "127.0.0.4"}});
  finder_->update(false, now_);
  EXPECT_FALSE(hear());
  EXPECT_EQ(host(), "127.0.0.3") << "which takes connections";
  there.reset();
  finder_->update(false, now_ += 5s);
  EXPECT_FALSE(hear());
  EXPECT_EQ(host(), "127.0.0.3") << "no better one is known";
  EXPECT_THAT(trouble(), HasSubstr("127.0.0.4: Connection refused"));
  const Listener elsewhere("127.0.0.4", port);
  ASSERT_TRUE(elsewhere.is_bound());
  finder_->update(false, now_ += 5s);
  EXPECT_TRUE(hear());
  EXPECT_EQ(host(), "127.0.0.4") << "it was right";
}

TEST_F(AddressFinderTest, ThatNoAddressTakesAConnectionIsTold) {
  int port = 0;
  {
    const Listener free("127.0.0.3");
    port = free.port();
  }
  names_.say({{"127.0.0.2", "127.0.0.3"}});
  make(port);
  EXPECT_TRUE(hear()) << "one of them, which may come to listen";
  EXPECT_EQ(trouble(), fmt::format("no address of the host of tcp://farm.test:{} takes a "
                                   "connection (127.0.0.2: Connection refused, 127.0.0.3: "
                                   "Connection refused)",
                                   port));
}

TEST(ConnectionRace, TheFirstThatAnswersWins) {
  const Listener there("127.0.0.3");
  const BlackHole hole("127.0.0.2", there.port());
  ASSERT_TRUE(there.is_bound() && hole.is_bound());
  const int port = there.port();
  EXPECT_EQ(race({"127.0.0.3", "127.0.0.2"}, port).winner, 0U);
  EXPECT_EQ(race({"127.0.0.4", "127.0.0.3"}, port).winner, 1U) << "the other one refuses";
  EXPECT_EQ(race({"127.0.0.2", "127.0.0.3"}, port).winner, 1U) << "packets to the other are lost";
  // An address of documentation (RFC 3849), where nothing is: no route, or silence.
  EXPECT_EQ(race({"[2001:db8::77]", "127.0.0.3"}, port).winner, 1U);
  const ConnectionRace lost = race({"127.0.0.4", "127.0.0.5"}, port);
  EXPECT_FALSE(lost.winner);
  EXPECT_THAT(lost.failures, ElementsAre("Connection refused", "Connection refused"));
}

TEST(ResolveHost, KnowsLocalhostWithoutAsking) {
  EXPECT_THAT(resolve_by_system("localhost").addresses, ElementsAre("127.0.0.1", "[::1]"));
}

TEST(ResolveHost, IsWaitedForNoLongerThanTheLimit) {
  FakeNames names;
  EXPECT_EQ(resolve_within(10ms, "farm.test", names.resolver()).failure, "no name server answers");
  names.say({{"127.0.0.1"}});
  EXPECT_THAT(resolve_within(1h, "farm.test", names.resolver()).addresses,
              ElementsAre("127.0.0.1"));
}

// ----------------------------------------------------------------------- clients of the transport

/// The endpoint of a server by the name of its host.
std::string by_name(const std::string& endpoint) {
  return "tcp://farm.test" + endpoint.substr(endpoint.rfind(':'));
}

/// Whether a message of the client comes to the server, by that channel.
bool reaches(ClientTransport& client, ServerTransport& server, Channel channel = Channel::control) {
  client.send(channel, bytes_of("hello"));
  for (int i = 0; i < 5000; ++i) {
    client.wait(2ms);
    server.wait(2ms);
    if (const auto message = server.receive(); message && message->channel == channel) return true;
  }
  return false;
}

TEST(HostName, ReachesAServerByIPv4AndByIPv6) {
  for (const std::string host : {"127.0.0.1", "[::1]"}) {
    if (host == "[::1]" && !has_ipv6()) {
      std::puts("SKIPPED: this machine has no IPv6");
      continue;
    }
    const auto server = bind_server("tcp://" + host + ":*");
    FakeNames names({{host}});
    const auto client = connect_client(by_name(server->endpoint()), {}, names.resolver());
    EXPECT_TRUE(reaches(*client, *server)) << host;
    EXPECT_EQ(client->resolved_endpoint(), server->endpoint());
    client->connect_bulk(server->bulk_endpoint());
    EXPECT_TRUE(reaches(*client, *server, Channel::bulk)) << host;
  }
}

TEST(HostName, OfTwoAddressesTriesBoth) {
  const auto server = bind_server("tcp://127.0.0.1:*");
  FakeNames names({{"[2001:db8::77]", "127.0.0.1"}});
  const auto client = connect_client(by_name(server->endpoint()), {}, names.resolver());
  EXPECT_TRUE(reaches(*client, *server));
}

TEST(HostName, WhatIsSentBeforeTheNameIsKnownIsKept) {
  const auto server = bind_server("tcp://127.0.0.1:*");
  FakeNames names;
  const auto client = connect_client(by_name(server->endpoint()), {}, names.resolver());
  client->send(Channel::control, bytes_of("early"));
  client->wait(1ms);
  EXPECT_FALSE(client->resolved_endpoint());
  names.say({{"127.0.0.1"}});
  std::optional<ReceivedMessage> message;
  for (int i = 0; i < 5000 && !message; ++i) {
    client->wait(2ms);
    server->wait(2ms);
    message = server->receive();
  }
  EXPECT_TRUE(message);
}

TEST(HostName, ASilentNameServerEndsNoLineAndKeepsNobodyFromEnding) {
  const auto server = bind_server("tcp://127.0.0.1:*");
  FakeNames names({{"127.0.0.1"}});
  {
    const auto client = connect_client(by_name(server->endpoint()), {}, names.resolver());
    ASSERT_TRUE(reaches(*client, *server));
    names.fall_silent();
    client->connect_bulk(server->bulk_endpoint());
    EXPECT_TRUE(reaches(*client, *server, Channel::bulk));
    client->reconnect();
    EXPECT_TRUE(reaches(*client, *server)) << "by the address that was good";
    EXPECT_FALSE(client->trouble());
    const auto other = connect_client(by_name(server->endpoint()), {}, names.resolver());
    other->wait(1ms);
    names.wait_for_questions(2);
  }  // else this would wait for ever
}

TEST(HostName, ABulkEndpointIsNeverResolved) {
  const auto server = bind_server("tcp://127.0.0.1:*");
  const auto client = connect_client(server->endpoint());
  client->connect_bulk("tcp://elsewhere.test:7");
  ASSERT_TRUE(client->trouble());
  EXPECT_THAT(client->trouble()->why, HasSubstr("'tcp://elsewhere.test:7'"));
}

TEST(HostName, LocalhostIsBoundAndReached) {
  const auto server = bind_server("tcp://localhost:*");
  EXPECT_TRUE(server->endpoint().starts_with("tcp://127.0.0.1:")) << server->endpoint();
  const std::string port = server->endpoint().substr(server->endpoint().rfind(':'));
  const auto client = connect_client("tcp://localhost" + port);
  EXPECT_TRUE(reaches(*client, *server));
}

TEST(HostName, AllAddressesAreThoseOfBothFamilies) {
  const auto server = bind_server("tcp://*:*", {.keys = {}, .allowed = {}, .insecure = true});
  const std::string port = server->endpoint().substr(server->endpoint().rfind(':'));
  for (const std::string host : {"127.0.0.1", "[::1]"}) {
    if (host == "[::1]" && !has_ipv6()) continue;
    const auto client = connect_client("tcp://" + host + port);
    EXPECT_TRUE(reaches(*client, *server)) << host;
  }
}

}  // namespace
}  // namespace tessera
