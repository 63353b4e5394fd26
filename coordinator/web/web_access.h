#pragma once

#include <filesystem>
#include <optional>
#include <string>
#include <vector>

#include "base/digest.h"
#include "coordinator/web/http_message.h"

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

  /// Why the request is refused, or nothing. Orders come from our own page, or from no page.
  std::optional<HttpResponse> refuse(const HttpRequest& request, Role needed) const;

 private:
  struct Token {
    Digest digest;  ///< compared in its stead, so that no time tells how much of it was right
    Role role = Role::viewer;
  };
  std::optional<Role> role_of(const HttpRequest& request) const;

  std::vector<Token> tokens_;
};

/// {"error": ...}
HttpResponse http_error(int status, const std::string& what);

}  // namespace tessera
