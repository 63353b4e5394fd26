#pragma once

#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "proto/transport/allow_list.h"
#include "proto/transport/keys.h"
#include "proto/transport/resolve_host.h"
#include "proto/transport/transport.h"

namespace tessera {

/// Who may come to a server.
struct ServerSecurity {
  /// With them, both sockets speak CURVE and admit nobody but who is on the list. Without them,
  /// everybody who can reach the endpoint is let in.
  std::optional<KeyPair> keys;
  AllowList allowed;
  bool insecure = false;  ///< whether other machines may reach it though there are no keys
};

/// Binds control and bulk sockets. `endpoint` is ipc://PATH or tcp://HOST:PORT (PORT `*` or 0: any
/// that is free; HOST a name, an address, `*` for all addresses of both families, or an interface).
/// Blobs are at PATH.bulk, or at PORT + 1 (any, where PORT is). Throws usage_error
/// for an endpoint that is malformed, in use, or neither loopback nor protected, and for a path at
/// which there is something else than a socket. Its sockets' files are removed with it.
std::unique_ptr<ServerTransport> bind_server(const std::string& endpoint,
                                             ServerSecurity security = {});

/// An endpoint of a server, and who may come there.
struct ServerDoor {
  std::string endpoint;
  ServerSecurity security{};
};
/// The same with several endpoints; the first one is endpoint() and bulk_endpoint(). Names
/// of peers tell by which of them they came. set_allowed() is for those that have keys.
std::unique_ptr<ServerTransport> bind_servers(std::vector<ServerDoor> doors);

/// Who a client is, and whom it talks to.
struct ClientKeys {
  KeyPair own;
  Key server{};  ///< the public one: nobody else can answer
};

/// Connects in the background and again whenever the connection is lost; whether anybody answers is
/// for the caller to find out. Throws usage_error for a malformed endpoint. A host's name is given
/// to `resolve`, on threads of their own, again whenever there is no connection.
std::unique_ptr<ClientTransport> connect_client(const std::string& endpoint,
                                                const std::optional<ClientKeys>& keys = {},
                                                ResolveHost resolve = resolve_by_system);

}  // namespace tessera
