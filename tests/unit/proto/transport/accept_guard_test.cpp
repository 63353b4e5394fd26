// What becomes of connections that are not let in, over real sockets of this machine.
#include <arpa/inet.h>
#include <dirent.h>
#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <netinet/in.h>
#include <poll.h>
#include <spdlog/spdlog.h>
#include <sys/resource.h>
#include <sys/socket.h>
#include <sys/un.h>
#include <unistd.h>

#include <algorithm>
#include <chrono>
#include <filesystem>
#include <functional>
#include <iterator>
#include <map>
#include <memory>
#include <string>
#include <vector>

#include "base/owned_descriptor.h"
#include "proto/transport/endpoint.h"
#include "proto/transport/zmq_transport.h"
#include "tests/temporary_folder.h"
#include "tests/unit/proto/transport/bytes_of.h"

namespace tessera {
namespace {

using std::chrono::milliseconds;

size_t open_descriptors() {
  return static_cast<size_t>(
      std::distance(std::filesystem::directory_iterator("/proc/self/fd"), {}));
}

/// While it lives, this process may have that many descriptors.
class Limit {
 public:
  explicit Limit(rlim_t count) {
    getrlimit(RLIMIT_NOFILE, &before_);
    set({count, before_.rlim_max});
  }
  ~Limit() { set(before_); }
  Limit(const Limit&) = delete;
  Limit& operator=(const Limit&) = delete;

 private:
  static void set(const rlimit& limit) { ASSERT_EQ(setrlimit(RLIMIT_NOFILE, &limit), 0); }
  rlimit before_{};
};

/// Connections that say nothing.
class Silent {
 public:
  void connect(uint16_t port, int host = 1) {
    sockaddr_in from{}, to{};
    from.sin_family = to.sin_family = AF_INET;
    from.sin_addr.s_addr = htonl(INADDR_LOOPBACK - 1 + static_cast<uint32_t>(host));
    to.sin_addr.s_addr = htonl(INADDR_LOOPBACK);
    to.sin_port = htons(port);
    OwnedDescriptor one(socket(AF_INET, SOCK_STREAM | SOCK_CLOEXEC, 0));
    ASSERT_EQ(bind(one.get(), reinterpret_cast<sockaddr*>(&from), sizeof from), 0);
    ASSERT_EQ(::connect(one.get(), reinterpret_cast<sockaddr*>(&to), sizeof to), 0);
    all_.push_back(std::move(one));
  }
  void connect(const std::string& path) {
    sockaddr_un to{};
    to.sun_family = AF_UNIX;
    path.copy(to.sun_path, sizeof to.sun_path - 1);
    OwnedDescriptor one(socket(AF_UNIX, SOCK_STREAM | SOCK_CLOEXEC, 0));
    ASSERT_EQ(::connect(one.get(), reinterpret_cast<sockaddr*>(&to), sizeof to), 0);
    all_.push_back(std::move(one));
  }
  size_t size() const { return all_.size(); }
  size_t open_ones() const {
    size_t count = 0;
    for (size_t i = 0; i < all_.size(); ++i) count += is_open(i);
    return count;
  }
  /// Whether the server has not ended it.
  bool is_open(size_t i) const {
    pollfd look{all_[i].get(), POLLRDHUP, 0};
    return poll(&look, 1, 0) == 0;
  }

 private:
  std::vector<OwnedDescriptor> all_;
};

/// A server that was given few descriptors, so that a quarter of them may be connections that wait.
class AcceptGuardTest : public ::testing::Test {
 protected:
  static constexpr rlim_t kDescriptors = 160;
  static constexpr size_t kMostWaiting = kDescriptors / 4;

  void SetUp() override { spdlog::set_level(spdlog::level::off); }
  void TearDown() override { spdlog::set_level(spdlog::level::info); }

