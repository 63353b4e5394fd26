// What both transports promise.
#include "proto/transport/transport.h"

#include <fmt/format.h>
#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <netinet/in.h>
#include <sys/socket.h>
#include <sys/un.h>
#include <unistd.h>

#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <map>
#include <random>
#include <span>
#include <thread>

#include "base/error.h"
#include "proto/transport/endpoint.h"
#include "proto/transport/memory_transport.h"
#include "proto/transport/zmq_transport.h"
#include "tests/temporary_folder.h"
#include "tests/unit/proto/transport/bytes_of.h"

namespace tessera {
namespace {

using std::chrono::milliseconds;

std::string text_of(const ReceivedMessage& message) {
  return {reinterpret_cast<const char*>(message.bytes.data()), message.bytes.size()};
}

/// The next message at the server, while the client does its part.
std::optional<ReceivedMessage> next(ServerTransport& server, ClientTransport& client) {
  for (int i = 0; i < 1000; ++i) {
    if (auto message = server.receive()) return message;
    client.wait(milliseconds(2));
    server.wait(milliseconds(2));
  }
  return std::nullopt;
}

std::optional<ReceivedMessage> next(ClientTransport& client) {
  for (int i = 0; i < 100; ++i) {
    if (auto message = client.receive()) return message;
    client.wait(milliseconds(50));
  }
  return std::nullopt;
}

void converse(ServerTransport& server, ClientTransport& one, ClientTransport& two) {
  for (const Channel channel : {Channel::control, Channel::bulk}) {
    PeerId peers[2];
    ClientTransport* clients[2] = {&one, &two};
    for (int i = 0; i < 2; ++i) {
      clients[i]->connect_bulk(server.bulk_endpoint());
      clients[i]->send(channel, bytes_of("question"));
      const auto asked = next(server, *clients[i]);
      ASSERT_TRUE(asked);
      EXPECT_EQ(asked->channel, channel);
      EXPECT_EQ(text_of(*asked), "question");
      peers[i] = asked->peer;
    }
    EXPECT_NE(peers[0], peers[1]);
    EXPECT_EQ(server.send(channel, peers[1], bytes_of("answer")), SendResult::sent);
    const auto answer = next(two);
    ASSERT_TRUE(answer);
    EXPECT_EQ(answer->channel, channel);
    EXPECT_EQ(text_of(*answer), "answer");
    EXPECT_FALSE(one.receive());
  }
  EXPECT_EQ(server.send(Channel::control, "nobody", bytes_of("x")), SendResult::gone);
}

TEST(MemoryTransport, CarriesBothChannelsBothWays) {
  MemoryNetwork network;
  const auto server = network.server();
  const auto one = network.client(), two = network.client();
  converse(*server, *one, *two);
}

TEST(ZmqTransport, CarriesBothChannelsBothWays) {
  const auto server = bind_server("tcp://127.0.0.1:*");
  const auto one = connect_client(server->endpoint()), two = connect_client(server->endpoint());
  converse(*server, *one, *two);
}

TEST(ZmqTransport, OneServerMayHaveSeveralEndpoints) {
  const TemporaryFolder folder;
  const auto server = bind_servers(
      {{.endpoint = "ipc://" + (folder / "socket")}, {.endpoint = "tcp://127.0.0.1:*"}});
  const auto endpoints = server->endpoints();
  ASSERT_EQ(endpoints.size(), 2U);
  EXPECT_EQ(endpoints[0], server->endpoint());
  const auto near = connect_client(endpoints[0]), far = connect_client(endpoints[1]);
  near->send(Channel::control, bytes_of("near"));
  far->send(Channel::control, bytes_of("far"));
  std::map<std::string, PeerId> peers;
  for (int i = 0; i < 500 && peers.size() < 2; ++i) {
    for (const auto& client : {near.get(), far.get()}) client->wait(milliseconds(2));
    server->wait(milliseconds(5));
    while (auto message = server->receive()) peers[text_of(*message)] = message->peer;
  }
  ASSERT_EQ(peers.size(), 2U);
  EXPECT_FALSE(server->comes_by_network(peers["near"]));
  EXPECT_TRUE(server->comes_by_network(peers["far"]));
  EXPECT_EQ(server->bulk_endpoint_for(peers["near"]), endpoints[0] + ".bulk");
  EXPECT_THAT(server->bulk_endpoint_for(peers["far"]), testing::StartsWith("tcp://:"));
  // Answers find their way, also by the other channel.
  near->connect_bulk(server->bulk_endpoint_for(peers["near"]));
  far->connect_bulk(server->bulk_endpoint_for(peers["far"]));
  EXPECT_EQ(server->send(Channel::control, peers["near"], bytes_of("to near")), SendResult::sent);
  EXPECT_EQ(server->send(Channel::control, peers["far"], bytes_of("to far")), SendResult::sent);
  for (const auto& [client, text] : {std::pair{near.get(), "to near"}, {far.get(), "to far"}}) {
    std::optional<ReceivedMessage> answer;
    for (int i = 0; i < 500 && !answer; ++i) {
      client->wait(milliseconds(5));
      answer = client->receive();
    }
    ASSERT_TRUE(answer);
    EXPECT_EQ(text_of(*answer), text);
  }
}

/// An address that nobody serves. Below the ports that connections are given, which would keep a
/// server from it for a minute after their end.
std::string free_endpoint() {
  std::random_device random;
  while (true) {
    const std::string endpoint = fmt::format("tcp://127.0.0.1:{}", 20000 + 2 * (random() % 6000));
    try {
      return bind_server(endpoint)->endpoint();
    } catch (const Error&) {  // it is taken
    }
  }
}

TEST(ZmqTransport, KeepsWhatIsSentBeforeTheServerIsThere) {
  const std::string endpoint = free_endpoint();
  const auto client = connect_client(endpoint);
  client->send(Channel::control, bytes_of("early"));
  const auto server = bind_server(endpoint);
  std::optional<ReceivedMessage> message;
  for (int i = 0; i < 500 && !message; ++i) {
    client->wait(milliseconds(5));
    server->wait(milliseconds(5));
    message = server->receive();
  }
  ASSERT_TRUE(message);
  EXPECT_EQ(text_of(*message), "early");
}

TEST(ZmqTransport, KeepsNoMoreThanItsBound) {
  const std::string endpoint = free_endpoint();
  const auto client = connect_client(endpoint);
  for (int i = 0; i < 3000; ++i) client->send(Channel::control, bytes_of("early"));
  const auto server = bind_server(endpoint);
  int count = 0, silent = 0;
  while (silent < 40) {
    client->wait(milliseconds(5));
    server->wait(milliseconds(5));
    const int before = count;
    while (server->receive()) ++count;
    silent = count > 0 && count == before ? silent + 1 : 0;
  }
  EXPECT_EQ(count, 1024);
}

TEST(ZmqTransport, ADestroyedClientIsGone) {
  const auto server = bind_server("tcp://127.0.0.1:*");
  PeerId peer;
  {
    const auto client = connect_client(server->endpoint());
    client->send(Channel::control, bytes_of("hello"));
    const auto message = next(*server, *client);
    ASSERT_TRUE(message);
    peer = message->peer;
  }
  SendResult result = SendResult::sent;
  for (int i = 0; i < 200 && result != SendResult::gone; ++i) {
    server->wait(milliseconds(5));
    result = server->send(Channel::control, peer, bytes_of("x"));
  }
  EXPECT_EQ(result, SendResult::gone);
}

TEST(ZmqTransport, ReconnectingMakesANewPeer) {
  const auto server = bind_server("tcp://127.0.0.1:*");
  const auto client = connect_client(server->endpoint());
  client->send(Channel::control, bytes_of("one"));
  const auto first = next(*server, *client);
  client->reconnect();
  client->send(Channel::control, bytes_of("two"));
  const auto second = next(*server, *client);
  ASSERT_TRUE(first && second);
  EXPECT_EQ(text_of(*second), "two");
  EXPECT_NE(first->peer, second->peer);
}

// Whatever the I/O thread was about to tell of the connection that is given up.
TEST(ZmqTransport, ReconnectsAtAnyMomentOfAHandshake) {
  const auto server = bind_server("tcp://127.0.0.1:*");
  const auto client = connect_client(server->endpoint());
  for (int i = 0; i < 250; ++i) {
    std::this_thread::sleep_for(std::chrono::microseconds(i));
    client->reconnect();
  }
  client->send(Channel::control, bytes_of("still here"));
  const auto asked = next(*server, *client);
  ASSERT_TRUE(asked);
  EXPECT_EQ(text_of(*asked), "still here");
}

TEST(ZmqTransport, ABulkEndpointThatIsNoneEndsNobody) {
  const auto server = bind_server("tcp://127.0.0.1:*");
  const auto client = connect_client(server->endpoint());
  for (const std::string wrong : {"vm", "tcp://127.0.0.1:99999", "ipc://"}) {
    EXPECT_NO_THROW(client->connect_bulk(wrong));
    client->send(Channel::bulk, bytes_of("question"));
    client->wait(milliseconds(1));
    ASSERT_TRUE(client->trouble()) << wrong;
    EXPECT_THAT(client->trouble()->why, ::testing::HasSubstr("'" + wrong + "'"));
  }
  client->connect_bulk(server->bulk_endpoint());
  EXPECT_FALSE(client->trouble());
  const auto asked = next(*server, *client);
  ASSERT_TRUE(asked);
  EXPECT_EQ(asked->channel, Channel::bulk);
}

TEST(ZmqTransport, AMessageThatIsTooLongIsNotTaken) {
  const auto server = bind_server("tcp://127.0.0.1:*");
  const auto client = connect_client(server->endpoint());
  client->send(Channel::control, MessageBytes(max_message_bytes(Channel::control)));
  ASSERT_TRUE(next(*server, *client));
  client->send(Channel::control, MessageBytes(max_message_bytes(Channel::control) + 1));
  for (int i = 0; i < 50; ++i) {
    client->wait(milliseconds(1));
    server->wait(milliseconds(1));
    EXPECT_FALSE(server->receive());
  }
}

TEST(ZmqTransport, AnEndpointInUseIsNamed) {
  const auto server = bind_server("tcp://127.0.0.1:*");
  try {
    bind_server(server->endpoint());
    ADD_FAILURE();
  } catch (const Error& error) {
    EXPECT_EQ(error.code(), ExitCode::try_again);
    EXPECT_THAT(error.what(), ::testing::HasSubstr(server->endpoint()));
    EXPECT_THAT(error.what(), ::testing::HasSubstr("in use"));
  }
}

TEST(ZmqTransport, TakesNoPathButOfASocketThatNobodyServes) {
  namespace fs = std::filesystem;
  const TemporaryFolder folder;
  const std::string path = folder / "socket", endpoint = "ipc://" + path;
  const auto expect_refused = [&](const char* why, ExitCode code) {
    try {
      bind_server(endpoint);
      ADD_FAILURE() << why;
    } catch (const Error& error) {
      EXPECT_EQ(error.code(), code);
      EXPECT_THAT(error.what(), ::testing::HasSubstr(why));
    }
  };
  for (const char* suffix : {"", ".bulk"}) {
    std::ofstream(path + suffix) << "precious";
    expect_refused("no socket", ExitCode::bad_usage);
    EXPECT_EQ(fs::file_size(path + suffix), 8u);
    fs::remove(path + suffix);
    EXPECT_TRUE(fs::is_empty(folder.path()));
  }
  {
    const auto server = bind_server(endpoint);
    expect_refused("in use", ExitCode::try_again);
    EXPECT_TRUE(fs::is_socket(path));
    EXPECT_TRUE(fs::is_socket(path + ".bulk"));
  }
  EXPECT_TRUE(fs::is_empty(folder.path()));
  // One that was left by a process that was killed.
  sockaddr_un address{};
  address.sun_family = AF_UNIX;
  path.copy(address.sun_path, sizeof address.sun_path - 1);
  const int left = socket(AF_UNIX, SOCK_STREAM, 0);
  ASSERT_EQ(bind(left, reinterpret_cast<const sockaddr*>(&address), sizeof address), 0);
  close(left);
  EXPECT_NO_THROW(bind_server(endpoint));
  EXPECT_TRUE(fs::is_empty(folder.path()));
}

/// A frame of ZMTP 3.1 (RFC 37) with fewer than 256 bytes.
std::string zmtp_frame(char flags, std::string_view body) {
  return std::string{flags, static_cast<char>(body.size())} + std::string(body);
}

/// A connection that shakes hands as a DEALER does, sends `bytes`, and is reset.
void send_and_reset(const std::string& endpoint, std::string_view bytes) {
  std::string hello("\xff\0\0\0\0\0\0\0\x01\x7f\x03\x01NULL", 16);
  hello.resize(64);
  hello += zmtp_frame(4, std::string_view("\5READY\13Socket-Type\0\0\0\6DEALER", 28));
  sockaddr_in address{};
  address.sin_family = AF_INET;
  address.sin_addr.s_addr = htonl(INADDR_LOOPBACK);
  address.sin_port = htons(static_cast<uint16_t>(parse_endpoint(endpoint).port));
  const int descriptor = socket(AF_INET, SOCK_STREAM | SOCK_CLOEXEC, 0);
  ASSERT_EQ(connect(descriptor, reinterpret_cast<sockaddr*>(&address), sizeof address), 0);
  ASSERT_EQ(write(descriptor, hello.data(), hello.size()), static_cast<ssize_t>(hello.size()));
  // The greeting of the other side, and its READY, which is told by its length.
  char answer[66 + 255];
  ASSERT_EQ(recv(descriptor, answer, 66, MSG_WAITALL), 66);
  ASSERT_EQ(recv(descriptor, answer + 66, answer[65], MSG_WAITALL), answer[65]);
  ASSERT_EQ(write(descriptor, bytes.data(), bytes.size()), static_cast<ssize_t>(bytes.size()));
  std::this_thread::sleep_for(milliseconds(100));
  const linger at_once{1, 0};
  setsockopt(descriptor, SOL_SOCKET, SO_LINGER, &at_once, sizeof at_once);
  close(descriptor);
}

// libzmq's own heartbeats, two seconds apart, ended the whole process here.
TEST(ZmqTransport, OutlivesWhoSendsMoreThanIsReadAndIsGone) {
  const auto server = bind_server("tcp://127.0.0.1:*");
  std::string flood;
  for (int i = 0; i < 4000; ++i) flood += zmtp_frame(0, "a");
  send_and_reset(server->endpoint(), flood);
  std::this_thread::sleep_for(milliseconds(2500));
  int count = 0;
  for (int i = 0; i < 50; ++i) {
    while (server->receive()) ++count;
    server->wait(milliseconds(1));
  }
  EXPECT_GE(count, 256) << "the messages that had come are not lost";
  const auto client = connect_client(server->endpoint());
  client->send(Channel::control, bytes_of("still there"));
  EXPECT_TRUE(next(*server, *client));
}

TEST(ZmqTransport, OnlyLoopbackIsBoundUnlessAllowed) {
  EXPECT_THROW(bind_server("tcp://0.0.0.0:*"), Error);
  EXPECT_THROW(bind_server("tcp://*:*"), Error);
  EXPECT_THROW(bind_server("ipc:///nonexistent/folder/socket"), Error);
}

template <typename Transport>
void wakes(Transport& transport) {
  std::thread other([&] { transport.wake(); });
  // Without the wake-up this would outlast the test's limit.
  transport.wait(std::chrono::hours(1));
  other.join();
}

/// The most bytes that the system itself holds of a connection, at both of its ends.
size_t most_in_buffers_of_system() {
  size_t sum = 0;
  for (const char* name : {"/proc/sys/net/ipv4/tcp_rmem", "/proc/sys/net/ipv4/tcp_wmem"}) {
    size_t least = 0, usual = 0, most = 0;
    std::ifstream(name) >> least >> usual >> most;
    sum += most;
  }
  return sum;
}

TEST(ZmqTransport, HoldsFewBlobsForWhoReadsNone) {
  const auto server = bind_server("tcp://127.0.0.1:*");
  const auto client = connect_client(server->endpoint());
  client->connect_bulk(server->bulk_endpoint());
  client->send(Channel::bulk, bytes_of("question"));
  const auto asked = next(*server, *client);
  ASSERT_TRUE(asked);
  constexpr size_t kChunk = 1 << 20;
  constexpr size_t kHeldAtEachEnd = 16;
  // One more is on its way at each end.
  const size_t most = 2 * (kHeldAtEachEnd + 1) + most_in_buffers_of_system() / kChunk + 1;
  size_t taken = 0;
  int refused = 0;
  while (taken < 2 * most && refused < 20) {
    if (server->send(Channel::bulk, asked->peer, MessageBytes(kChunk)) == SendResult::sent) {
      ++taken;
    } else {
      ++refused;
      server->wait(milliseconds(5));
    }
  }
  EXPECT_GE(taken, kHeldAtEachEnd);
  EXPECT_LE(taken, most);
}

TEST(Transports, AreWokenByOtherThreads) {
  MemoryNetwork network;
  wakes(*network.server());
  wakes(*network.client());
  const auto server = bind_server("tcp://127.0.0.1:*");
  wakes(*server);
  wakes(*connect_client(server->endpoint()));
}

}  // namespace
}  // namespace tessera
