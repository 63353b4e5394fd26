#include "studio/page_server.h"

#include <gtest/gtest.h>

#include "tests/unit/web/web_socket_fixture.h"

namespace tessera {
namespace {

/// What a server passes on of its pages.
class PageServerTest : public ::testing::Test {
 protected:
  /// Waits for what is to come.
  template <typename Condition>
  bool wait(Condition condition) {
    std::unique_lock lock(mutex_);
    return changed_.wait_for(lock, std::chrono::seconds(60), condition);
  }
  size_t bytes() const {
    size_t sum = 0;
    for (const PageEvent& event : events_) sum += event.text.size();
    return sum;
  }
  bool is_closed() const {
    return !events_.empty() && events_.back().kind == PageEvent::Kind::closed;
  }

  std::mutex mutex_;
  std::condition_variable changed_;
  std::vector<PageEvent> events_;
  PageServer server_{{.address = "127.0.0.1:0", .token_file = {}}, [this](PageEvent event) {
                       const std::lock_guard lock(mutex_);
                       events_.push_back(std::move(event));
                       changed_.notify_all();
                     }};
};

TEST_F(PageServerTest, LittleIsQueuedOfAPageThatIsNotKnown) {
  testing::WebSocketClient client(server_.address(), false, "/studio", "tessera-studio.1");
  const std::string part(StudioSession::kMostHelloBytes / 4, 'x');
  for (int i = 0; i < 16; ++i) client.send(part);
  EXPECT_EQ(client.receive(), "closed 4401 expected hello");
  ASSERT_TRUE(wait([&] { return is_closed(); }));
  EXPECT_EQ(bytes(), StudioSession::kMostHelloBytes);
}

TEST_F(PageServerTest, AllIsQueuedOfOneThatWasAnswered) {
  testing::WebSocketClient client(server_.address(), false, "/studio", "tessera-studio.1");
  client.send("hello");
  ASSERT_TRUE(wait([&] { return bytes() == 5; }));
  server_.send(events_.back().client, "welcome");
  const std::string part(StudioSession::kMostHelloBytes, 'x');
  for (int i = 0; i < 4; ++i) client.send(part);
  EXPECT_TRUE(wait([&] { return bytes() == 5 + 4 * part.size(); }));
}

}  // namespace
}  // namespace tessera
