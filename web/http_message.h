#pragma once

#include <functional>
#include <map>
#include <memory>
#include <string>
#include <utility>
#include <vector>

namespace tessera {

/// A request that was read whole, within the limits of WebServer.
struct HttpRequest {
  std::string method;                          ///< "GET", "HEAD", "POST" ...
  std::string path;                            ///< without the query
  std::map<std::string, std::string> query;    ///< as it came: numbers need no unescaping
  std::map<std::string, std::string> headers;  ///< by lower-case name
  std::string body;

  /// Empty where it did not come.
  std::string header(const std::string& name) const;
};

struct HttpResponse {
  int status = 200;
  std::string type = "application/json";
  /// Shared by all who are sent the same.
  std::shared_ptr<const std::string> body;
  /// They replace those of that name which the server sets, such as Content-Security-Policy.
  std::vector<std::pair<std::string, std::string>> headers{};
};

/// What makes a response is called on the server's thread.
using HttpReply = std::function<void(std::function<HttpResponse()>)>;
/// Answers by calling the reply once, at once or later, on any thread.
using HttpHandler = std::function<void(HttpRequest, HttpReply)>;

/// "/a?b=1&c" in its parts.
void split_target(const std::string& target, HttpRequest& request);

}  // namespace tessera
