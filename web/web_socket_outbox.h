#pragma once

#include <deque>
#include <functional>
#include <memory>
#include <mutex>
#include <optional>
#include <string>
#include <utility>

#include "web/web_socket.h"

namespace tessera {

/// The messages that wait to be sent over one WebSocket, between any threads and the server's.
class WebSocketOutbox : public WebSocket {
 public:
  struct Closing {
    uint16_t code = 0;
    std::string reason;
  };
  /// At most one of the two is there.
  struct Next {
    std::shared_ptr<const std::string> message;
    bool binary = false;
    std::optional<Closing> closing;
  };

  /// `wake` is called on any thread when there is something to take and nobody takes it.
  WebSocketOutbox(size_t most_bytes, std::function<void()> wake)
      : most_bytes_(most_bytes), wake_(std::move(wake)) {}

  bool send(std::shared_ptr<const std::string> message, bool binary) override;
  size_t queued_bytes() const override;
  void close(uint16_t code, std::string_view reason) override;
  bool is_open() const override;

  /// The next thing to send. Where there is none, `wake` will be called. To be called when the
  /// message before was sent; its bytes are counted as queued until then.
  Next take();
  /// Drops what is queued and takes nothing more.
  void end();

 private:
  void wake_up(std::unique_lock<std::mutex> lock);

  const size_t most_bytes_;
  const std::function<void()> wake_;
  mutable std::mutex mutex_;
  std::deque<Next> queue_;
  size_t queued_bytes_ = 0, taken_bytes_ = 0;  ///< the former counts the latter
  std::optional<Closing> closing_;
  bool ended_ = false;
  bool is_taken_from_ = false;  ///< take() was or will be called since the last `wake`
};

}  // namespace tessera
