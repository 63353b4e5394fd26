#pragma once

#include <functional>
#include <string>

#include "proto/tessera/v1/farm.pb.h"
#include "proto/transport/allow_list.h"

namespace tessera {

/// The keys that a coordinator lets in: those that its administrator lists, and those of machines
/// that made themselves known by one of the enrolment tokens there. The latter the registry keeps
/// itself. What the administrator lists of a key counts, whatever else is known of it. Has no file
/// and no clock.
class KeyRegistry {
 public:
  /// Makes the text durable as the whole list of enrolled keys, in place of the one before. Throws
  /// Error, and leaves that one as it was, where it cannot.
  using Keep = std::function<void(const std::string& text)>;

  /// Nobody can enrol where `keep` is empty. `enrolled` is what was kept last, `file` its name for
  /// errors. Throws usage_error where that is wrong, and as set_listed().
  explicit KeyRegistry(AllowList listed, Keep keep = {}, std::string enrolled = {},
                       const std::string& file = {});

  /// Takes up the administrator's list as it is now. Throws usage_error, and changes nothing, where
  /// it has enrolment tokens and there is nowhere to keep what they enrol.
  void set_listed(AllowList listed);
  /// Those of both lists.
  const AllowList& keys() const { return keys_; }

  /// Makes the key of `request` known by `token`, one of Role::enrol that is let in: kept before
  /// this returns ENROLLED. A token is used as long as a key of either list names it; asking again
  /// for the same key succeeds. A name belongs to one key until that is revoked.
  v1::EnrolAnswer enrol(const AllowedKey& token, const v1::Enrol& request, WallTime now);

 private:
  AllowList listed_, enrolled_, keys_;
  std::string text_;  ///< of the enrolled ones
  Keep keep_;
};

}  // namespace tessera
