// The page's server against clients that are slow, hostile or many.
#include "web/web_server.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <atomic>
#include <memory>
#include <mutex>
#include <vector>

#include "base/error.h"
#include "tests/unit/web/web_client.h"

namespace tessera::testing {
namespace {

using std::chrono::milliseconds;
using ::testing::HasSubstr;
using ::testing::StartsWith;

HttpResponse text(const std::string& body) {
  return {200, "text/plain", std::make_shared<const std::string>(body), {}};
}

/// Answers with what it was asked.
void echo(const HttpRequest& request, const HttpReply& reply) {
  std::string all = request.method + " " + request.path;
  for (const auto& [name, value] : request.query) all += " " + name + "=" + value;
  all += " [" + request.header("x-word") + "] " + request.body;
  reply([all] { return text(all); });
}

TEST(WebServer, AnswersRequestsInTurn) {
  const WebServer server("127.0.0.1:0", echo);
  WebClient client(server.address());
  client.send(get_request("/a?b=1&c&d=2=3", "X-Word: yes\r\n"));
  EXPECT_THAT(client.receive_one(), HasSubstr("\r\n\r\nGET /a b=1 c= d=2=3 [yes] "));
  client.send(
      "POST /p HTTP/1.1\r\nHost: x\r\nContent-Length: 4\r\n\r\nbodyGET /n HTTP/1.1\r\nHost: "
      "x\r\n\r\n");
  EXPECT_THAT(client.receive_one(), HasSubstr("POST /p [] body"));
  EXPECT_THAT(client.receive_one(), HasSubstr("GET /n"));
  client.send("HEAD /h HTTP/1.1\r\nHost: x\r\nConnection: close\r\n\r\n");
  const std::string head = client.receive_all();
  EXPECT_THAT(head, HasSubstr("Content-Length: 11\r\n"));
  EXPECT_TRUE(head.ends_with("\r\n\r\n")) << head;
}

TEST(WebServer, ProtectsThePageFromOtherSites) {
  const WebServer server("localhost:0", echo);
  const std::string answer = fetch(server.address(), "/");
  EXPECT_THAT(answer, HasSubstr("Content-Security-Policy: default-src 'self'"));
  EXPECT_THAT(answer, HasSubstr("frame-ancestors 'none'"));
  EXPECT_THAT(answer, HasSubstr("X-Content-Type-Options: nosniff"));
  EXPECT_THAT(answer, HasSubstr("Cross-Origin-Resource-Policy: same-origin"));
  EXPECT_THAT(answer, ::testing::Not(HasSubstr("Access-Control")));
}

TEST(WebServer, EndsWhoAsksForTooMuch) {
  const WebServer server("127.0.0.1:0", echo);
  for (const std::string& request :
       {get_request("/", "X-Word: " + std::string(9000, 'x') + "\r\n"),
        get_request("/" + std::string(9000, 'x')),
        std::string("POST / HTTP/1.1\r\nHost: x\r\nContent-Length: 999999999999\r\n\r\n"),
        "POST / HTTP/1.1\r\nHost: x\r\nTransfer-Encoding: chunked\r\n\r\n1400\r\n" +
            std::string(0x1400, 'x') + "\r\n0\r\n\r\n"}) {
    WebClient client(server.address());
    client.send(request);
    EXPECT_THAT(client.receive_all(), StartsWith("HTTP/1.1 413")) << request.substr(0, 60);
  }
  // Fields without end, each of them short.
  WebClient client(server.address());
  client.send("GET / HTTP/1.1\r\n");
  for (int i = 0; i < 2000; ++i) client.send("A" + std::to_string(i) + ": b\r\n");
  EXPECT_THAT(client.receive_all(), StartsWith("HTTP/1.1 413"));
}

TEST(WebServer, TakesNoRequestThatNamesTwoHosts) {
  const WebServer server("127.0.0.1:0", echo);
  WebClient client(server.address());
  client.send("GET / HTTP/1.1\r\nHost: localhost\r\nHost: elsewhere\r\n\r\n");
  EXPECT_THAT(client.receive_all(), StartsWith("HTTP/1.1 400"));
  WebClient other(server.address());
  other.send(get_request("/", "Origin: http://a\r\nOrigin: http://b\r\n"));
  EXPECT_THAT(other.receive_all(), StartsWith("HTTP/1.1 400"));
}

TEST(WebServer, ClosesOnWhatIsNoRequest) {
  const WebServer server("127.0.0.1:0", echo);
  for (const std::string& bytes : {std::string("\0\1\2\3\r\n\r\n", 8), std::string("GET\r\n\r\n"),
                                   std::string("GET / HTTP/9.9\r\n\r\n"),
                                   std::string("GET / HTTP/1.1\r\nContent-Length: -1\r\n\r\n")}) {
    WebClient client(server.address());
    client.send(bytes);
    EXPECT_EQ(client.receive_all(), "");
  }
  EXPECT_THAT(fetch(server.address(), "/still"), HasSubstr("GET /still"));
}

TEST(WebServer, GivesNobodyMoreThanHisTime) {
  WebLimits limits;
  limits.to_ask = milliseconds(100);
  const WebServer server("127.0.0.1:0", echo, limits);
  WebClient silent(server.address()), slow(server.address());
  slow.send("GET / HTTP/1.1\r\nHos");
  EXPECT_EQ(silent.receive_all(), "");
  EXPECT_EQ(slow.receive_all(), "");
  EXPECT_TRUE(silent.was_closed());
  EXPECT_TRUE(slow.was_closed());
  EXPECT_THAT(fetch(server.address(), "/"), HasSubstr("200 OK"));
}

TEST(WebServer, SaysWhenNoAnswerComes) {
  WebLimits limits;
  limits.to_answer = milliseconds(50);
  std::mutex mutex;
  std::vector<HttpReply> replies;
  WebServer server(
      "127.0.0.1:0",
      [&](const HttpRequest&, HttpReply reply) {
        const std::scoped_lock lock(mutex);
        replies.push_back(std::move(reply));
      },
      limits);
  EXPECT_THAT(fetch(server.address(), "/"), StartsWith("HTTP/1.1 503"));
  const std::scoped_lock lock(mutex);
  ASSERT_EQ(replies.size(), 1u);
  replies[0]([] { return text("too late"); });
}

TEST(WebServer, RepliesMayOutliveIt) {
  HttpReply late;
  {
    std::atomic<bool> asked = false;
    const WebServer server("127.0.0.1:0", [&](const HttpRequest&, HttpReply reply) {
      late = std::move(reply);
      asked = true;
    });
    WebClient client(server.address());
    client.send(get_request("/"));
    while (!asked) usleep(1000);
  }
  late([]() -> HttpResponse { throw std::logic_error("nobody is to make it"); });
}

TEST(WebServer, ServesOnWhileSomeStall) {
  const std::string large(8 << 20, 'x');
  const auto shared = std::make_shared<const std::string>(large);
  const WebServer server("127.0.0.1:0", [&](const HttpRequest&, const HttpReply& reply) {
    reply([&] { return HttpResponse{200, "text/plain", shared, {}}; });
  });
  std::vector<std::unique_ptr<WebClient>> stalled;
  for (int i = 0; i < 20; ++i) {
    stalled.push_back(std::make_unique<WebClient>(server.address()));
    stalled.back()->send(get_request("/"));
  }
  for (int i = 0; i < 5; ++i) EXPECT_GT(fetch(server.address(), "/").size(), large.size());
  EXPECT_LE(shared.use_count(), 30) << "all are sent the same bytes";
}

TEST(WebServer, ThoseThatAskNothingMakeRoomForOthers) {
  WebLimits limits;
  limits.connections = 3;
  const WebServer server("127.0.0.1:0", echo, limits);
  WebClient half(server.address());
  half.send("GET /half HTTP/1.1\r\n");
  std::vector<std::unique_ptr<WebClient>> idle;
  for (int i = 0; i < 20; ++i) {
    idle.push_back(std::make_unique<WebClient>(server.address()));
    EXPECT_THAT(fetch(server.address(), "/in"), HasSubstr("/in"));
  }
  EXPECT_EQ(half.receive_all(), "");
}

TEST(WebServer, TakesNoMoreThanItsConnections) {
  WebLimits limits;
  limits.connections = 2;
  std::mutex mutex;
  std::vector<HttpReply> asked;
  const WebServer server(
      "127.0.0.1:0",
      [&](const HttpRequest& request, const HttpReply& reply) {
        if (request.path == "/four") return reply([] { return text("four"); });
        const std::lock_guard lock(mutex);
        asked.push_back(reply);
      },
      limits);
  {
    WebClient one(server.address()), two(server.address());
    one.send(get_request("/one"));
    two.send(get_request("/two"));
    const auto both_ask = [&] {
      const std::lock_guard lock(mutex);
      return asked.size() == 2;
    };
    while (!both_ask()) usleep(1000);
    EXPECT_EQ(fetch(server.address(), "/three"), "");
    for (const HttpReply& reply : asked) reply([] { return text("well"); });
    EXPECT_THAT(one.receive_one(), HasSubstr("well"));
    EXPECT_THAT(two.receive_one(), HasSubstr("well"));
  }
  // Those that have gone make room, once the server has seen it.
  while (fetch(server.address(), "/four").empty()) usleep(1000);
}

TEST(WebServer, BindsAddressesInDigits) {
  EXPECT_THAT(WebServer("[::1]:0", echo).address(), StartsWith("[::1]:"));
  for (const char* wrong : {"", "8080", "localhost", "example.org:80", "127.0.0.1:65536",
                            "127.0.0.1:-1", "::1:80", "127.0.0.1:8x"}) {
    EXPECT_THROW(WebServer(wrong, echo), Error) << wrong;
  }
  const WebServer server("127.0.0.1:0", echo);
  try {
    const WebServer second(server.address(), echo);
    ADD_FAILURE() << "it is taken";
  } catch (const Error& error) {
    EXPECT_EQ(error.code(), ExitCode::try_again) << "another port may be free";
  }
  EXPECT_TRUE(WebServer::is_loopback("127.8.0.1:80"));
  EXPECT_TRUE(WebServer::is_loopback("[::1]:80"));
  EXPECT_FALSE(WebServer::is_loopback("0.0.0.0:80"));
  EXPECT_FALSE(WebServer::is_loopback("[::]:80"));
}

}  // namespace
}  // namespace tessera::testing
