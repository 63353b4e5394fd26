#include "bench/studio/page_client.h"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <cstring>

#include "base/error.h"
#include "base/monotonic.h"

namespace tessera {
namespace {

constexpr std::chrono::seconds kPatience{600};  // the machine may be busy
constexpr std::chrono::milliseconds kLongestWait{100};

template <class Number>
Number number_at(const std::string& frame, size_t offset) {
  Number number = 0;
  std::memcpy(&number, frame.data() + offset, sizeof number);
  return number;
}

nlohmann::json header_of(const std::string& frame) {
  constexpr size_t kHeader = 32;
  if (frame.size() < kHeader) throw render_error("a binary frame is shorter than its header");
  const auto flags = number_at<uint16_t>(frame, 30);
  return {{"pane", number_at<uint8_t>(frame, 6)},
          {"serial", number_at<uint32_t>(frame, 8)},
          {"width", number_at<uint16_t>(frame, 20)},
          {"height", number_at<uint16_t>(frame, 22)},
          {"version", number_at<uint32_t>(frame, 24)},
          {"ends_pass", (flags & 1) != 0},
          {"is_last", (flags & 2) != 0}};
}

}  // namespace

PageClient::PageClient(const StudioProcess& studio, Json hello)
    : check_(studio.check()),
      socket_(std::make_unique<WebSocketClient>(
          studio.address(), "/studio",
          WebSocketClient::Headers{.origin = "http://" + studio.address(),
                                   .subprotocol = "tessera-studio.1"})) {
  hello["token"] = studio.token();
  say("hello", hello);
}

void PageClient::say(std::string_view kind, const Json& fields) {
  socket_->send(Json{{std::string(kind), fields}}.dump());
}

PageClient::Json PageClient::receive(std::initializer_list<std::string_view> kinds,
                                     const Condition& is_so) {
  if (auto fields = receive_within(kinds, kPatience, is_so)) return std::move(*fields);
  throw render_error(fmt::format("the studio did not say '{}' within {} s",
                                 fmt::join(kinds, "', '"), kPatience.count()));
}

std::optional<PageClient::Json> PageClient::receive_within(
    std::initializer_list<std::string_view> kinds, std::chrono::nanoseconds patience,
    const Condition& is_so) {
  const auto is_meant = [&](const std::pair<std::string, Json>& message) {
    return std::find(kinds.begin(), kinds.end(), message.first) != kinds.end() &&
           (!is_so || is_so(message.second));
  };
  if (const auto found = std::find_if(kept_.begin(), kept_.end(), is_meant); found != kept_.end()) {
    Json fields = std::move(found->second);
    kept_.erase(found);
    return fields;
  }
  const Time end = monotonic_now() + patience;
  while (monotonic_now() < end) {
    check_();
    auto message = socket_->receive(std::min<Time>(end - monotonic_now(), kLongestWait));
    if (!message) continue;
    std::pair<std::string, Json> read;
    if (message->binary) {
      read = {"pixels", header_of(message->content)};
    } else {
      const Json all = Json::parse(message->content);
      read = {all.begin().key(), all.begin().value()};
    }
    if (is_meant(read)) return std::move(read.second);
    kept_.push_back(std::move(read));
  }
  return std::nullopt;
}

}  // namespace tessera
