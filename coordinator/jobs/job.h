#pragma once

#include <cstdint>
#include <deque>
#include <map>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "base/monotonic.h"
#include "coordinator/jobs/active_frame.h"
#include "coordinator/jobs/work_meter.h"
#include "job/job.h"
#include "proto/tessera/v1/farm.pb.h"

namespace tessera {

/// A job of one frame or many, from when it is accepted until it is forgotten: which of its frames
/// have ended, which are being traced, and what share of the workers it had.
class Job {
 public:
  /// As it was kept.
  explicit Job(v1::KeptJob kept);
  /// Of this process: one frame, whose result is taken and kept nowhere; its tiles are kept in
  /// `tiles`, unless that is null.
  Job(uint64_t id, JobSpec spec, std::shared_ptr<TileStore> tiles);

  uint64_t id() const { return kept_.job(); }
  const v1::SubmitJob& request() const { return kept_.request(); }
  const v1::KeptJob& kept() const { return kept_; }
  v1::KeptJob& kept() { return kept_; }
  bool local() const { return local_.has_value(); }
  /// Of a job of this process, before its frame is taken.
  const PixelRect& local_crop() const { return local_->crop; }
  /// The frame of a job of this process, once.
  JobSpec take_local_spec() { return std::move(*local_); }
  const std::shared_ptr<TileStore>& local_tiles() const { return local_tiles_; }

  uint32_t frame_count() const { return static_cast<uint32_t>(ends_.size()); }
  /// The number by which users know a frame: its own in the animation, as --frames has it, else its
  /// position from 1.
  int32_t number_of(uint32_t frame) const;
  const std::optional<v1::JobEnd>& end_of(uint32_t frame) const { return ends_[frame]; }
  /// Those whose pictures are whole.
  uint32_t frames_done() const { return frames_done_; }
  /// All frames have ended, or none of those that are left is wanted.
  bool ended() const;
  /// The first frame that was not begun, has not ended and is not held at that time.
  std::optional<uint32_t> next_frame(Time now) const;

  /// The frames that are being traced, the earliest first.
  struct Running {
    uint32_t frame = 0;
    std::unique_ptr<ActiveFrame> active;
  };
  std::deque<Running>& running() { return running_; }
  const std::deque<Running>& running() const { return running_; }
  void begin(uint32_t frame, std::unique_ptr<ActiveFrame> active);
  /// Whether any frame was, in this process.
  bool begun() const { return begun_; }
  /// So many tiles of a frame that is not being traced are in the store.
  void set_stored(uint32_t frame, uint64_t tiles);
  /// The frames that neither have ended nor are being traced and whose tiles are those of `frame`,
  /// in time linear in the number of frames.
  std::vector<uint32_t> waiting_equals(uint32_t frame) const;
  uint64_t stored(uint32_t frame) const;
  void end(uint32_t frame, v1::JobEnd end);
  /// It has not ended after all, and is to be begun again, with so many tiles that are stored.
  void reopen(uint32_t frame, uint64_t stored);

  /// Why a frame does not go on, and when it is tried again. The job's other frames go on.
  struct Hold {
    std::string cause;
    Time until = Time::max();           ///< when it is tried again
    bool until_another_worker = false;  ///< it is tried again too when a worker comes
  };
  const std::map<uint32_t, Hold>& holds() const { return holds_; }
  /// Whether none of its frames that are left can go on.
  bool held() const;
  /// What its held frames lack; empty: none is held.
  std::string hold_cause() const;
  void hold(uint32_t frame, Hold hold) { holds_[frame] = std::move(hold); }
  /// The frame is not traced any more, and begun again from what is stored of it.
  void put_aside(uint32_t frame);
  /// Held frames for which another worker is waited for, and which this one has not failed, are
  /// tried again.
  void note_worker(WorkerId worker);
  /// Tries again all that is held.
  void release();
  /// Of its frames; those of a job that was taken up from the store once they are needed.
  SceneFactsMap& scenes() { return scenes_; }
  /// What went wrong at workers with the scene of a frame that has not ended.
  std::map<uint32_t, SceneFailures>& scene_failures() { return scene_failures_; }
  /// How long the frame is to wait after the next failure to begin: longer each time, until it is
  /// begun.
  Time next_pause(uint32_t frame);

  /// The film that a frame made when it was done first, where its tiles are traced again.
  struct ExpectedFilm {
    std::string digest;
    bool drop_tiles = false;  ///< before it begins: those that are kept make another film
    bool dropped = false;
  };
  std::map<uint32_t, ExpectedFilm>& expected_films() { return expected_films_; }

  /// Whether it is worked on: workers hold tiles of it, or it takes turns with the jobs of which
  /// they do, `served` being the priorities of these. Workers that are suspect do not count.
  bool works(const std::vector<int32_t>& served) const;
  /// Counts what workers hold until now, and the time if it `works`; to be called before that
  /// changes.
  void account(Time now, bool works);
  /// Worker-seconds by weight: what it had until now, and will soon have had for the tiles that
  /// workers hold. The job that has least is next.
  double share() const;
  /// Starts level with others that have been there for longer.
  void catch_up(double share);

  /// Of the frame that ended last.
  std::optional<TileCosts>& last_costs() { return last_costs_; }
  const std::optional<TileCosts>& last_costs() const { return last_costs_; }

  /// Its tiles that are done or stored, how long it was worked on, and how long the rest will take,
  /// which is not known while it does not `work`: whoever tells of these tells this.
  JobProgress progress(Time now, bool works) const;
  /// The seconds for which it was worked on until account() was called last.
  double worked_seconds() const { return meter_.seconds(counted_until_, false); }
  /// The seconds of threads that its tiles have taken, without copies.
  double traced_seconds() const { return traced_in_earlier_runs_ + traced().seconds; }
  uint64_t tiles_restored() const;
  size_t leases() const;

 private:
  /// In this process.
  TileWork traced() const;
  /// What will be traced until all of `tiles` are done.
  TileWork left(uint64_t tiles) const;
  /// Of the workers that may hold tiles of it, suspects apart.
  size_t working_threads() const;
  /// Takes it out of running_. Its tiles are stored, for the frames that are equal to it too.
  void stop(uint32_t frame);
  /// Tiles of frames that neither have ended nor are being traced.
  struct WaitingTiles {
    uint64_t done = 0;    ///< stored, or done in an equal frame that is being traced
    uint64_t coming = 0;  ///< that will be done there
  };
  WaitingTiles waiting_tiles() const;

  v1::KeptJob kept_;
  std::optional<JobSpec> local_;
  std::shared_ptr<TileStore> local_tiles_;
  std::vector<std::optional<v1::JobEnd>> ends_;  ///< by frame
  uint32_t frames_ended_ = 0, frames_done_ = 0, next_frame_ = 0;
  uint64_t tiles_per_frame_ = 0;
  std::deque<Running> running_;
  std::optional<TileCosts> last_costs_;
  double held_seconds_ = 0, head_start_ = 0;
  Time counted_until_{};
  bool begun_ = false;
  WorkMeter meter_;
  TileWork traced_before_;  ///< in frames that are not being traced any more
  double traced_in_earlier_runs_ = 0;
  std::map<uint32_t, uint64_t> stored_;  ///< tiles, by frame
  std::map<uint32_t, Hold> holds_;       ///< by frame
  std::map<uint32_t, int> pauses_;       ///< by frame
  SceneFactsMap scenes_;
  std::map<uint32_t, SceneFailures> scene_failures_;  ///< by frame
  std::map<uint32_t, ExpectedFilm> expected_films_;   ///< by frame
};

}  // namespace tessera
