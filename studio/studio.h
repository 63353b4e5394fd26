#pragma once

#include <filesystem>
#include <functional>
#include <memory>
#include <optional>
#include <string>

#include "base/monotonic.h"
#include "front/farm_connection.h"
#include "web/public_address.h"

namespace tessera {

class Coordinator;
class LogRing;

struct StudioOptions {
  std::filesystem::path folder;  ///< to open
  std::string file;              ///< in it, to open first; empty: none
  std::string assets;            ///< as of ReadOptions; empty: the folder
  std::string address;           ///< "ADDRESS:PORT"; empty: 127.0.0.1:7190 or the next free port
  std::filesystem::path token_file;               ///< as for WebAccess; empty: a new token is made
  std::optional<PublicAddress> public_address{};  ///< of a proxy before the page
  bool is_read_only = false;
  int workers = 0;                       ///< threads that trace, for the page to tell
  std::string worker_command{};          ///< that has another process trace for this studio
  FarmConnection farm{};                 ///< that traces full pictures; no endpoint: none does
  std::shared_ptr<const LogRing> log{};  ///< for the page's console; null: it shows none
};

/// The studio from its options to its socket: the page's server, its state machine and the threads
/// that read scenes, make pictures and touch files. It renders by a coordinator of this process,
/// which shows itself by look(), but full pictures by a farm elsewhere where it is given one. No
/// thread of it waits for another.
class Studio {
 public:
  /// Binds the address and begins to answer. Throws usage_error for options that do not go
  /// together. `wake` is called by any thread when look() is to be called soon.
  Studio(const StudioOptions& options, std::function<void()> wake);
  ~Studio();
  Studio(const Studio&) = delete;
  Studio& operator=(const Studio&) = delete;

  /// Where browsers find the page: "http://127.0.0.1:7190/", or the public address.
  std::string url() const;
  /// The one that was made; empty where they were read from a file.
  const std::string& token() const;

  /// To be called on the coordinator's thread, often and after `wake`: takes what has come in, has
  /// passes traced, and sends what they became.
  void look(Coordinator& coordinator, Time now);

 private:
  class Impl;
  std::unique_ptr<Impl> impl_;
};

}  // namespace tessera
