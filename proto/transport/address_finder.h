#pragma once

#include <cstddef>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "base/monotonic.h"
#include "proto/transport/endpoint.h"
#include "proto/transport/resolve_host.h"
#include "proto/transport/transport.h"
#include "proto/transport/zmq_sockets.h"

namespace tessera {

/// Finds the address by which the host of an endpoint is reached, without ever waiting: names are
/// resolved, and of several addresses the first that takes a connection is found, on threads that
/// do nothing else. The last address stays until another one is better, whatever becomes of the
/// name servers. Internal to proto/transport; used by the socket's thread.
class AddressFinder {
 public:
  /// Begins to look, where the endpoint has a name. `wake` is woken when update() has news.
  AddressFinder(Endpoint endpoint, ResolveHost resolve, std::shared_ptr<WakeUp> wake, Time now);

  /// Where to connect to; nullopt while no address of the name is known.
  const std::optional<Endpoint>& address() const { return address_; }
  /// Takes notice of what was found, and looks again from time to time while there is no
  /// connection. Returns whether address() is another one than before.
  bool update(bool connected, Time now);
  /// What is wrong with the name or its addresses, for who has no connection.
  std::optional<ConnectionTrouble> trouble(Time now) const;

 private:
  struct Lookup;
  void look(Time now);
  /// Returns whether address() is another one now.
  bool take(const Lookup& lookup, bool connected, Time now);
  /// What messages tell of it; empty where there is none.
  std::string last_address() const;

  Endpoint endpoint_;
  ResolveHost resolve_;
  std::shared_ptr<WakeUp> wake_;
  std::optional<Endpoint> address_;
  std::optional<std::string> good_;  ///< the last host of address_ by which there was a connection
  /// Those that have not come back, oldest first.
  std::vector<std::shared_ptr<Lookup>> lookups_;
  std::optional<Time> asked_;     ///< since when there was no answer
  Time next_look_ = Time::max();  ///< max(): never, as there is no name
  Time pause_;
  bool is_unknown_ = false;
  std::string why_;
};

}  // namespace tessera
