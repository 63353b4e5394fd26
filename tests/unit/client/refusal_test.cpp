#include "client/refusal.h"

#include <gtest/gtest.h>
#include <sys/socket.h>
#include <sys/un.h>
#include <unistd.h>

#include <chrono>
#include <cstring>
#include <filesystem>

#include "base/error.h"

namespace tessera {
namespace {

using namespace std::chrono_literals;

constexpr const char* kNobody = "ipc:///nowhere/farm";

/// A connection that failed so many times for that reason.
class FakeTransport final : public ClientTransport {
 public:
  explicit FakeTransport(int failed = 0) : failed_(failed) {}
  void connect_bulk(const std::string&) override {}
  void wait(std::chrono::milliseconds) override {}
  std::optional<ReceivedMessage> receive() override { return std::nullopt; }
  void send(Channel, MessageBytes) override {}
  void reconnect() override {}
  void wake() override {}
  std::optional<ConnectionTrouble> trouble() const override {
    if (failed_ == 0) return std::nullopt;
    return ConnectionTrouble{.why = "it has another key", .attempts = failed_};
  }

 private:
  int failed_;
};

TEST(FirstWord, TellsAfterTwoSecondsWhyNoConnectionCameAboutThoughItWasTriedOften) {
  FirstWord first_word(1h);
  // Something may listen there, which is looked at only where nothing else is known.
  EXPECT_NO_THROW(first_word.check(FakeTransport(3), kNobody, 1h + 1999ms));
  try {
    first_word.check(FakeTransport(3), kNobody, 1h + 2s);
    ADD_FAILURE() << "nothing was thrown";
  } catch (const UnreachableError& error) {
    EXPECT_STREQ(error.what(),
                 "no connection to the coordinator at ipc:///nowhere/farm: it has another key");
  }
}

TEST(FirstWord, TellsAfterTwoSecondsThatNobodyListens) {
  const Time begin = 1h;
  FirstWord first_word(begin);
  const FakeTransport transport;
  EXPECT_NO_THROW(first_word.check(transport, kNobody, begin));
  for (const Time look : {500ms, 1000ms, 1500ms, 1999ms})
    EXPECT_NO_THROW(first_word.check(transport, kNobody, begin + look));
  EXPECT_THROW(first_word.check(transport, kNobody, begin + 2s), Error);
}

TEST(FirstWord, WaitsForACoordinatorThatStartsAnew) {
  const Time begin = 1h;
  FirstWord first_word(begin);
  const FakeTransport transport;
  const std::filesystem::path socket =
      std::filesystem::temp_directory_path() / ("tessera-first-word-" + std::to_string(::getpid()));
  const std::string endpoint = "ipc://" + socket.string();
  const auto listen = [&] {
    const int file = ::socket(AF_UNIX, SOCK_STREAM, 0);
    sockaddr_un address{.sun_family = AF_UNIX, .sun_path = {}};
    std::strcpy(address.sun_path, socket.c_str());
    ::bind(file, reinterpret_cast<const sockaddr*>(&address), sizeof address);
    ::listen(file, 9);
    return file;
  };
  const int before = listen();
  EXPECT_NO_THROW(first_word.check(transport, endpoint, begin + 3s));
  ::close(before);
  std::filesystem::remove(socket);
  EXPECT_NO_THROW(first_word.check(transport, endpoint, begin + 5s));
  EXPECT_NO_THROW(first_word.check(transport, endpoint, begin + 6s));
  const int after = listen();
  EXPECT_NO_THROW(first_word.check(transport, endpoint, begin + 7s));
  ::close(after);
  std::filesystem::remove(socket);
  for (const Time look : {9s, 10s, 11s})
    EXPECT_NO_THROW(first_word.check(transport, endpoint, begin + look));
  EXPECT_THROW(first_word.check(transport, endpoint, begin + 12s), UnreachableError);
}

TEST(TroublePatience, TimeInWhichNobodyLookedDoesNotCount) {
  TroublePatience patience(10s, 1h);
  patience.check(FakeTransport(1), kNobody, true, 1h);
  Time now = 2h;
  for (; now < 2h + 10s; now += 500ms)
    EXPECT_NO_THROW(patience.check(FakeTransport(1), kNobody, true, now));
  EXPECT_THROW(patience.check(FakeTransport(1), kNobody, true, now + 500ms), UnreachableError);
}

TEST(FirstWord, OnceHeardIsNotWaitedForAgain) {
  FirstWord first_word(1h);
  first_word.heard();
  EXPECT_NO_THROW(first_word.check(FakeTransport(), kNobody, 24h));
}

}  // namespace
}  // namespace tessera