  void serve(const std::string& endpoint = "tcp://127.0.0.1:*", bool has_keys = true,
             rlim_t descriptors = kDescriptors) {
    const Limit limit(descriptors);
    ServerSecurity security;
    if (has_keys) {
      security.keys = server_keys_;
      security.allowed =
          AllowList::parse(AllowList::line(worker_.public_key, {Role::worker, "node"}), "list");
    }
    server_ = bind_server(endpoint, std::move(security));
    at_start_ = open_descriptors();
  }
  std::unique_ptr<ClientTransport> client(bool has_keys = true) {
    auto result = connect_client(
        server_->endpoint(),
        has_keys ? std::optional(ClientKeys{worker_, server_keys_.public_key}) : std::nullopt);
    result->connect_bulk(server_->bulk_endpoint());
    return result;
  }
  uint16_t port(Channel channel = Channel::control) const {
    const std::string text =
        channel == Channel::control ? server_->endpoint() : server_->bulk_endpoint();
    return static_cast<uint16_t>(std::stoi(text.substr(text.rfind(':') + 1)));
  }
  /// Descriptors of the server's connections, where there are none but those.
  size_t accepted(const Silent& silent) const {
    return open_descriptors() - at_start_ - silent.size();
  }
  /// Lets the server and the clients work until that is so; less long than the 5 s after which a
  /// connection that says nothing is ended in any case.
  bool wait_until(const std::function<bool()>& is_so,
                  const std::vector<std::unique_ptr<ClientTransport>>& clients = {}) {
    const auto end = std::chrono::steady_clock::now() + milliseconds(3500);
    while (!is_so()) {
      if (std::chrono::steady_clock::now() > end) return false;
      server_->wait(milliseconds(2));
      for (const auto& each : clients) each->wait(milliseconds(0));
      while (const auto message = server_->receive()) {
        peers_[{message->channel, std::string(text_of(*message))}].push_back(message->peer);
      }
    }
    return true;
  }
  static std::string_view text_of(const ReceivedMessage& message) {
    return {reinterpret_cast<const char*>(message.bytes.data()), message.bytes.size()};
  }
  /// Sends by both channels and waits until all has come.
  bool greet(const std::vector<std::unique_ptr<ClientTransport>>& clients) {
    peers_.clear();
    for (size_t i = 0; i < clients.size(); ++i) {
      for (const Channel channel : {Channel::control, Channel::bulk}) {
        clients[i]->send(channel, bytes_of(std::to_string(i)));
      }
    }
    return wait_until([&] { return peers_.size() >= 2 * clients.size(); }, clients);
  }

