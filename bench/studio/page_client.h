#pragma once

#include <deque>
#include <functional>
#include <initializer_list>
#include <memory>
#include <nlohmann/json.hpp>
#include <optional>
#include <string>
#include <string_view>
#include <utility>

#include "bench/studio/studio_process.h"
#include "web/web_socket_client.h"

namespace tessera {

/// A page of a studio without a browser. Messages are what studio/page_message.h and
/// studio/page_answer.h say; of binary frames (studio/pixel_frame.h) the header alone is kept, as a
/// message "pixels".
class PageClient {
 public:
  using Json = nlohmann::json;
  using Condition = std::function<bool(const Json&)>;

  /// Connects and says hello, with more fields than the token where there are any.
  explicit PageClient(const StudioProcess& studio, Json hello = Json::object());

  void say(std::string_view kind, const Json& fields);
  /// The fields of the next message of one of these kinds that is so; others are kept for later.
  /// Throws render_error where none comes in time.
  Json receive(std::initializer_list<std::string_view> kinds, const Condition& is_so = {});
  /// Likewise, or nothing once that time is over.
  std::optional<Json> receive_within(std::initializer_list<std::string_view> kinds,
                                     std::chrono::nanoseconds patience,
                                     const Condition& is_so = {});
  /// Drops what was kept.
  void forget() { kept_.clear(); }
  /// What was kept, by kind.
  const std::deque<std::pair<std::string, Json>>& kept() const { return kept_; }

 private:
  std::function<void()> check_;
  std::unique_ptr<WebSocketClient> socket_;
  std::deque<std::pair<std::string, Json>> kept_;
};

}  // namespace tessera
