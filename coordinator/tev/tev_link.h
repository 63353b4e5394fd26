#pragma once

#include <condition_variable>
#include <cstddef>
#include <deque>
#include <mutex>
#include <string>
#include <thread>
#include <vector>

namespace tessera {

/// Bytes to a viewer over TCP, from a thread of its own, so that one that is slow, stalls or is not
/// there holds up nobody.
class TevLink {
 public:
  /// "HOST:PORT", the host of this machine, in digits or "localhost". Throws usage_error for any
  /// other text. A viewer that is not there is told of in the log, and tried again each second.
  explicit TevLink(const std::string& address);
  /// Waits for what is queued to be taken, for at most half a second.
  ~TevLink();
  TevLink(const TevLink&) = delete;
  TevLink& operator=(const TevLink&) = delete;

  /// Queues a message; false where as much waits as may.
  bool offer(std::vector<std::byte> message);
  /// How often it was connected: who is there anew knows of no image.
  uint64_t connections() const;

 private:
  void run();
  bool open_connection();
  bool send_all(const std::vector<std::byte>& message);
  /// Waits until the socket can be written to; false at the end of this, or of the connection.
  bool wait_writable();

  std::string host_;
  uint16_t port_;
  int socket_ = -1;
  mutable std::mutex mutex_;
  std::condition_variable changed_;
  std::deque<std::vector<std::byte>> queue_;
  size_t queued_bytes_ = 0;
  uint64_t connections_ = 0;
  bool ending_ = false;
  std::thread thread_;
};

}  // namespace tessera
