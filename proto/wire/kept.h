#pragma once

#include <optional>
#include <string_view>

#include "proto/tessera/v1/farm.pb.h"

namespace tessera {

/// From what SerializeAsString() made of them; nothing if that is damaged.
std::optional<v1::KeptTile> parse_kept_tile(std::string_view bytes);
std::optional<v1::KeptJob> parse_kept_job(std::string_view bytes);
std::optional<v1::JobEnd> parse_job_end(std::string_view bytes);

}  // namespace tessera
