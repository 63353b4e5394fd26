// Who may see the page and who may order by it.
#include "web/web_access.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <sys/stat.h>

#include <fstream>

#include "base/error.h"

namespace tessera::testing {
namespace {

using Role = WebAccess::Role;

HttpRequest request(std::map<std::string, std::string> headers) {
  headers.try_emplace("host", "127.0.0.1:8080");
  return {"GET", "/", {}, std::move(headers), ""};
}

HttpRequest an_order(std::map<std::string, std::string> headers) {
  headers.try_emplace("content-type", "application/json");
  return request(std::move(headers));
}

int status(const WebAccess& access, const HttpRequest& request, Role role) {
  const auto refused = access.refuse(request, role);
  return refused ? refused->status : 200;
}

std::filesystem::path token_file(const std::string& text, mode_t mode = 0600) {
  const auto path = std::filesystem::path(::testing::TempDir()) / "tokens";
  std::filesystem::remove(path);
  std::ofstream(path) << text;
  chmod(path.c_str(), mode);
  return path;
}

TEST(WebAccess, WithoutTokensAnswersByNamesOfThisMachineAlone) {
  const WebAccess access;
  for (const char* host :
       {"127.0.0.1", "127.0.0.1:80", "127.1.2.3:9", "localhost:8080", "LocalHost", "[::1]:80"}) {
    EXPECT_EQ(status(access, request({{"host", host}}), Role::viewer), 200) << host;
  }
  for (const char* host :
       {"", "evil.example", "127.0.0.1.evil.example", "localhost.evil.example:80", "10.0.0.1",
        "[::2]:80", "localhost:1@evil.example", "[::1].evil.example", "[::1",
        "localhost:", "127.0.0.1:80:80"}) {
    EXPECT_EQ(status(access, request({{"host", host}}), Role::viewer), 421) << host;
  }
}

TEST(WebAccess, TakesOrdersOfItsOwnPageAlone) {
  const WebAccess access;
  EXPECT_EQ(status(access, an_order({}), Role::submitter), 200) << "of no browser";
  EXPECT_EQ(status(access, an_order({{"origin", "http://127.0.0.1:8080"}}), Role::submitter), 200);
  for (const char* origin :
       {"http://evil.example", "null", "http://127.0.0.1:8081", "http://localhost:8080",
        "https://127.0.0.1", "https://127.0.0.1:8080"}) {
    EXPECT_EQ(status(access, an_order({{"origin", origin}}), Role::submitter), 403) << origin;
  }
  for (const char* type :
       {"", "text/plain", "application/x-www-form-urlencoded", ";", "application/jsonp",
        "text/plain; application/json", "application/json, text/plain"}) {
    EXPECT_EQ(status(access, an_order({{"content-type", type}}), Role::submitter), 415) << type;
  }
  for (const char* type : {"application/json; charset=utf-8", "application/json;charset=UTF-8",
                           "Application/JSON ; charset=\"utf-8\""}) {
    EXPECT_EQ(status(access, an_order({{"content-type", type}}), Role::submitter), 200) << type;
  }
}

TEST(WebAccess, TokensHaveRoles) {
  const WebAccess access = WebAccess::read(
      token_file("# who\nviewer-token-000001 viewer wall\n\nsubmitter-token-001 submitter\n"));
  const auto with = [](const std::string& token) {
    return an_order({{"authorization", "Bearer " + token}, {"host", "farm.example"}});
  };
  EXPECT_EQ(status(access, request({}), Role::viewer), 401);
  EXPECT_EQ(status(access, with("viewer-token-000002"), Role::viewer), 401);
  EXPECT_EQ(status(access, with(""), Role::viewer), 401);
  EXPECT_EQ(status(access, with("viewer-token-000001"), Role::viewer), 200);
  EXPECT_EQ(status(access, with("viewer-token-000001"), Role::submitter), 403);
  EXPECT_EQ(status(access, with("submitter-token-001"), Role::viewer), 200);
  EXPECT_EQ(status(access, with("submitter-token-001"), Role::submitter), 200);
  EXPECT_EQ(status(access, request({{"authorization", "Basic viewer-token-000001"}}), Role::viewer),
            401);
  for (const char* scheme : {"bearer ", "BEARER "}) {
    const auto of = [&](const std::string& token) {
      return request({{"authorization", scheme + token}});
    };
    EXPECT_EQ(status(access, of("viewer-token-000001"), Role::viewer), 200) << scheme;
    EXPECT_EQ(status(access, of("Viewer-Token-000001"), Role::viewer), 401) << scheme;
  }
}

TEST(WebAccess, WebSocketsAreOpenedByOurOwnPageAlone) {
  const auto opened = [](const WebAccess& access, const std::string& host,
                         const std::string& origin) {
    const auto refused = access.refuse_upgrade(request({{"host", host}, {"origin", origin}}));
    return refused ? refused->status : 101;
  };
  const WebAccess access = WebAccess::of_token("token-of-this-start", Role::submitter);
  EXPECT_EQ(opened(access, "localhost:7190", "http://localhost:7190"), 101);
  EXPECT_EQ(opened(access, "[::1]:7190", "http://[::1]:7190"), 101);
  EXPECT_EQ(opened(access, "localhost:7190", ""), 403);
  EXPECT_EQ(opened(access, "localhost:7190", "http://127.0.0.1:7190"), 403);
  EXPECT_EQ(opened(access, "localhost:7190", "https://localhost:7190"), 403);
  EXPECT_EQ(opened(access, "studio.example", "http://studio.example"), 421);
  EXPECT_EQ(access.refuse_host(request({{"host", "studio.example"}}))->status, 421);
  EXPECT_FALSE(access.refuse_host(request({})));
  const WebAccess of_file = WebAccess::read(token_file("submitter-token-001 submitter\n"));
  EXPECT_EQ(opened(of_file, "studio.example", "https://studio.example"), 101);
  EXPECT_EQ(opened(of_file, "studio.example", "https://evil.example"), 403);
}

TEST(WebAccess, PagesOfThePublicAddressAreItsOwn) {
  WebAccess access;
  access.set_public_address(
      parse_public_address("--http-origin", "https://Farm.example:443/tessera"));
  for (const char* host : {"127.0.0.1:8080", "farm.example", "FARM.example:443"}) {
    const auto from = [&](const char* origin) {
      return status(access, an_order({{"host", host}, {"origin", origin}}), Role::submitter);
    };
    EXPECT_EQ(from("https://farm.example"), 200) << host;
    for (const char* origin : {"http://farm.example", "https://farm.example:8443", "null",
                               "https://farm.example.evil.example", "https://evil.example"}) {
      EXPECT_EQ(from(origin), 403) << host << " " << origin;
    }
    const auto refused =
        access.refuse_upgrade(request({{"host", host}, {"origin", "https://farm.example"}}));
    EXPECT_FALSE(refused) << host;
  }
  EXPECT_EQ(status(access, request({{"host", "evil.example"}}), Role::viewer), 421);
}

TEST(PublicAddress, IsThatOfAPage) {
  const auto parse = [](const std::string& text) {
    return parse_public_address("--http-origin", text);
  };
  const PublicAddress address = parse("HTTPS://Farm.Example:8443/a/B");
  EXPECT_EQ(address.url, "https://farm.example:8443/a/B/");
  EXPECT_EQ(address.origin, "https://farm.example:8443");
  EXPECT_EQ(address.host, "farm.example");
  EXPECT_EQ(parse("http://farm.example:80").url, "http://farm.example/");
  EXPECT_EQ(parse("https://[2001:db8::1]/").origin, "https://[2001:db8::1]");
  for (const char* wrong :
       {"", "farm.example", "ftp://farm.example", "https://", "https:///x",
        "https://farm.example:", "https://farm.example:x", "https://farm.example:65536",
        "https://farm.example:99999", "https://a@farm.example", "https://farm.example/?a",
        "https://farm.example/#a", "https://farm example/", "https://farm.example/a b", "//x/"}) {
    EXPECT_THROW(parse(wrong), Error) << wrong;
  }
}

TEST(WebAccess, KnowsATokenByItself) {
  const WebAccess access = WebAccess::of_token("token-of-this-start", Role::submitter);
  EXPECT_EQ(access.role_of("token-of-this-start"), Role::submitter);
  EXPECT_EQ(access.role_of("token-of-that-start"), std::nullopt);
  EXPECT_EQ(access.role_of(""), std::nullopt);
  EXPECT_EQ(WebAccess().role_of(""), std::nullopt);
}

TEST(WebAccess, SaysWhatIsWrongWithAFile) {
  const auto complaint = [](const std::string& text, mode_t mode = 0600) -> std::string {
    try {
      WebAccess::read(token_file(text, mode));
    } catch (const Error& error) {
      return error.what();
    }
    return "none";
  };
  EXPECT_THAT(complaint("short viewer\n"), ::testing::HasSubstr("tokens:1: a token of 5"));
  EXPECT_THAT(complaint("\nlong-enough-token-1 king\n"),
              ::testing::HasSubstr("tokens:2: role 'king'; expected viewer or submitter"));
  EXPECT_THAT(complaint("# nothing\n"), ::testing::HasSubstr("has no token"));
  EXPECT_THAT(complaint("long-enough-token-1 viewer\n", 0644), ::testing::HasSubstr("mode 0600"));
  EXPECT_EQ(complaint("long-enough-token-1 viewer\n", 0440), "none");
  EXPECT_THROW(WebAccess::read("/nowhere/tokens"), Error);
}

}  // namespace
}  // namespace tessera::testing
