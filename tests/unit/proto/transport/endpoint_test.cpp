#include "proto/transport/endpoint.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "base/error.h"

namespace tessera {
namespace {

TEST(Endpoint, IsReadAndPrinted) {
  for (const char* text : {"ipc:///tmp/x/farm", "tcp://127.0.0.1:5555", "tcp://host.example:1",
                           "tcp://[::1]:65535", "tcp://127.0.0.1:*"}) {
    EXPECT_EQ(parse_endpoint(text).str(), text);
  }
  EXPECT_EQ(parse_endpoint("tcp://a:0").port, 0);
}

TEST(Endpoint, KnowsWhatOthersCanReach) {
  for (const char* text : {"ipc:///x", "tcp://127.0.0.1:1", "tcp://localhost:1", "tcp://[::1]:1",
                           "tcp://127.1.2.3:1", "tcp://[0:0:0:0:0:0:0:1]:1"}) {
    EXPECT_TRUE(parse_endpoint(text).loopback()) << text;
  }
  for (const char* text : {"tcp://0.0.0.0:1", "tcp://*:1", "tcp://[::]:1", "tcp://10.0.0.1:1",
                           "tcp://127.evil.example:1", "tcp://localhost.evil.example:1"}) {
    EXPECT_FALSE(parse_endpoint(text).loopback()) << text;
  }
}

TEST(Endpoint, HasTheZoneOfALinkLocalAddress) {
  for (const char* text : {"tcp://[fe80::1%lo]:1", "tcp://[fe80::1%1]:1", "tcp://fe80::1%lo:1",
                           "tcp://[fd00::1]:1", "tcp://[::]:1", "tcp://host:1", "ipc:///x%y"})
    EXPECT_NO_THROW(check_zone(parse_endpoint(text))) << text;
  const auto error_of = [](const std::string& text) -> std::string {
    try {
      check_zone(parse_endpoint(text));
      return text + " is taken";
    } catch (const Error& error) {
      EXPECT_EQ(error.code(), ExitCode::bad_usage);
      return error.what();
    }
  };
  for (const std::string zone : {"nosuch", "", "25lo", "999999", "1x", "-1"}) {
    const std::string text = "tcp://[fe80::1%" + zone + "]:1";
    EXPECT_EQ(error_of(text), "endpoint '" + text + "' has the zone '" + zone +
                                  "'; expected a network interface of this machine");
  }
  EXPECT_EQ(error_of("tcp://[::1%lo]:1"),
            "endpoint 'tcp://[::1%lo]:1' has the zone 'lo'; expected none but for a link-local "
            "address (fe80::)");
  for (const std::string host : {"[fe80::1]", "fe80::1"}) {
    EXPECT_EQ(error_of("tcp://" + host + ":1"),
              "endpoint 'tcp://" + host +
                  ":1' has a link-local address; expected its network "
                  "interface after it, such as [fe80::1%eth0]");
  }
}

TEST(Endpoint, ThatIsMalformedIsNamed) {
  const std::string long_path = "ipc://" + std::string(200, 'x');
  for (const std::string& text :
       {std::string(), std::string("127.0.0.1:5555"), std::string("udp://x:1"),
        std::string("ipc://"), std::string("tcp://x"), std::string("tcp://:5"),
        std::string("tcp://x:"), std::string("tcp://x:65536"), std::string("tcp://x:-1"),
        std::string("tcp://x:12z"), std::string("tcp://a b:1"), long_path}) {
    try {
      parse_endpoint(text);
      ADD_FAILURE() << text;
    } catch (const Error& error) {
      EXPECT_EQ(error.code(), ExitCode::bad_usage);
      EXPECT_THAT(error.what(), ::testing::HasSubstr("'" + text + "'"));
      EXPECT_THAT(error.what(), ::testing::HasSubstr("expected"));
    }
  }
}

}  // namespace
}  // namespace tessera
