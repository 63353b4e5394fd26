#include "web/http_message.h"

namespace tessera {

std::string HttpRequest::header(const std::string& name) const {
  const auto it = headers.find(name);
  return it == headers.end() ? "" : it->second;
}

void split_target(const std::string& target, HttpRequest& request) {
  const size_t mark = target.find('?');
  request.path = target.substr(0, mark);
  if (mark == std::string::npos) return;
  for (size_t at = mark + 1; at <= target.size();) {
    const size_t end = std::min(target.find('&', at), target.size());
    const std::string part = target.substr(at, end - at);
    const size_t equals = part.find('=');
    if (!part.empty()) {
      request.query[part.substr(0, equals)] =
          equals == std::string::npos ? "" : part.substr(equals + 1);
    }
    at = end + 1;
  }
}

}  // namespace tessera
