#pragma once

#include <memory>
#include <string>

#include "base/error.h"
#include "base/monotonic.h"
#include "base/silence.h"
#include "proto/tessera/v1/farm.pb.h"
#include "proto/transport/transport.h"

namespace tessera {

/// What a farm does to us, and the endpoint of its coordinator.
class FarmError : public Error {
 public:
  FarmError(ExitCode code, const std::string& endpoint, const std::string& message)
      : Error(code, message), endpoint_(std::make_shared<const std::string>(endpoint)) {}
  const std::string& endpoint() const { return *endpoint_; }

 private:
  std::shared_ptr<const std::string> endpoint_;  ///< so that copying throws nothing
};

/// A usage error: a farm does not let us in, or refuses our key what was asked.
class RefusedError : public FarmError {
 public:
  RefusedError(const std::string& endpoint, const std::string& message)
      : FarmError(ExitCode::bad_usage, endpoint, message) {}
};

/// A render error: a farm cannot be reached, or fell silent.
class UnreachableError : public FarmError {
 public:
  UnreachableError(const std::string& endpoint, const std::string& message)
      : FarmError(ExitCode::render_failed, endpoint, message) {}
};

/// Throws RefusedError if that is a coordinator's word that our key is not for what we asked.
void check_not_refused(const v1::Envelope& message, const std::string& endpoint);
/// Throws RefusedError if the coordinator at `endpoint` does not let us in, and a plain usage_error
/// where its host is certain to have no address.
void check_let_in(const ClientTransport& transport, const std::string& endpoint);
/// ": why" for what is wrong with the connection, as far as that is known.
std::string known_trouble(const ClientTransport& transport);

/// For a coordinator that has not been heard yet.
class FirstWord {
 public:
  explicit FirstWord(Time now)
      : earliest_end_(now + std::chrono::seconds(2)), next_look_(now + kSoon) {}
  void heard() { next_look_ = Time::max(); }
  /// Throws UnreachableError where it is certain that none will answer: nothing listens, or what
  /// does failed to agree with us on a connection several times. After 2 s at the earliest, since
  /// it may be starting, and where nothing listened at four looks in a row, half a second apart.
  void check(const ClientTransport& transport, const std::string& endpoint, Time now);

 private:
  static constexpr Time kSoon = std::chrono::milliseconds(500);

  Time earliest_end_, next_look_;
  int looks_at_nobody_ = 0;  ///< in a row, up to now
};

/// For a line that is away while the other one talks, so that nobody is silent.
class TroublePatience {
 public:
  TroublePatience(Time patience, Time now) : patience_(patience), trouble_(now), last_look_(now) {}
  /// `needed`: something is waited for now that the connection as it is may never bring. Throws
  /// render_error where that has been so for all the patience.
  void check(const ClientTransport& transport, const std::string& endpoint, bool needed, Time now);

 private:
  /// Where looks are farther apart, this process did not run, or nothing was waited for.
  static constexpr Time kBetweenLooks = std::chrono::seconds(2);

  Time patience_;
  Silence trouble_;
  Time last_look_;
};

}  // namespace tessera
