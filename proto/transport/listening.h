#pragma once

#include <optional>
#include <string>
#include <vector>

#include "proto/transport/transport.h"

namespace tessera {

/// Whether it is certain that nobody listens at an endpoint: its address refuses connections, or
/// there is no such socket. Takes up to half a second, and opens a connection where somebody does
/// listen. Asks no name server: false for a host that is given by name, as for what is no endpoint.
bool nobody_listens(const std::string& endpoint);

/// "ENDPOINT, which is ADDRESS" where its host has a name and the address of that is known, for
/// messages.
std::string with_address(const std::string& endpoint, const ClientTransport& transport);

/// Which of a host's addresses takes a connection first.
struct ConnectionRace {
  std::optional<size_t> winner{};
  std::vector<std::string> failures{};  ///< of each address, in order, where there is no winner
};

/// Connects to the addresses (as Endpoint::host spells them) one after the other, a quarter of a
/// second apart or as soon as those before have failed, and closes all connections again: RFC 8305,
/// section 5. Takes up to 3 s after the last began. Blocks.
ConnectionRace race(const std::vector<std::string>& addresses, int port);

}  // namespace tessera
