#pragma once

#include <nlohmann/json.hpp>
#include <string_view>

namespace tessera::page {

/// The JSON of a message: an object with one member that is an object. Throws wrong() for another,
/// or for more than the message may have.
nlohmann::json parse_object(std::string_view text);

}  // namespace tessera::page
