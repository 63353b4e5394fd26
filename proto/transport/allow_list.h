#pragma once

#include <cstdint>
#include <string>
#include <string_view>
#include <unordered_map>

#include "proto/transport/keys.h"

namespace tessera {

/// What the holder of a key is there to do.
enum class Role : uint8_t {
  any,        ///< where there are no keys: everything
  worker,     ///< trace
  submitter,  ///< have jobs traced; see how they go, and end them
  viewer,     ///< see how they go
};
/// "worker", "submitter" ...
std::string_view role_name(Role role);

/// One key that is let in.
struct AllowedKey {
  Role role = Role::any;
  std::string name;   ///< whose it is: letters, digits, '.', '_' and '-', for the log
  std::string key{};  ///< itself, as of key_text(); empty where there are no keys
};

/// The public keys that a server lets in.
class AllowList {
 public:
  /// A text of lines "KEY ROLE NAME", as `tessera keygen` prints them; '#' begins a comment. Throws
  /// usage_error with the place of what is wrong. `file` is for that.
  static AllowList parse(std::string_view text, const std::string& file);
  /// The line of that key.
  static std::string line(const Key& key, const AllowedKey& allowed);

  /// Whose key this is, or null. `hex` as of key_text().
  const AllowedKey* find(const std::string& hex) const;
  size_t size() const { return keys_.size(); }
  size_t count(Role role) const;

 private:
  std::unordered_map<std::string, AllowedKey> keys_;  ///< by key_text()
};

/// One of worker, submitter and viewer. Throws usage_error that begins with `place` otherwise.
Role parse_role(std::string_view text, const std::string& place);
/// Throws usage_error that begins with `place` for what is no name of a key.
void check_key_name(std::string_view name, const std::string& place);

}  // namespace tessera
