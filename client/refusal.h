#pragma once

#include <string>

#include "base/error.h"
#include "base/monotonic.h"
#include "proto/tessera/v1/farm.pb.h"
#include "proto/transport/transport.h"

namespace tessera {

/// A usage error: a farm does not let us in, or refuses our key what was asked.
class RefusedError : public Error {
 public:
  explicit RefusedError(const std::string& message) : Error(ExitCode::bad_usage, message) {}
};

/// A render error: a farm cannot be reached, or fell silent.
class UnreachableError : public Error {
 public:
  explicit UnreachableError(const std::string& message) : Error(ExitCode::render_failed, message) {}
};

/// Throws usage_error where the host of the endpoint is certain to have no address.
void check_host_is_known(const std::string& endpoint);
/// Throws RefusedError if that is a coordinator's word that our key is not for what we asked.
void check_not_refused(const v1::Envelope& message, const std::string& endpoint);
/// Throws RefusedError if the coordinator at `endpoint` does not let us in.
void check_let_in(const ClientTransport& transport, const std::string& endpoint);
/// ": why" for what is wrong with the connection, as far as that is known.
std::string known_trouble(const ClientTransport& transport);

/// For a coordinator that has not been heard yet.
class FirstWord {
 public:
  explicit FirstWord(Time now) : look_(now + std::chrono::seconds(2)) {}
  void heard() { look_ = Time::max(); }
  /// Throws UnreachableError where it is certain that there is none: not at once, since it may be
  /// starting.
  void check(const std::string& endpoint, Time now);

 private:
  Time look_;
};

/// For a line that is away while the other one talks, so that nobody is silent.
class TroublePatience {
 public:
  TroublePatience(Time patience, Time now) : patience_(patience), last_fine_(now) {}
  /// `needed`: something is waited for now that the connection as it is may never bring. Throws
  /// render_error where that has been so for all the patience.
  void check(const ClientTransport& transport, const std::string& endpoint, bool needed, Time now);

 private:
  Time patience_, last_fine_;
};

}  // namespace tessera
