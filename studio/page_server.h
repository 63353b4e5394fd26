#pragma once

#include <filesystem>
#include <functional>
#include <memory>
#include <optional>
#include <string>

#include "studio/file_tasks.h"
#include "studio/picture_stream.h"
#include "studio/studio_session.h"
#include "web/public_address.h"

namespace tessera {

/// Something that a page did.
struct PageEvent {
  enum class Kind { connected, message, binary, closed };
  Kind kind = Kind::message;
  ClientId client = 0;
  std::string text;  ///< of a message; the bytes of a binary one
};

/// Serves the page's files and its WebSocket. Its functions may be called by any thread.
class PageServer {
 public:
  struct Options {
    std::string address;                            ///< empty: 127.0.0.1:7190 or the next free port
    std::filesystem::path token_file;               ///< empty: a new token is made
    std::optional<PublicAddress> public_address{};  ///< of a proxy before the page
  };
  /// Throws usage_error, also for an address that other machines reach without a token file.
  /// `take` is called on the server's thread, and must be quick.
  PageServer(const Options& options, std::function<void(PageEvent)> take);
  ~PageServer();
  PageServer(const PageServer&) = delete;
  PageServer& operator=(const PageServer&) = delete;

  std::string address() const;
  /// Where browsers find it: "http://127.0.0.1:7190/", or the public address.
  std::string url() const;
  /// Whether pages come from this machine alone.
  bool is_local() const;
  const std::string& token() const;
  StudioRole role_of(const std::string& token) const;

  void send(ClientId client, std::string text);
  void close(ClientId client, uint16_t code, const std::string& reason);
  /// Null where the page is gone.
  std::shared_ptr<PixelSink> sink_of(ClientId client) const;
  /// Ends all connections; nothing is taken any more.
  void stop();

 private:
  class Impl;
  std::shared_ptr<Impl> impl_;
};

}  // namespace tessera
