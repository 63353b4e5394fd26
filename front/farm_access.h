#pragma once

#include <atomic>
#include <functional>
#include <memory>
#include <mutex>
#include <optional>
#include <string>
#include <vector>

#include "base/error.h"
#include "base/process_owned.h"
#include "client/farm_client.h"
#include "front/farm_connection.h"
#include "front/gather_job.h"
#include "front/rendered_picture.h"

namespace tessera {

/// A frame of a job: whether it has ended, what is done of it and what it failed with.
struct FetchedPicture {
  bool has_ended = false;
  std::shared_ptr<RenderedPicture> picture{};  ///< null: nothing is done, or it has not ended
  std::optional<Error> failure{};
};

/// A farm elsewhere, which is asked one question after the other. Any thread; a call from another
/// waits. Each call ends soon after `stop` is set. Throws RefusedError and UnreachableError.
class FarmAccess {
 public:
  /// Reads the keys and begins to connect. Throws usage_error for a key that is missing or wrong.
  explicit FarmAccess(const FarmConnection& connection);

  /// The job's number.
  uint64_t submit(const SubmittedJob& job, const std::atomic<bool>& stop);
  /// The number of the job that `text` means; as find_job().
  uint64_t find(const std::string& text, const std::function<void(const std::string&)>& tell,
                const std::atomic<bool>& stop);
  /// The objects of `tessera status --json`: of all jobs, or of one.
  std::string list(const std::atomic<bool>& stop);
  std::string status(uint64_t job, const std::atomic<bool>& stop);
  /// As give_order() and forget_job().
  void order(uint64_t job, v1::JobQuery::Action action, std::optional<int> priority,
             const std::atomic<bool>& stop);
  /// A frame, counted from 0; as fetch_frame().
  FetchedPicture fetch(uint64_t job, uint32_t frame, bool denoises, const std::atomic<bool>& stop);
  /// What is done of one that is being traced; null where nothing is.
  std::shared_ptr<RenderedPicture> snapshot(uint64_t job, uint32_t frame,
                                            const std::atomic<bool>& stop);
  /// The numbers of a job's frames in its animation.
  std::vector<int> frames(uint64_t job, const std::atomic<bool>& stop);

 private:
  FarmClient client(const std::atomic<bool>& stop) {
    return FarmClient(*transport_, connection_.endpoint, stop, connection_.patience);
  }
  /// Throws once `stop` is set.
  std::unique_lock<std::timed_mutex> lock(const std::atomic<bool>& stop);

  FarmConnection connection_;
  std::timed_mutex mutex_;
  ProcessOwned<ClientTransport> transport_;
};

}  // namespace tessera
