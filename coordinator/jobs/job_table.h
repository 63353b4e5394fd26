#pragma once

#include <cstdint>
#include <deque>
#include <functional>
#include <map>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "base/monotonic.h"
#include "coordinator/jobs/active_frame.h"
#include "coordinator/jobs/farm_snapshot.h"
#include "coordinator/jobs/film_shelf.h"
#include "coordinator/jobs/job.h"
#include "coordinator/jobs/job_rules.h"
#include "coordinator/jobs/job_status.h"
#include "coordinator/jobs/job_store.h"
#include "coordinator/jobs/scheduling.h"
#include "job/job.h"

namespace tessera {

/// All jobs, of this process and of clients: which of them run, in which order workers are to serve
/// them, and how each ended. What clients' jobs are and become is in the store before it is told.
/// Of the coordinator's thread.
class JobTable {
 public:
  /// Takes up the jobs of the store. Throws render_error where it cannot be read.
  JobTable(const JobRules& rules, std::shared_ptr<JobStore> store);

  // Jobs of this process.
  /// Throws usage_error if its frame, crop or tile size cannot be.
  uint64_t submit(JobSpec spec, std::shared_ptr<TileStore> tiles);
  /// Ends it now, as interrupted, with what there is; also where it was not begun.
  void interrupt(uint64_t frame, Time now);
  /// Forgets it, begun or not; advance() tells that it has ended.
  void abandon(uint64_t frame);
  /// The result of a job from submit() once it has ended; told once.
  std::optional<JobResult> take_result(uint64_t frame);
  /// Of any frame that is being traced, by the number that submit() returns and workers know; null
  /// for others.
  const ActiveFrame* running(uint64_t frame) const;

  // Jobs of clients.
  /// Takes a submission whose blobs are in the store; `scenes` has those of its frames. Throws
  /// Error where it cannot be rendered or kept.
  void accept(v1::SubmitJob request, const std::vector<Digest>& blobs, SceneFactsMap scenes);
  /// Null where there is none; valid until it is forgotten.
  Job* find(uint64_t job);
  Job* find_submission(uint64_t submission);
  const std::map<uint64_t, std::unique_ptr<Job>>& all() const { return jobs_; }
  uint64_t last_job() const { return last_job_; }
  /// Each throws render_error where the store cannot keep it; then nothing has changed.
  /// `by`: who ordered it.
  void pause(Job& job, bool paused, const std::string& by = {});
  void set_priority(Job& job, int32_t priority);
  void cancel(Job& job);
  /// An ended one.
  void forget(Job& job);
  /// Frames that failed are rendered again, what is held is tried now. False where there is
  /// neither.
  bool retry(Job& job);
  v1::JobStatus status(const Job& job, uint32_t frame, Time now) const;
  /// The status of each job of a client with a number above `after`, in their order, until `take`
  /// returns false.
  void each_status(uint64_t after, Time now, const std::function<bool(v1::JobStatus)>& take) const;

  // For people.
  /// Jobs of clients, and the counters of jobs.
  void describe(FarmSnapshot& snapshot, Time now) const;
  /// Of the job of a frame that is being traced, by the number that workers know; else nothing.
  std::optional<JobProgress> progress(uint64_t frame, Time now) const;
  /// Of jobs that clients submitted to this coordinator.
  uint64_t accepted_count() const { return jobs_accepted_; }
  std::vector<std::pair<uint64_t, uint32_t>> running_frames() const;
  /// Null where that frame is not being traced.
  const ActiveFrame* running(uint64_t job, uint32_t frame) const;
  std::optional<FilmView> film(uint64_t job, uint32_t frame);
  /// Nothing where there is no such frame, or nothing of it yet.
  std::optional<PreviewImage> preview(uint64_t job, uint32_t frame, int most_side);
  /// The number by which users know the frame, as Job has it; its position from 1 of an unknown
  /// job.
  int32_t number_of(uint64_t job, uint32_t frame) const;
  /// Of a frame that is being traced, or of the last ones that were; else null.
  std::shared_ptr<const FrameTrace> trace(uint64_t job, uint32_t frame) const;

  /// How many workers are there, and with how many threads they trace, for the choice of tile
  /// sizes; 0: not known.
  void set_workers(int workers, uint32_t threads) {
    workers_ = workers;
    threads_ = threads;
  }

  // Workers, and by whose keys they came.
  WorkerKeys& keys() { return *keys_; }
  /// What is held for want of a worker may have one now.
  void worker_has_come(WorkerId worker);
  /// A key is convicted: what was traced under it is traced again, in jobs that have ended too.
  void distrust(const std::string& key);

  // Frames that run.
  /// Counts what workers hold until now; to be called before that changes.
  void account(Time now);
  /// By the number that workers know; null where it is not being traced, valid until it ends.
  ActiveFrame* running(uint64_t frame);
  /// Those of which tiles may be assigned, the neediest job's first: by priority, then by the share
  /// that each has had. Valid until the next call.
  const std::vector<ActiveFrame*>& by_need();
  const std::vector<ActiveFrame*>& running() const { return running_; }
  struct Changes {
    /// Nothing ended or was begun, so that nothing more follows from it.
    bool settled = true;
    std::vector<uint64_t> ended;  ///< frames, by the number that workers know
    std::vector<ActiveFrame*> begun;
  };
  /// For tests: which rule of scheduling does not hold; empty: all do.
  std::string broken_rule(Time now) const;
  /// Files what has ended, and does what plan_begin() says.
  Changes advance(Time now);
  /// Why no tile is assigned: the store takes nothing; empty: it does.
  std::string store_trouble() const;
  /// Tries again to keep what the store did not take.
  void keep_rest();
  /// Keeps how long jobs were worked on: of each for which a crash would lose a twentieth of that,
  /// but no less than 1 s and no more than 10, or of `all`.
  void keep_times(bool all = false);
  /// As JobStore::tidy().
  void tidy() { store_->tidy(); }

