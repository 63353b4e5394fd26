#include "coordinator/key_registry.h"

#include <fmt/format.h>

#include <algorithm>
#include <utility>

#include "base/error.h"

namespace tessera {
namespace {

v1::EnrolAnswer answer(v1::EnrolAnswer::Outcome outcome, const std::string& text) {
  v1::EnrolAnswer answer;
  answer.set_outcome(outcome);
  answer.set_text(text);
  return answer;
}

v1::EnrolAnswer enrolled_as(const AllowedKey& key) {
  v1::EnrolAnswer answer;
  answer.set_outcome(v1::EnrolAnswer::ENROLLED);
  answer.set_role(std::string(role_name(key.role)));
  answer.set_name(key.name);
  return answer;
}

/// The first key of the list for which `is_such` is true, or null.
template <typename Condition>
const AllowedKey* find_if(const AllowList& list, const Condition& is_such) {
  const auto it = std::find_if(list.keys().begin(), list.keys().end(),
                               [&](const auto& entry) { return is_such(entry.second); });
  return it == list.keys().end() ? nullptr : &it->second;
}

}  // namespace

KeyRegistry::KeyRegistry(AllowList listed, Keep keep, std::string enrolled, const std::string& file)
    : enrolled_(AllowList::parse(enrolled, file)),
      text_(std::move(enrolled)),
      keep_(std::move(keep)) {
  if (!text_.empty() && !text_.ends_with('\n')) text_ += '\n';
  set_listed(std::move(listed));
}

void KeyRegistry::set_listed(AllowList listed) {
  const AllowedKey* const token =
      find_if(listed, [](const AllowedKey& key) { return key.role == Role::enrol; });
  if (token && !keep_) {
    throw usage_error(fmt::format(
        "--allow: has the enrolment token {}; expected --enrolled or --store beside it, where "
        "enrolled keys are kept",
        token->name));
  }
  listed_ = std::move(listed);
  keys_ = listed_;
  keys_.add(enrolled_);
}

v1::EnrolAnswer KeyRegistry::enrol(const AllowedKey& token, const v1::Enrol& request,
                                   WallTime now) {
  const std::string& name = request.name();
  const auto refused = [](const std::string& why) { return answer(v1::EnrolAnswer::REFUSED, why); };
  const auto key = parse_key(request.public_key());
  if (!key) return refused("this is no public key; expected 64 digits 0-9 a-f");
  try {
    check_key_name(name, "enrolment");
  } catch (const Error& error) {
    return refused(error.what());
  }
  if (const AllowedKey* known = listed_.find(request.public_key())) {
    return refused(fmt::format("this key is on the administrator's list, as {} {}",
                               role_name(known->role), known->name));
  }
  if (const AllowedKey* known = enrolled_.find(request.public_key())) {
    if (known->role == token.grants) return enrolled_as(*known);
    return refused(fmt::format("this key is enrolled as {} {}; expected a new one",
                               role_name(known->role), known->name));
  }
  const auto is_of_token = [&](const AllowedKey& other) { return other.token == token.key; };
  // Not among keys_, where the line that revokes a key hides the one that names its token.
  for (const AllowList* list : {&enrolled_, &listed_}) {
    if (const AllowedKey* user = find_if(*list, is_of_token)) {
      return answer(v1::EnrolAnswer::TOKEN_USED,
                    fmt::format("the token {} has enrolled {} already", token.name, user->name));
    }
  }
  const auto has_name = [&](const AllowedKey& other) {
    return other.name == name && other.role != Role::enrol && other.role != Role::revoked;
  };
  if (find_if(keys_, has_name)) {
    return refused(fmt::format(
        "the name {} is another key's; expected another name, or that key to be revoked", name));
  }
  const AllowedKey added{.role = token.grants,
                         .name = name,
                         .key = request.public_key(),
                         .token = token.key,
                         .since = now};
  const std::string line = AllowList::line(*key, added);
  try {
    keep_(text_ + line);
  } catch (const Error& error) {
    return answer(v1::EnrolAnswer::TRY_AGAIN,
                  fmt::format("the key cannot be kept now: {}", error.what()));
  }
  text_ += line;
  const AllowList one = AllowList::parse(line, "enrolment");
  enrolled_.add(one);
  keys_.add(one);
  return enrolled_as(added);
}

}  // namespace tessera
