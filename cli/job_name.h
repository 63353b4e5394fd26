#pragma once

#include <string>

#include "client/farm_client.h"
#include "proto/tessera/v1/farm.pb.h"

namespace CLI {
class App;
}

namespace tessera {

inline constexpr char kDefaultEndpoint[] = "tcp://127.0.0.1:7117";

/// Adds --connect; `endpoint` must outlive the parsing.
void add_connect_option(CLI::App& command, std::string& endpoint);

/// The number of the job that `text` means: its number, or the name of the latest that has it.
/// Throws usage_error, with the nearest name, where there is none.
uint64_t find_job(FarmClient& client, const std::string& text);

}  // namespace tessera
