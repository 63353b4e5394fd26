#pragma once

#include <functional>
#include <nlohmann/json_fwd.hpp>
#include <optional>
#include <string>

#include "base/error.h"
#include "client/farm_client.h"
#include "client/refusal.h"
#include "client/submitted_job.h"
#include "front/rendered_picture.h"
#include "proto/tessera/v1/farm.pb.h"

namespace tessera {

/// Hands the job over and returns its status. Throws what the farm refuses it with.
v1::JobStatus submit_job(FarmClient& client, const SubmittedJob& job);

/// The status of the job, after what the query asks for was done. Throws usage_error where there is
/// no such job.
v1::JobStatus ask_job(FarmClient& client, const v1::JobQuery& query);

/// The JSON object of `tessera status --json`.
nlohmann::ordered_json list_json(const v1::JobList& list);

/// Whether RETRY is for it: it has failed, or is held.
bool may_be_retried(const v1::JobStatus& status);

/// Has the order followed and returns the job's status then. Throws usage_error for a job that it
/// is not for, as one that has ended, and render_error where it had no effect. To cancel a job that
/// was cancelled is fine, and with `ended_too` one that has ended otherwise.
v1::JobStatus give_order(FarmClient& client, const v1::JobQuery& order, bool ended_too = false);

/// Has the farm delete the job. Throws render_error where it does not.
void forget_job(FarmClient& client, uint64_t job);

/// A frame of a job as it is at a farm.
struct FetchedFrame {
  v1::JobStatus status;
  std::optional<RenderedPicture> picture{};  ///< none where no tile is done, or it has not ended
  std::optional<Error> failure{};            ///< none where it is done, or has not ended

  bool has_ended() const { return status.has_end() || failure; }
};
/// The frame that the query names, with its picture if it has ended; `denoises`: smoothed, where no
/// tile of it is missing. Throws render_error where there is no such job any more, or its picture
/// is damaged.
FetchedFrame fetch_frame(FarmClient& client, const v1::JobQuery& query, bool denoises);
/// What `ask` returns. A farm that falls silent, as one whose coordinator is started anew, is asked
/// until it answers; `tell` hears once why nothing comes.
template <class Ask, class Tell>
auto ask_through_silence(const Ask& ask, const Tell& tell) {
  for (bool told = false;; told = true) {
    try {
      return ask();
    } catch (const UnreachableError& error) {
      if (!told) tell(error.what());
    }
  }
}

/// What `--stats` tells of a picture that a farm has made.
std::string fetched_statistics(const v1::JobFrame& frame, const RenderedPicture& picture);

}  // namespace tessera
