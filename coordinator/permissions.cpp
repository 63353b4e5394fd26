#include "coordinator/permissions.h"

#include <fmt/format.h>

namespace tessera {
namespace {

/// Whether it changes nothing.
bool is_question(const v1::JobQuery& query) {
  return query.action() == v1::JobQuery::ASK && !query.has_priority();
}

/// Who may send it, where keys are used; any: both workers and submitters. Nothing: nobody.
std::optional<Role> needed_role(const v1::Envelope& message) {
  switch (message.message_case()) {
    case v1::Envelope::kHello:
    case v1::Envelope::kHeartbeat:
    case v1::Envelope::kTileBand:
    case v1::Envelope::kTileFailed:
    case v1::Envelope::kBye:
    case v1::Envelope::kSceneReady:
    case v1::Envelope::kSceneFailed:
      return Role::worker;
    case v1::Envelope::kSubmitJob:
    case v1::Envelope::kJobRelease:
    case v1::Envelope::kBlobChunk:
    case v1::Envelope::kBlobMissing:
    case v1::Envelope::kDoneTilesQuery:
      return Role::submitter;
    case v1::Envelope::kJobQuery:
      return is_question(message.job_query()) ? Role::viewer : Role::submitter;
    case v1::Envelope::kJobListQuery:
      return Role::viewer;
    case v1::Envelope::kEnrol:
      return Role::enrol;
    // Whoever knows a digest has seen the list that it is on.
    case v1::Envelope::kBlobRequest:
      return Role::any;
    default:
      return std::nullopt;
  }
}

bool has_role(Role has, Role needs) {
  if (has == Role::any || has == needs) return true;
  if (needs == Role::any) return has == Role::worker || has == Role::submitter;
  return needs == Role::viewer && has == Role::submitter;
}

/// "a worker's", of keys of that role.
std::string whose(Role role) {
  return role == Role::enrol ? "an enrolment token" : fmt::format("a {}'s", role_name(role));
}

}  // namespace

bool may_submit(const AllowedKey& sender) { return has_role(sender.role, Role::submitter); }

std::optional<v1::Reject> refuse(const AllowedKey& sender, const v1::Envelope& message) {
  const auto needed = needed_role(message);
  if (needed && has_role(sender.role, *needed)) return std::nullopt;
  if (sender.role == Role::any) return std::nullopt;  // what nobody sends is ignored, as ever
  v1::Reject reject;
  reject.set_reason(v1::Reject::NOT_ALLOWED);
  const Role expected = needed.value_or(Role::any);
  reject.set_text(fmt::format("the key of {} is {}; expected {}", sender.name, whose(sender.role),
                              !needed                    ? "no such message"
                              : expected == Role::any    ? std::string("a worker's or submitter's")
                              : expected == Role::viewer ? std::string("a viewer's or submitter's")
                                                         : whose(expected)));
  return reject;
}

}  // namespace tessera