  KeyPair server_keys_ = make_key_pair(), worker_ = make_key_pair();
  std::unique_ptr<ServerTransport> server_;
  size_t at_start_ = 0;
  /// Of each client, by the text that it sent: its connections, one a message.
  std::map<std::pair<Channel, std::string>, std::vector<PeerId>> peers_;
};

TEST_F(AcceptGuardTest, OfManyThatSayNothingTheOldestAreEnded) {
  for (const bool has_keys : {true, false}) {
    serve("tcp://127.0.0.1:*", has_keys);
    Silent silent;
    for (size_t i = 0; i < 8 * kMostWaiting; ++i) {
      silent.connect(port(i % 2 ? Channel::control : Channel::bulk));
    }
    EXPECT_TRUE(wait_until([&] { return silent.open_ones() <= kMostWaiting; }));
    EXPECT_TRUE(wait_until([&] { return silent.open_ones() <= kMostWaiting; }));
    EXPECT_TRUE(wait_until([&] { return accepted(silent) <= kMostWaiting; }));
    EXPECT_FALSE(silent.is_open(0));
    EXPECT_GE(accepted(silent), kMostWaiting / 2);
    server_.reset();
  }
}

TEST_F(AcceptGuardTest, OfManyAddressesTheOneWithTheMostIsEnded) {
  serve();
  Silent silent;
  silent.connect(port(), 100);
  for (size_t i = 0; i < 8 * kMostWaiting; ++i) {
    silent.connect(port(), 1 + static_cast<int>(i % 3));
  }
  EXPECT_TRUE(wait_until([&] { return silent.open_ones() <= kMostWaiting; }));
  EXPECT_TRUE(wait_until([&] { return accepted(silent) <= kMostWaiting; }));
  // The first of all is of an address that has no other.
  EXPECT_TRUE(silent.is_open(0));
  EXPECT_FALSE(silent.is_open(1));
  EXPECT_TRUE(silent.is_open(silent.size() - 1));
}

TEST_F(AcceptGuardTest, OneAddressHasAQuarterOfThePlaces) {
  constexpr size_t kOfAnAddress = 256;
  const Limit enough(4096);  // a quarter of which may wait
  serve("tcp://127.0.0.1:*", true, 4096);
  Silent silent;
  for (int i = 0; i < 100; ++i) silent.connect(port(), 2);
  const size_t others = silent.size();
  for (size_t i = 0; i < 2 * kOfAnAddress; ++i) silent.connect(port());
  EXPECT_TRUE(wait_until([&] { return silent.open_ones() <= others + kOfAnAddress; }));
  EXPECT_EQ(silent.open_ones(), others + kOfAnAddress);
  EXPECT_FALSE(silent.is_open(others));
  EXPECT_TRUE(silent.is_open(silent.size() - 1));
}

TEST_F(AcceptGuardTest, WhoHasAKeyComesInDuringAFloodAndStays) {
  serve();
  std::vector<std::unique_ptr<ClientTransport>> clients;
  clients.push_back(client());
  ASSERT_TRUE(greet(clients));
  const auto first = peers_;
  Silent silent;
  const auto flood = [&] {
    for (size_t i = 0; i < 2 * kMostWaiting; ++i) {
      silent.connect(port(i % 2 ? Channel::control : Channel::bulk), 1 + static_cast<int>(i % 5));
    }
  };
  flood();
  clients.push_back(client());
  const size_t before = silent.size();
  // Another one comes in while others come without an end.
  for (const Channel channel : {Channel::control, Channel::bulk}) {
    clients[1]->send(channel, bytes_of("1"));
  }
  EXPECT_TRUE(wait_until(
      [&] {
        if (silent.size() < 1000) silent.connect(port());
        return peers_.contains({Channel::control, "1"}) && peers_.contains({Channel::bulk, "1"});
      },
      clients));
  EXPECT_GT(silent.size(), before);
  const auto second = peers_;
  flood();
  EXPECT_TRUE(wait_until([&] { return silent.open_ones() <= kMostWaiting; }));
  // Both are still there by the same connections.
  ASSERT_TRUE(greet(clients));
  for (const Channel channel : {Channel::control, Channel::bulk}) {
    EXPECT_EQ((peers_[{channel, "0"}]), first.at({channel, "0"}));
    EXPECT_EQ(peers_.at({channel, "1"}).front(), second.at({channel, "1"}).front());
  }
}

TEST_F(AcceptGuardTest, HonestOnesThatComeAtOnceAllGetInAndStay) {
  serve();
  std::vector<std::unique_ptr<ClientTransport>> clients;
  for (size_t i = 0; i < 2 * kMostWaiting; ++i) clients.push_back(client());
  bool all = false;
  for (int i = 0; i < 10 && !all; ++i) all = greet(clients);  // some are ended, and come again
  ASSERT_TRUE(all);
  const auto first = peers_;
  Silent silent;
  for (size_t i = 0; i < 8 * kMostWaiting; ++i) silent.connect(port(), 7);
  EXPECT_TRUE(wait_until([&] { return silent.open_ones() <= kMostWaiting; }));
  ASSERT_TRUE(greet(clients));
  for (const auto& [from, peers] : peers_) EXPECT_EQ(peers.back(), first.at(from).back());
}

TEST_F(AcceptGuardTest, LocalSocketsAreBoundedInNumber) {
  const TemporaryFolder folder;
  const std::string path = folder / "farm";
  serve("ipc://" + path, false);
  Silent silent;
  for (size_t i = 0; i < 4 * kMostWaiting; ++i) silent.connect(path);
  EXPECT_TRUE(wait_until([&] { return silent.open_ones() <= kMostWaiting; }));
  EXPECT_TRUE(wait_until([&] { return accepted(silent) <= kMostWaiting; }));
  EXPECT_FALSE(silent.is_open(0));
  EXPECT_TRUE(silent.is_open(silent.size() - 1));
}

}  // namespace
}  // namespace tessera
