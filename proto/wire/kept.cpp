#include "proto/wire/kept.h"

#include <limits>

namespace tessera {
namespace {

template <typename Message>
std::optional<Message> parse(std::string_view bytes) {
  Message message;
  const bool fits = bytes.size() <= static_cast<size_t>(std::numeric_limits<int>::max());
  if (!fits || !message.ParseFromArray(bytes.data(), static_cast<int>(bytes.size()))) {
    return std::nullopt;
  }
  return message;
}

}  // namespace

std::optional<v1::KeptTile> parse_kept_tile(std::string_view bytes) {
  return parse<v1::KeptTile>(bytes);
}

std::optional<v1::KeptJob> parse_kept_job(std::string_view bytes) {
  return parse<v1::KeptJob>(bytes);
}

std::optional<v1::JobEnd> parse_job_end(std::string_view bytes) { return parse<v1::JobEnd>(bytes); }

}  // namespace tessera