  /// What workers or clients may fetch; `of`: the frame that it is for, null for a film.
  struct FoundBlob {
    BlobData data;
    ActiveFrame* of = nullptr;
  };
  FoundBlob find_blob(const Digest& digest);
  /// The scene of a client's frame with its blobs; nothing where there is no such frame. Throws
  /// Error where the store has it no longer.
  std::optional<std::pair<BlobData, BlobStore>> scene(uint64_t job, uint32_t frame);

 private:
  static FilmShelf::Recipe recipe_of(const v1::KeptJob& kept, uint32_t frame);
  /// Whether what is kept has that frame: rows of a store may be damaged.
  static bool has_frame(const v1::KeptJob& kept, uint32_t frame);
  /// Of that job, which is not to be shown any more, though other tiles may make up the same.
  void forget_film(const Job& job, const std::string& film);
  void add(std::unique_ptr<Job> job);
  /// Of a frame, in the store; 0 where that cannot be read now.
  uint64_t stored_tiles(const Job& job, uint32_t frame);
  void count_stored(Job& job);
  /// What is to be kept of it, as of now.
  static v1::KeptJob kept_now(const Job& job);
  /// The priorities of jobs whose tiles workers hold.
  std::vector<int32_t> served() const;
  /// Notes what running() is, after that has changed.
  void list_running();
  BeginLimits limits() const;
  OpenJob open_job(const Job& job, Time now) const;
  /// Those that are begun or could be.
  std::vector<OpenJob> open_jobs(Time now) const;
  FarmState state(Time now) const;
  v1::JobStatus status(const Job& job, uint32_t frame, const FarmState& farm, Time now) const;
  /// Of a frame of a client's job; of this process's own it is not counted.
  static uint64_t film_bytes_of(const Job& job, uint32_t frame);
  void begin(Job& job, uint32_t frame, Time now, Changes& changes);
  /// Begins it, or throws.
  std::unique_ptr<ActiveFrame> make_active(Job& job, uint32_t frame, Time now);
  /// The frame, which is not running, is begun again after that.
  void hold(Job& job, uint32_t frame, Job::Hold hold);
  /// Gives its memory back; it is begun again from its tiles in the store.
  void put_aside(Job& job, uint32_t frame, Changes& changes);
  /// The frame's tiles are kept under another key from now on: this program computes otherwise than
  /// that which accepted the job.
  void change_key(Job& job, uint32_t frame, const Digest& key);
  /// Whether the film is the one that is expected. Else its tiles are traced again, once.
  bool is_expected(Job& job, uint32_t frame, v1::JobEnd& end);
  /// Whether another job's frames have their tiles under that key.
  bool shares_key(const Job& job, const std::string& key) const;
  void redo_distrusted();
  void finish(Job& job, Job::Running& running, Changes& changes);
  /// Frames that were done and whose pictures cannot be put together any more: what is gone of
  /// their tiles or, where these make another film, all of them are traced again.
  void reopen(const Digest& film, FilmShelf::State state);
  /// The frame is to be rendered again, from the tiles that are kept, whatever film they make.
  void reopen(Job& job, uint32_t frame);
  /// Of a job of this process, which no store keeps.
  void end_local(Job& job, uint32_t frame, JobResult result);
  void file_end(Job& job, uint32_t frame, v1::JobEnd end);
  JobRules rules_for(const Job& job) const;
  TileKeeping keeping_of(const Job& job) const;
  // Of the store; each throws where they are not there, or not what they should be.
  BlobData load_blob(const std::string& hex);
  PackedScene load_scene(Job& job, uint32_t frame);
  BlobStore load_blobs_of(Job& job, const PackedScene& scene);
  /// What the tiles of the frame before took; null: there is none.
  const TileCosts* earlier_costs(const Job& job) const;

  JobRules rules_;
  std::shared_ptr<JobStore> store_;
  std::unique_ptr<WorkerKeys> keys_ = std::make_unique<WorkerKeys>();  ///< frames point to it
  std::map<uint64_t, std::unique_ptr<Job>> jobs_;
  std::map<uint64_t, Job*> open_;  ///< those of them that have not ended
  // Made anew at each message, these keep their memory.
  std::vector<ActiveFrame*> running_, by_need_;
  std::vector<std::pair<Need, Job*>> needs_;
  std::map<uint64_t, uint64_t> by_submission_;
  std::map<uint64_t, JobResult> results_;        ///< of jobs of this process
  std::optional<TileCosts> local_costs_;         ///< of the last of those
  uint64_t last_job_ = 0, last_job_before_ = 0;  ///< ever; of a coordinator before us
  int workers_ = 0;
  uint32_t threads_ = 0;
  Changes changes_;                                             ///< that advance() has not told yet
  std::vector<std::pair<uint64_t, v1::KeptJob::End>> unsaved_;  ///< ends that the store must take
  std::string trouble_;                                         ///< with those
  std::vector<std::string> distrusted_;                         ///< keys, of redo_distrusted()
  FilmShelf films_;
  /// Of the last frames that ended, by the number that workers know.
  std::deque<std::pair<uint64_t, std::shared_ptr<const FrameTrace>>> traces_;
  uint64_t tiles_restored_ = 0, jobs_accepted_ = 0;
};

}  // namespace tessera
