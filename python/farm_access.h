#pragma once

#include <memory>
#include <mutex>
#include <optional>
#include <string>

#include "client/farm_client.h"
#include "front/farm_connection.h"
#include "front/gather_job.h"
#include "python/frame_task.h"

namespace tessera {

/// What Python asks of a farm elsewhere, one question after the other. Any thread; a call from
/// another waits. Each call looks at `stop`. Throws RefusedError and UnreachableError.
class FarmAccess {
 public:
  /// Reads the keys and begins to connect. Throws usage_error for a key that is missing or wrong.
  explicit FarmAccess(const FarmConnection& connection);

  /// The job's number.
  uint64_t submit(const SubmittedJob& job, const std::atomic<bool>& stop);
  /// The number of the job that `text`, a number or a name, means.
  uint64_t find(const std::string& text, const std::atomic<bool>& stop);
  /// The objects of `tessera status --json`: of all jobs, or of one.
  std::string list(const std::atomic<bool>& stop);
  std::string status(uint64_t job, const std::atomic<bool>& stop);
  /// Throws render_error where it was not followed, usage_error where the job has ended.
  void order(uint64_t job, v1::JobQuery::Action action, std::optional<int> priority,
             const std::atomic<bool>& stop);
  /// The picture of a frame, counted from 0; null while it is not done. Throws what it failed with.
  std::shared_ptr<RenderedPicture> fetch(uint64_t job, uint32_t frame,
                                         const std::atomic<bool>& stop);
  /// What is done of one that is being traced; null where nothing is.
  std::shared_ptr<RenderedPicture> snapshot(uint64_t job, uint32_t frame,
                                            const std::atomic<bool>& stop);
  /// The numbers of a job's frames in its animation.
  std::vector<int> frames(uint64_t job, const std::atomic<bool>& stop);

 private:
  FarmClient client(const std::atomic<bool>& stop) {
    return FarmClient(*transport_, connection_.endpoint, stop, connection_.patience);
  }
  static v1::JobStatus known(FarmClient& client, const v1::JobQuery& query);

  FarmConnection connection_;
  std::mutex mutex_;
  std::unique_ptr<ClientTransport> transport_;
};

}  // namespace tessera
