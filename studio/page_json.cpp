#include "studio/page_json.h"

#include <fmt/format.h>

#include <algorithm>

#include "studio/page_fields.h"

namespace tessera::page {
namespace {

constexpr int kMostDepth = 32;
constexpr size_t kMostBytes = size_t{1} << 20;   ///< of what carries no text
constexpr size_t kMostValues = size_t{4} << 20;  ///< also beginnings and ends of lists

/// The kind that a message begins with; empty where it does not begin as one.
std::string_view kind_at_beginning(std::string_view text) {
  const auto skip = [&text](char wanted) {
    const size_t at = text.find_first_not_of(" \t\r\n");
    const bool is_there = at != std::string_view::npos && text[at] == wanted;
    if (is_there) text.remove_prefix(at + 1);
    return is_there;
  };
  return skip('{') && skip('"') ? text.substr(0, text.find('"')) : std::string_view();
}

}  // namespace

nlohmann::json parse_object(std::string_view text) {
  // Whoever waits for the program waits while this is read.
  if (text.size() > kMostBytes && kind_at_beginning(text) != "edit")
    throw wrong("message", fmt::format("{} bytes", text.size()),
                fmt::format("at most {}, but for an edit", kMostBytes));
  int depth = 0;
  size_t values = 0;
  const auto watch = [&](int at, nlohmann::json::parse_event_t, nlohmann::json&) {
    depth = std::max(depth, at);
    if (depth > kMostDepth)
      throw wrong("message", "nested too deep", fmt::format("at most {} levels", kMostDepth));
    if (++values > kMostValues)
      throw wrong("message", "more values", fmt::format("at most {}", kMostValues));
    return true;
  };
  nlohmann::json json = nlohmann::json::parse(text, watch, false);
  if (!json.is_object() || json.size() != 1 || !json.begin()->is_object())
    throw wrong("message", "something else", "an object with one member that is an object");
  return json;
}

}  // namespace tessera::page
