#pragma once

#include <cstdint>
#include <span>
#include <string>
#include <vector>

#include "base/blob.h"
#include "coordinator/jobs/seconds_histogram.h"
#include "renderer/film/tile.h"

namespace tessera {

/// How the farm is at one moment: all that a page or a monitor may show. Plain values: a copy that
/// any thread may read. Text in it is printable, whoever said it.
struct FarmSnapshot {
  enum class JobState { queued, running, paused, held, done, failed, cancelled };
  struct Job {
    uint64_t id = 0;
    std::string name;
    JobState state = JobState::queued;
    int priority = 0;
    uint32_t weight = 1;
    uint32_t frames_done = 0, frames_total = 0;
    uint64_t tiles_done = 0, tiles_total = 0, tiles_restored = 0;
    int width = 0, height = 0;                          ///< of what is rendered: the crop's
    double elapsed_seconds = 0, remaining_seconds = 0;  ///< remaining < 0: not known
    double worker_seconds = 0;                          ///< of threads, that its tiles have taken
    int exit_code = 0;      ///< of ExitCode; of no meaning before its end
    std::string failure;    ///< why it failed, or what its held frames lack
    std::string waits_for;  ///< as of JobStatus
    /// The frames being traced, counted from 0, for tiles and preview.
    std::vector<uint32_t> frames_running;
  };
  enum class WorkerState { active, suspect, lost };
  struct Worker {
    uint64_t id = 0;
    std::string name;  ///< "host:process"
    WorkerState state = WorkerState::active;
    uint32_t threads = 0, credit = 0;
    size_t tiles_held = 0, scenes = 0;
    uint64_t tiles_done = 0;       ///< that it was first to complete
    double tile_seconds = 0;       ///< from assignment to completion, sum over those
    uint64_t bytes_results = 0;    ///< of pixels, as they came
    uint64_t resident_bytes = 0;   ///< memory of its process, as it said last; 0: not known
    int failures = 0;              ///< tiles that it failed
    double silent_seconds = 0;     ///< since it was last heard
    double connected_seconds = 0;  ///< since it came
  };
  /// Since this coordinator was started; they only grow.
  struct Counters {
    uint64_t tiles_done = 0, tiles_restored = 0, tiles_given_up = 0;
    uint64_t retries = 0, speculative = 0, duplicates = 0, mismatches = 0;
    uint64_t workers_seen = 0, workers_lost = 0, workers_set_aside = 0;
    uint64_t bytes_scene = 0, bytes_results = 0;  ///< to and from workers
    uint64_t jobs_accepted = 0;
    uint64_t rays = 0;  ///< that workers traced, as they say with each tile or part of one
    SecondsHistogram tile_seconds;    ///< from assignment to completion, of tiles_done
    SecondsHistogram commit_seconds;  ///< of what was written to the store

    void note_tile(double seconds) {
      ++tiles_done;
      tile_seconds.note(seconds);
    }
  };
  uint64_t farm = 0;
  std::string opening;  ///< of this coordinator, in hexadecimal
  double uptime_seconds = 0;
  std::string store_trouble;  ///< why no tile is assigned; empty: nothing is wrong
  std::vector<Job> jobs;      ///< by number
  std::vector<Worker> workers;
  Counters counters;
};

/// A tile of a frame that is being traced.
struct TileSnapshot {
  enum class State : uint8_t { pending, assigned, done, given_up };
  PixelRect rect;  ///< in frame coordinates
  State state = State::pending;
  uint64_t worker = 0;  ///< that holds it, or completed it; 0: none, or it was kept from before
  float seconds = 0;    ///< since it was assigned, or that it took
  uint8_t copies = 0;   ///< workers that hold it now
};

/// The film of the rect, `channels` values a pixel, light first; rows from the top.
struct FilmView {
  PixelRect rect;
  int channels = kFilmChannels;
  std::span<const float> values;  ///< valid until the coordinator is called again, or:
  BlobData keeps;                 ///< as long as this lives; null: of a frame being traced
};

/// A picture for people, made smaller where it is large.
struct PreviewImage {
  int width = 0, height = 0;
  PixelRect rect;            ///< of the frame, that it shows
  uint64_t tiles_done = 0;   ///< as many tiles as it shows
  std::vector<uint8_t> rgb;  ///< rows from the top; what is not there yet is black
};

}  // namespace tessera
