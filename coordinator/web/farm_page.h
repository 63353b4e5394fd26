#pragma once

#include <atomic>
#include <filesystem>
#include <memory>
#include <optional>
#include <string>

#include "base/monotonic.h"
#include "web/public_address.h"

namespace tessera {

class Coordinator;
class FarmMonitor;
class WebApi;
class WebServer;

/// The web page of a coordinator, from its options to its socket.
class FarmPage {
 public:
  struct Options {
    std::string address;                            ///< as for WebServer
    std::filesystem::path token_file;               ///< as for WebAccess; empty: none
    std::optional<PublicAddress> public_address{};  ///< of a proxy before it
    bool has_keys = false;  ///< the farm lets in by keys alone, so the page does too
    const std::atomic<bool>* stopping = nullptr;  ///< it outlives the page
  };
  /// Binds the address, and begins to answer. To be called after logging was configured and before
  /// other threads are started. Throws usage_error where tokens are needed and none are given: at
  /// an address, its own or the public one, that other machines can reach, and where the farm has
  /// keys.
  explicit FarmPage(const Options& options);
  ~FarmPage();

  /// Shows the farm: to be called often on the coordinator's thread.
  void look(Coordinator& coordinator, Time now);
  /// Takes up the tokens as their file has them now. Throws usage_error, and changes nothing, where
  /// that is wrong.
  void read_tokens_again();
  /// "127.0.0.1:8080", as it was bound.
  std::string address() const;
  /// Where browsers find it: "http://127.0.0.1:8080/", or the public address.
  std::string url() const;

 private:
  std::shared_ptr<FarmMonitor> monitor_;
  Options options_;
  std::unique_ptr<WebApi> api_;
  std::unique_ptr<WebServer> server_;
};

}  // namespace tessera
