#pragma once

#include <cstddef>
#include <cstdint>
#include <optional>
#include <span>
#include <string>
#include <vector>

namespace tessera {

// The rules by which the jobs of a farm share workers and memory, as pure functions of plain
// values: who is next, who is begun, who is put aside and what memory is promised. What holds after
// them is told by broken_rule():
//
// - The films of begun frames take no more than the budget together.
// - A paused job holds no budget once the tiles that workers had of it are in, nor before that
//   where another job needs it.
// - No job waits to be begun that fits, or that would fit once less urgent frames are put aside.

/// How many jobs have their scenes and films in memory.
struct BeginLimits {
  size_t jobs = 8;
  size_t urgent_jobs = 64;  ///< for a job that is more urgent than one of those begun
  uint64_t film_bytes = uint64_t{32} << 30;  ///< the films of begun frames together
};

/// A frame that is being traced.
struct BegunFrame {
  uint32_t frame = 0;
  uint64_t film_bytes = 0;
  size_t tiles_out = 0;  ///< that workers hold
  bool has_pending = false;
  /// All that was traced of it is stored, so that it can be begun again from there.
  bool may_be_put_aside = true;
};

/// A job that has not ended.
struct OpenJob {
  uint64_t id = 0;
  int32_t priority = 0;
  bool paused = false;
  std::vector<BegunFrame> begun{};
  /// The frame that is to be begun next: none that is held, or whose tiles are being traced.
  struct Next {
    uint32_t frame = 0;
    uint64_t film_bytes = 0;
  };
  std::optional<Next> next{};
};

/// The tiles that workers hold of it.
size_t tiles_out(const OpenJob& job);

struct FrameOfJob {
  uint64_t job = 0;
  uint32_t frame = 0;
  friend bool operator==(const FrameOfJob&, const FrameOfJob&) = default;
};

/// What is to be done, in this order.
struct BeginPlan {
  std::vector<FrameOfJob> put_aside, begin;
};
/// A frame whose film is larger than the whole budget is begun, so that it can be refused. Frames
/// that are put aside lose the tiles that workers hold of them: those of paused jobs go first, then
/// those of the least urgent job, then those with the fewest tiles out.
BeginPlan plan_begin(std::vector<OpenJob> jobs, const BeginLimits& limits);

/// Which invariant does not hold, where plan_begin() has been followed; empty: all hold.
std::string broken_rule(std::span<const OpenJob> jobs, const BeginLimits& limits);

/// Why a job whose next frame is not begun waits.
struct Wait {
  enum class For { nothing, jobs, memory } what = For::nothing;
  uint64_t behind = 0;  ///< one of the jobs that it waits for: the least urgent, latest of them
  uint64_t promised_bytes = 0;  ///< to films of begun frames
};
Wait wait_of(const OpenJob& job, std::span<const OpenJob> jobs, const BeginLimits& limits);

/// What a job has had of the workers.
struct Need {
  int32_t priority = 0;
  double share = 0;  ///< worker-seconds by weight
};
/// Whether the next free tile is rather for the first: by priority, then by who has had less.
bool is_needier(const Need& one, const Need& other);

/// A scene that a worker knows.
struct KnownScene {
  uint64_t frame = 0;
  int32_t priority = 0;
  size_t tiles_held = 0;
};
/// Which of the scenes a worker should forget, being full of them, for a job of that priority: the
/// least urgent without a tile that it holds. `waits`: there are less urgent ones, and it
/// holds tiles of all of these: it should get no more of them.
struct Forget {
  std::optional<uint64_t> frame{};
  bool waits = false;
};
Forget scene_to_forget(std::span<const KnownScene> scenes, int32_t priority);

}  // namespace tessera
