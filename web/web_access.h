#pragma once

#include <filesystem>
#include <optional>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "base/digest.h"
#include "web/http_message.h"
#include "web/public_address.h"

namespace tessera {

/// Who may see the page, and who may order something by it. Without tokens: whoever reaches it, as
/// long as it calls us by a name of this machine, so that no site that a browser shows can reach us
/// under a name of its own.
class WebAccess {
 public:
  enum class Role { viewer, submitter };

  /// No tokens.
  WebAccess() = default;
  /// The tokens of a file of lines "TOKEN ROLE NAME", ROLE being viewer or submitter. Throws
  /// usage_error with its place where it is wrong, or can be read by everybody.
  static WebAccess read(const std::filesystem::path& file);
  /// One token, beside which the name of this machine is needed as without tokens.
  static WebAccess of_token(std::string_view token, Role role);

  /// Takes pages of that address, which a proxy serves, for our own.
  void set_public_address(std::optional<PublicAddress> address) { public_ = std::move(address); }

  /// Why the request is refused, or nothing. Orders come from our own page, or from no page.
  std::optional<HttpResponse> refuse(const HttpRequest& request, Role needed) const;
  /// Refuses a request that calls this machine by another name than its own or that of the public
  /// address, unless tokens were read from a file.
  std::optional<HttpResponse> refuse_host(const HttpRequest& request) const;
  /// Refuses a WebSocket by its host, and where it does not come from our own page. Its token comes
  /// in a message.
  std::optional<HttpResponse> refuse_upgrade(const HttpRequest& request) const;
  /// Whose token the request has, as the file of tokens says; empty: nobody knows.
  std::string name_of(const HttpRequest& request) const;
  /// The role of a token, or nothing.
  std::optional<Role> role_of(std::string_view token) const;

 private:
  struct Token {
    Digest digest;  ///< compared in its stead, so that no time tells how much of it was right
    Role role = Role::viewer;
    std::string name{};
  };
  const Token* find(std::string_view token) const;
  const Token* token_of(const HttpRequest& request) const;
  /// Whether the request comes from a page that its host has served. Pages are served by http; only
  /// where other machines may come can someone on the way speak TLS for us.
  bool is_of_own_page(const HttpRequest& request) const;

  std::vector<Token> tokens_;
  bool is_reached_by_any_name_ = false;
  std::optional<PublicAddress> public_;
};

/// {"error": ...}
HttpResponse http_error(int status, const std::string& what);

}  // namespace tessera
