#pragma once

#include <string>

namespace tessera {

/// Whether it is certain that the host of a TCP endpoint has no address. May ask a name server, and
/// wait for it. False for what is no endpoint.
bool is_unknown_host(const std::string& endpoint);

/// Whether it is certain that nobody listens at an endpoint: each of its addresses refuses
/// connections, or there is no such socket. Takes up to half a second, and opens a connection where
/// somebody does listen. False for what is no endpoint.
bool nobody_listens(const std::string& endpoint);

}  // namespace tessera
