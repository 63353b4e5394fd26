#include "web/web_access.h"

#include <fmt/format.h>
#include <sys/stat.h>

#include <algorithm>
#include <fstream>
#include <nlohmann/json.hpp>
#include <sstream>

#include "base/error.h"
#include "base/lower_case.h"
#include "proto/wire/printable.h"

namespace tessera {
namespace {

constexpr size_t kShortestToken = 16;
constexpr std::string_view kBearer = "bearer ";

/// The type of "type/subtype; parameters" in lower case, without spaces around it.
std::string media_type(const std::string& header) {
  const std::string type = lower_case(header.substr(0, header.find(';')));
  const size_t begin = type.find_first_not_of(" \t");
  if (begin == std::string::npos) return {};
  return type.substr(begin, type.find_last_not_of(" \t") + 1 - begin);
}

}  // namespace

HttpResponse http_error(int status, const std::string& what) {
  const nlohmann::json body{{"error", what}};
  return {status,
          "application/json",
          std::make_shared<const std::string>(
              body.dump(-1, ' ', false, nlohmann::json::error_handler_t::replace) + "\n"),
          {}};
}

WebAccess WebAccess::read(const std::filesystem::path& path) {
  std::ifstream file(path);
  struct stat about {};
  if (!file || stat(path.c_str(), &about) != 0) {
    throw usage_error(fmt::format("--http-token: '{}' cannot be read", path.string()));
  }
  // A group may read it: that is how secrets come into a container.
  if ((about.st_mode & S_IRWXO) != 0) {
    throw usage_error(fmt::format(
        "--http-token: '{}' can be read by every user; expected mode 0600", path.string()));
  }
  WebAccess access;
  access.is_reached_by_any_name_ = true;
  int number = 0;
  for (std::string line; std::getline(file, line);) {
    ++number;
    std::istringstream words(line);
    std::string token, role, name;
    if (!(words >> token) || token.front() == '#') continue;
    words >> role >> name;
    const auto wrong = [&](const std::string& what) {
      return usage_error(fmt::format("{}:{}: {}", path.string(), number, what));
    };
    if (token.size() < kShortestToken) {
      throw wrong(fmt::format("a token of {} characters; expected at least {}", token.size(),
                              kShortestToken));
    }
    if (role != "viewer" && role != "submitter") {
      throw wrong(fmt::format("role '{}'; expected viewer or submitter", printable(role)));
    }
    access.tokens_.push_back(
        {Digest::of(token), role == "viewer" ? Role::viewer : Role::submitter, name});
  }
  if (access.tokens_.empty()) {
    throw usage_error(fmt::format("--http-token: '{}' has no token; expected lines TOKEN ROLE NAME",
                                  path.string()));
  }
  return access;
}

WebAccess WebAccess::of_token(std::string_view token, Role role) {
  WebAccess access;
  access.tokens_.push_back({Digest::of(token), role, ""});
  return access;
}

const WebAccess::Token* WebAccess::token_of(const HttpRequest& request) const {
  const std::string header = request.header("authorization");
  // The name of the scheme is taken in any case (RFC 9110, 11.1), the token as it is.
  if (lower_case(header.substr(0, kBearer.size())) != kBearer) return nullptr;
  return find(std::string_view(header).substr(kBearer.size()));
}

const WebAccess::Token* WebAccess::find(std::string_view token) const {
  const Digest digest = Digest::of(token);
  const auto it = std::find_if(tokens_.begin(), tokens_.end(),
                               [&](const Token& known) { return known.digest == digest; });
  return it == tokens_.end() ? nullptr : &*it;
}

std::optional<WebAccess::Role> WebAccess::role_of(std::string_view token) const {
  const Token* const known = find(token);
  return known ? std::optional(known->role) : std::nullopt;
}

std::string WebAccess::name_of(const HttpRequest& request) const {
  const Token* const known = token_of(request);
  return known ? printable(known->name) : "";
}

std::optional<HttpResponse> WebAccess::refuse_host(const HttpRequest& request) const {
  if (is_reached_by_any_name_) return std::nullopt;
  const std::string host = host_of(lower_case(request.header("host")));
  if (names_this_machine(host) || (public_ && host == public_->host)) return std::nullopt;
  return http_error(421, fmt::format("this page answers to 127.0.0.1, [::1]{} and localhost alone",
                                     public_ ? ", " + public_->host : ""));
}

bool WebAccess::is_of_own_page(const HttpRequest& request) const {
  const std::string origin = lower_case(request.header("origin"));
  const std::string host = lower_case(request.header("host"));
  if (host.empty()) return false;
  if (public_ && origin == public_->origin) return true;
  if (public_ && host_of(host) == public_->host) return false;  // by another scheme or port
  return origin == "http://" + host || (is_reached_by_any_name_ && origin == "https://" + host);
}

std::optional<HttpResponse> WebAccess::refuse_upgrade(const HttpRequest& request) const {
  if (auto refused = refuse_host(request)) return refused;
  if (is_of_own_page(request)) return std::nullopt;
  return http_error(403, "WebSockets are opened by our own page alone");
}

std::optional<HttpResponse> WebAccess::refuse(const HttpRequest& request, Role needed) const {
  if (auto refused = refuse_host(request)) return refused;
  if (!tokens_.empty()) {
    const Token* const token = token_of(request);
    if (!token) {
      HttpResponse response = http_error(401, "expected a token: Authorization: Bearer TOKEN");
      response.headers.emplace_back("WWW-Authenticate", "Bearer");
      return response;
    }
    if (needed == Role::submitter && token->role == Role::viewer) {
      return http_error(403, "the token is a viewer's; expected a submitter's");
    }
  }
  if (needed == Role::viewer) return std::nullopt;
  // What another site has a browser send is of a simple type, or names that site.
  if (!request.header("origin").empty() && !is_of_own_page(request)) {
    return http_error(403, "orders are taken from our own page alone");
  }
  if (media_type(request.header("content-type")) != "application/json") {
    return http_error(415, "expected Content-Type: application/json");
  }
  return std::nullopt;
}

}  // namespace tessera
