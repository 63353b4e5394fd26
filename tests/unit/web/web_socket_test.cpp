// WebSockets against clients that are well-behaved, hostile, silent or many.
#include "web/web_socket.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <array>
#include <atomic>
#include <memory>
#include <set>
#include <string>
#include <thread>
#include <vector>

#include "tests/unit/web/web_socket_fixture.h"

namespace tessera::testing {
namespace {

using std::chrono::milliseconds;
using ::testing::HasSubstr;
using ::testing::StartsWith;

TEST_F(WebSockets, CarryTextAndBytesInOrder) {
  serve();
  WebSocketClient client(host());
  EXPECT_EQ(client.response[beast::http::field::sec_websocket_protocol], kProtocol);
  EXPECT_EQ(client.response.count(beast::http::field::sec_websocket_extensions), 0u);
  const std::string bytes("\0\xFF\x80", 3);
  client.send("grüße");
  client.send(bytes, true);
  client.send("");
  EXPECT_EQ(client.receive(), "grüße");
  EXPECT_FALSE(client.got_binary());
  EXPECT_EQ(client.receive(), bytes);
  EXPECT_TRUE(client.got_binary());
  EXPECT_EQ(client.receive(), "");
  for (int i = 0; i < 1000; ++i) client.send(std::to_string(i));
  for (int i = 0; i < 1000; ++i) EXPECT_EQ(client.receive(), std::to_string(i));
  EXPECT_THAT(fetch(host(), "/"), HasSubstr("page")) << "the handler answers all else";
}

TEST_F(WebSockets, AreOpenedByOurOwnPageAlone) {
  serve();
  EXPECT_THAT(answer(upgrade()), StartsWith("HTTP/1.1 101"));
  record->wait([&] { return record->sockets.size() == 1; });
  for (const std::string& origin :
       {std::string("http://evil.example"), std::string("null"), std::string("http://127.0.0.1:1"),
        host(), "https://" + host(), "http://evil.example/http://" + host()}) {
    EXPECT_THAT(answer(upgrade(origin)), StartsWith("HTTP/1.1 403")) << origin;
  }
  const auto changed = [&](const std::string& what, const std::string& by) {
    std::string request = upgrade();
    const size_t at = request.find(what);
    EXPECT_NE(at, std::string::npos) << what;
    return answer(request.replace(at, what.size(), by));
  };
  EXPECT_THAT(changed("Origin: http://" + host() + "\r\n", ""), StartsWith("HTTP/1.1 403"));
  EXPECT_THAT(changed("Host: 127.0.0.1", "Host: evil.example"), StartsWith("HTTP/1.1 421"));
  EXPECT_THAT(changed("Host: " + host() + "\r\n", ""), StartsWith("HTTP/1.1 421"));
  EXPECT_EQ(record->sockets.size(), 1u);
}

TEST_F(WebSockets, AreOpenedByARightUpgradeAlone) {
  serve();
  const auto changed = [&](const std::string& what, const std::string& by) {
    std::string request = upgrade();
    const size_t at = request.find(what);
    EXPECT_NE(at, std::string::npos) << what;
    return answer(request.replace(at, what.size(), by));
  };
  EXPECT_THAT(changed("/talk", "/other"), StartsWith("HTTP/1.1 404"));
  EXPECT_THAT(changed("/talk", "/talk/"), StartsWith("HTTP/1.1 404"));
  EXPECT_THAT(changed("GET", "POST"), StartsWith("HTTP/1.1 405"));
  EXPECT_THAT(changed("Version: 13", "Version: 8"), StartsWith("HTTP/1.1 426"));
  EXPECT_THAT(changed("HTTP/1.1", "HTTP/1.0"), StartsWith("HTTP/1.1 400"));
  EXPECT_THAT(changed("Connection: Upgrade\r\n", ""), StartsWith("HTTP/1.1 400"));
  EXPECT_THAT(changed("Sec-WebSocket-Key: dGhlIHNhbXBsZSBub25jZQ==\r\n", ""),
              StartsWith("HTTP/1.1 400"));
  EXPECT_THAT(changed("Sec-WebSocket-Protocol: other, test.1\r\n", ""), StartsWith("HTTP/1.1 400"));
  EXPECT_THAT(changed("other, test.1", "test.10, xtest.1"), StartsWith("HTTP/1.1 400"));
  EXPECT_THAT(answer(upgrade() + "early"), StartsWith("HTTP/1.1 400"));
  for (const std::string& field :
       {"Host: " + host(), "Origin: http://" + host(), std::string("Upgrade: websocket"),
        std::string("Sec-WebSocket-Key: dGhlIHNhbXBsZSBub25jZQ=="),
        std::string("Sec-WebSocket-Version: 13"), std::string("Sec-WebSocket-Protocol: test.1")}) {
    EXPECT_THAT(answer(upgrade("", field + "\r\n")), StartsWith("HTTP/1.1 400")) << field;
  }
  EXPECT_TRUE(record->sockets.empty());
}

TEST_F(WebSockets, EndWithMessagesThatAreTooLargeOrNoText) {
  WebSocketLimits limits;
  limits.message_bytes = 1000;
  serve(limits);
  {
    WebSocketClient client(host());
    client.send(std::string(1000, 'x'));
    EXPECT_EQ(client.receive().size(), 1000u);
    client.send(std::string(1001, 'x'));
    EXPECT_THAT(client.receive(), StartsWith("closed 1009"));
  }
  {
    WebSocketClient parts(host());
    for (int i = 0; i < 6; ++i)
      parts.stream().write_some(false, asio::buffer(std::string(200, 'x')));
    EXPECT_THAT(parts.receive(), StartsWith("closed 1009"));
  }
  WebSocketClient client(host());
  client.send("\xC3(");
  EXPECT_THAT(client.receive(), StartsWith("closed 1007"));
  EXPECT_TRUE(record->wait([&] { return record->closed == 3 && record->destroyed == 3; }));
  EXPECT_EQ(record->messages.size(), 1u);
}

TEST_F(WebSockets, AreCounted) {
  WebSocketLimits limits;
  limits.connections = 3;
  serve(limits);
  std::vector<std::unique_ptr<WebSocketClient>> clients;
  for (int i = 0; i < 3; ++i) clients.push_back(std::make_unique<WebSocketClient>(host()));
  EXPECT_THAT(answer(upgrade()), StartsWith("HTTP/1.1 503"));
  EXPECT_THAT(fetch(host(), "/"), StartsWith("HTTP/1.1 200"));
  clients.pop_back();
  EXPECT_TRUE(record->wait([&] { return record->closed == 1; }));
  while (answer(upgrade()).starts_with("HTTP/1.1 503")) usleep(1000);
}

TEST_F(WebSockets, OfThoseThatAreNotKnownTheFirstMakesRoom) {
  WebSocketLimits limits;
  limits.connections = 4;
  limits.unknown = 2;
  serve(limits);
  WebSocketClient known(host());
  std::vector<std::unique_ptr<WebSocketClient>> strangers;
  for (int i = 0; i < 5; ++i) {
    strangers.push_back(std::make_unique<WebSocketClient>(host()));
    strangers.back()->send("a stranger");
    EXPECT_EQ(strangers.back()->receive(), "a stranger");
  }
  EXPECT_TRUE(record->wait([&] { return record->closed == 3; }));
  EXPECT_EQ(strangers[2]->receive(), "lost");
  strangers[3]->send("still here");
  EXPECT_EQ(strangers[3]->receive(), "still here");
  known.send("as before");
  EXPECT_EQ(known.receive(), "as before");
}

TEST_F(WebSockets, AConnectionThatDoesNotAnswerItsCloseHoldsNoPlace) {
  WebSocketLimits limits;
  limits.connections = 2;
  limits.to_close = std::chrono::minutes(10);
  serve(limits);
  // Of those that are closing no more are kept than may be open.
  std::vector<std::unique_ptr<WebSocketClient>> silent;
  for (size_t i = 0; i < 6; ++i) {
    silent.push_back(std::make_unique<WebSocketClient>(host()));
    record->socket(i)->close(4401, "no token");
  }
  EXPECT_TRUE(record->wait([&] { return record->closed >= 4; }));
}

TEST_F(WebSockets, QueueNoMoreThanAllowedForWhoDoesNotRead) {
  WebSocketLimits limits;
  limits.queued_bytes = 1 << 20;
  limits.to_take = milliseconds(300);
  serve(limits);
  WebSocketClient client(host(), true), other(host());
  const auto socket = record->socket(0);
  const auto part = shared(std::string(100'000, 'x'));
  size_t sent = 0, largest = 0;
  for (int refused = 0; refused < 50; largest = std::max(largest, socket->queued_bytes())) {
    if (socket->send(part, true)) {
      ++sent;
    } else if (socket->is_open()) {
      ++refused;
      usleep(1000);
    } else {
      break;
    }
  }
  EXPECT_GE(largest, size_t{1} << 20);
  EXPECT_LT(largest, (size_t{1} << 20) + part->size());
  EXPECT_GE(sent, 10u);
  other.send("still here");
  EXPECT_EQ(other.receive(), "still here");
  // It takes nothing for so long that it is given up.
  EXPECT_TRUE(record->wait([&] { return record->closed == 1; }));
  EXPECT_FALSE(socket->is_open());
  EXPECT_EQ(socket->queued_bytes(), 0u);
  while (part.use_count() > 1) usleep(1000);
}

TEST_F(WebSockets, TakeAMessageThatIsLargerThanTheQueue) {
  WebSocketLimits limits;
  limits.queued_bytes = 1000;
  serve(limits);
  WebSocketClient client(host(), true);
  const auto socket = record->socket(0);
  const std::string large(5'000'000, 'x');
  EXPECT_TRUE(socket->send(shared(large), true));
  EXPECT_FALSE(socket->send(shared("too much"), true));
  EXPECT_TRUE(client.receive() == large);
  while (!socket->send(shared("more"), true)) usleep(1000);
  EXPECT_EQ(client.receive(), "more");
}

TEST_F(WebSockets, EndWhereNothingComesButLiveByPongs) {
  WebSocketLimits limits;
  limits.idle_timeout = milliseconds(1000);
  serve(limits);
  WebSocketClient alive(host());
  std::atomic<int> pings = 0;
  alive.stream().control_callback([&](websocket::frame_type kind, beast::string_view) {
    pings += kind == websocket::frame_type::ping;
  });
  std::thread reader([&] { EXPECT_EQ(alive.receive(), "well"); });
  const auto socket = record->socket(0);
  WebClient dead(host());
  dead.send(upgrade());
  EXPECT_THAT(dead.receive_one(), StartsWith("HTTP/1.1 101"));
  EXPECT_EQ(dead.receive_all().size(), 2u) << "a ping";
  EXPECT_TRUE(record->wait([&] { return record->closed == 1; }));
  while (pings < 3 && socket->is_open()) usleep(1000);
  EXPECT_TRUE(socket->send(shared("well"), false));
  reader.join();
}

TEST_F(WebSockets, CloseWithACodeOnceAllIsSent) {
  serve();
  WebSocketClient client(host());
  client.send("close");
  client.send("unheard");
  EXPECT_EQ(client.receive(), "last words");
  EXPECT_EQ(client.receive(), "closed 4401 no token");
  EXPECT_TRUE(record->wait([&] { return record->destroyed == 1; }));
  EXPECT_EQ(record->messages.size(), 1u);
  EXPECT_EQ(record->closed, 1u);

  WebSocketClient again(host());
  std::string reason(122, 'x');
  record->socket(1)->close(4000, reason + "ü");
  EXPECT_EQ(again.receive(), "closed 4000 " + reason);
}

TEST_F(WebSockets, EndWithTheClient) {
  serve();
  WebSocketClient polite(host());
  polite.stream().close(websocket::close_reason(websocket::going_away));
  EXPECT_TRUE(record->wait([&] { return record->destroyed == 1; }));
  { const WebSocketClient gone(host()); }
  EXPECT_TRUE(record->wait([&] { return record->destroyed == 2; }));
  EXPECT_EQ(record->closed, 2u);
  EXPECT_FALSE(record->socket(0)->send(shared("x"), false));
  EXPECT_FALSE(record->socket(1)->is_open());
}

TEST_F(WebSockets, EndWhereThePeerThrows) {
  serve();
  WebSocketClient client(host()), other(host());
  client.send("throw");
  EXPECT_EQ(client.receive(), "closed 1011 internal error");
  other.send("fine");
  EXPECT_EQ(other.receive(), "fine");
}

TEST_F(WebSockets, HandlesOutliveTheServer) {
  serve();
  std::vector<std::unique_ptr<WebSocketClient>> clients;
  for (int i = 0; i < 5; ++i) clients.push_back(std::make_unique<WebSocketClient>(host()));
  const auto socket = record->socket(4);
  server.reset();
  EXPECT_EQ(record->closed, 5u);
  EXPECT_EQ(record->destroyed, 5u);
  for (const auto& client : clients) EXPECT_EQ(client->receive(), "lost");
  EXPECT_FALSE(socket->send(shared("x"), false));
  EXPECT_FALSE(socket->is_open());
  EXPECT_EQ(socket->queued_bytes(), 0u);
  socket->close(1000, "");
  const std::set<std::thread::id> threads(record->threads.begin(), record->threads.end());
  EXPECT_EQ(threads.size(), 1u) << "peers are called on one thread";
  EXPECT_EQ(threads.count(std::this_thread::get_id()), 0u);
}

TEST_F(WebSockets, AreSentToByManyThreads) {
  serve();
  constexpr int kClients = 8, kThreads = 4, kMessages = 200;
  std::vector<std::unique_ptr<WebSocketClient>> clients;
  for (int i = 0; i < kClients; ++i) clients.push_back(std::make_unique<WebSocketClient>(host()));
  record->socket(kClients - 1);
  std::vector<std::thread> senders;
  for (int thread = 0; thread < kThreads; ++thread) {
    senders.emplace_back([&, thread] {
      for (int i = 0; i < kMessages; ++i) {
        const auto message = shared(std::to_string(thread) + " " + std::to_string(i));
        for (int to = 0; to < kClients; ++to) EXPECT_TRUE(record->socket(to)->send(message, true));
      }
    });
  }
  for (const auto& client : clients) {
    std::array<int, kThreads> next{};
    for (int i = 0; i < kThreads * kMessages; ++i) {
      const std::string message = client->receive();
      const size_t thread = message[0] - '0';
      ASSERT_LT(thread, next.size()) << message;
      EXPECT_EQ(message.substr(2), std::to_string(next[thread]++));
    }
  }
  for (std::thread& sender : senders) sender.join();
}

TEST_F(WebSockets, MayBeSentToWhileTheServerEnds) {
  for (int round = 0; round < 10; ++round) {
    record = std::make_shared<Record>();
    serve();
    WebSocketClient client(host());
    const auto socket = record->socket(0);
    std::atomic<int> sent = 0;
    std::vector<std::thread> senders;
    for (int thread = 0; thread < 3; ++thread) {
      senders.emplace_back([&] {
        while (socket->is_open()) sent += socket->send(shared("x"), true);
      });
    }
    while (sent < 10) std::this_thread::yield();
    server.reset();
    for (std::thread& sender : senders) sender.join();
    EXPECT_EQ(record->destroyed, 1u);
  }
}

}  // namespace
}  // namespace tessera::testing
