// Files that CMake's tessera_embed() has made part of the program.
#include "web/embedded_file.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <optional>
#include <set>

#include "tests/unit/web/web_client.h"
#include "web/web_server.h"

namespace tessera {

std::optional<EmbeddedFile> find_test_page_file(std::string_view path);

namespace testing {
namespace {

using ::testing::HasSubstr;
using ::testing::Not;

TEST(EmbeddedFile, IsFoundByThePathOfARequest) {
  const auto index = find_test_page_file("/");
  ASSERT_TRUE(index);
  EXPECT_EQ(index->type, "text/html; charset=utf-8");
  EXPECT_TRUE(index->content.starts_with("<!doctype html>\n"));
  const auto style = find_test_page_file("/folder/plain.css");
  ASSERT_TRUE(style);
  EXPECT_EQ(style->type, "text/css; charset=utf-8");
  EXPECT_EQ(style->content, "p {}\n");
  for (const char* none : {"", "/index.html", "/plain.css", "/folder", "/script.js.gz"}) {
    EXPECT_FALSE(find_test_page_file(none)) << none;
  }
}

TEST(EmbeddedFile, MayBeGzipped) {
  const auto script = find_test_page_file("/script.js");
  ASSERT_TRUE(script);
  EXPECT_EQ(script->type, "text/javascript; charset=utf-8");
  EXPECT_TRUE(script->content.starts_with("\x1F\x8B"));
  const WebServer server("127.0.0.1:0", [](const HttpRequest& request, const HttpReply& reply) {
    reply([path = request.path] { return response_of(*find_test_page_file(path)); });
  });
  const std::string answer = fetch(server.address(), "/script.js");
  EXPECT_THAT(answer, HasSubstr("Content-Encoding: gzip\r\n"));
  EXPECT_THAT(answer, HasSubstr("Content-Type: text/javascript; charset=utf-8\r\n"));
  EXPECT_TRUE(answer.ends_with(script->content));
  EXPECT_THAT(fetch(server.address(), "/"), Not(HasSubstr("Content-Encoding")));
}

TEST(EmbeddedFile, HasANonceOfItsOwnInEachAnswer) {
  const WebServer server("127.0.0.1:0", [](const HttpRequest&, const HttpReply& reply) {
    reply([] {
      return response_with_nonce(*find_test_page_file("/"),
                                 "default-src 'none'; style-src 'nonce-{{nonce}}'");
    });
  });
  std::set<std::string> nonces;
  for (int i = 0; i < 20; ++i) {
    const std::string answer = fetch(server.address(), "/");
    const size_t at = answer.find("content=\"") + 9;
    const std::string nonce = answer.substr(at, answer.find('"', at) - at);
    EXPECT_EQ(nonce.size(), 32u);
    EXPECT_THAT(answer, HasSubstr("<style nonce=\"" + nonce + "\">"));
    EXPECT_THAT(answer, HasSubstr("\r\nContent-Security-Policy: default-src 'none'; style-src "
                                  "'nonce-" +
                                  nonce + "'\r\n"));
    EXPECT_THAT(answer, Not(HasSubstr("default-src 'self'"))) << "two policies";
    nonces.insert(nonce);
  }
  EXPECT_EQ(nonces.size(), 20u);
}

}  // namespace
}  // namespace testing
}  // namespace tessera
