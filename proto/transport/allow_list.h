#pragma once

#include <chrono>
#include <cstdint>
#include <optional>
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
  enrol,      ///< of an enrolment token: make one other key known, and nothing else
  revoked,    ///< nothing: it is never let in, whatever else lists it
};
/// "worker", "submitter" ...
std::string_view role_name(Role role);

/// Seconds of the wall clock, in UTC.
using WallTime = std::chrono::sys_seconds;
WallTime wall_clock_now();
/// "2026-11-24T12:00:00Z"
std::string wall_time_text(WallTime time);
/// The inverse of wall_time_text(); nothing for any other text.
std::optional<WallTime> parse_wall_time(std::string_view text);

/// One key of a list.
struct AllowedKey {
  Role role = Role::any;
  std::string name;                 ///< whose it is: letters, digits, '.', '_' and '-', for the log
  std::string key{};                ///< itself, as of key_text(); empty where there are no keys
  Role grants = Role::any;          ///< with Role::enrol: the role of the key that is made known
  std::optional<WallTime> until{};  ///< from then on it is not let in
  std::string token{};              ///< the enrolment token that made it known, as of key_text()
  std::optional<WallTime> since{};  ///< when that was
};

/// The public keys that a server lets in.
class AllowList {
 public:
  /// A text of lines "KEY ROLE NAME", as `tessera keygen` prints them, with further words
  /// "until=TIME", "token=KEY" and "since=TIME" where they apply; ROLE may also be
  /// "enrol:worker" and the like, or "revoked". '#' begins a comment. Throws usage_error with the
  /// place of what is wrong. `file` is for that.
  static AllowList parse(std::string_view text, const std::string& file);
  /// The line of that key.
  static std::string line(const Key& key, const AllowedKey& allowed);

  /// The key with all that is listed of it, let in or not; null where it is on no line. `hex` as of
  /// key_text().
  const AllowedKey* find(const std::string& hex) const;
  /// The same of a key that is let in: neither revoked nor past its time. Else null.
  const AllowedKey* admitted(const std::string& hex, WallTime now = wall_clock_now()) const;
  size_t size() const { return keys_.size(); }
  /// How many keys of that role are let in now.
  size_t count(Role role, WallTime now = wall_clock_now()) const;
  const std::unordered_map<std::string, AllowedKey>& keys() const { return keys_; }
  /// Takes in the keys of another list that are not on this one: those on both stay as they are
  /// here.
  void add(const AllowList& other);

 private:
  std::unordered_map<std::string, AllowedKey> keys_;  ///< by key_text()
};

/// One of worker, submitter and viewer. Throws usage_error that begins with `place` otherwise.
Role parse_role(std::string_view text, const std::string& place);
/// Throws usage_error that begins with `place` for what is no name of a key.
void check_key_name(std::string_view name, const std::string& place);

}  // namespace tessera
