#include "web/web_socket_outbox.h"

namespace tessera {
namespace {

constexpr size_t kLongestReason = 123;  // RFC 6455, 5.5

/// Of UTF-8 text, no more than the reason of a close frame may have, and no part of a character.
std::string_view shortened(std::string_view text) {
  if (text.size() <= kLongestReason) return text;
  size_t size = kLongestReason;
  while (size > 0 && (static_cast<unsigned char>(text[size]) & 0xC0) == 0x80) --size;
  return text.substr(0, size);
}

}  // namespace

bool WebSocketOutbox::send(std::shared_ptr<const std::string> message, bool binary) {
  std::unique_lock lock(mutex_);
  if (ended_ || closing_ || queued_bytes_ >= most_bytes_) return false;
  queued_bytes_ += message->size();
  queue_.push_back({std::move(message), binary, std::nullopt});
  wake_up(std::move(lock));
  return true;
}

size_t WebSocketOutbox::queued_bytes() const {
  const std::lock_guard lock(mutex_);
  return queued_bytes_;
}

void WebSocketOutbox::close(uint16_t code, std::string_view reason) {
  std::unique_lock lock(mutex_);
  if (ended_ || closing_) return;
  closing_ = Closing{code, std::string(shortened(reason))};
  wake_up(std::move(lock));
}

bool WebSocketOutbox::is_open() const {
  const std::lock_guard lock(mutex_);
  return !ended_ && !closing_;
}

WebSocketOutbox::Next WebSocketOutbox::take() {
  const std::lock_guard lock(mutex_);
  queued_bytes_ -= std::exchange(taken_bytes_, 0);
  if (ended_) return {};
  if (queue_.empty()) {
    // Who closes has taken the last.
    is_taken_from_ = closing_.has_value();
    return {nullptr, false, closing_};
  }
  Next next = std::move(queue_.front());
  queue_.pop_front();
  taken_bytes_ = next.message->size();
  return next;
}

void WebSocketOutbox::end() {
  const std::lock_guard lock(mutex_);
  ended_ = true;
  queue_.clear();
  queued_bytes_ = taken_bytes_ = 0;
}

void WebSocketOutbox::wake_up(std::unique_lock<std::mutex> lock) {
  if (std::exchange(is_taken_from_, true)) return;
  lock.unlock();
  wake_();
}

}  // namespace tessera
