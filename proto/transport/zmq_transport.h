#pragma once

#include <memory>
#include <string>

#include "proto/transport/transport.h"

namespace tessera {

/// Binds control and bulk sockets. `endpoint` is ipc://PATH or tcp://HOST:PORT (PORT `*` or 0: any
/// that is free). Blobs are at PATH.bulk, or at PORT + 1 (any, where PORT is). Throws usage_error
/// for an endpoint that is malformed, in use, or not loopback, and for a path at which there is
/// something else than a socket. Its sockets' files are removed with it.
std::unique_ptr<ServerTransport> bind_server(const std::string& endpoint);

/// Connects in the background and again whenever the connection is lost; whether anybody answers is
/// for the caller to find out. Throws usage_error for a malformed endpoint.
std::unique_ptr<ClientTransport> connect_client(const std::string& endpoint);

}  // namespace tessera
