#pragma once

#include <sys/types.h>

#include <atomic>
#include <cstdint>
#include <filesystem>
#include <functional>
#include <memory>
#include <string>

#include "base/error.h"
#include "base/monotonic.h"
#include "proto/transport/transport.h"
#include "renderer/render/tile_renderer.h"
#include "worker/blob_cache.h"
#include "worker/crash_record.h"
#include "worker/scene_cache.h"

namespace tessera {

/// How a worker gets from a scene to its tracer; make_tile_renderer, but for tests.
using TileRendererFactory = std::function<std::shared_ptr<const TileRenderer>(
    const v1::Scene& scene, const BlobStore& blobs, const v1::FrameSettings& frame, int threads)>;

struct WorkerOptions {
  int threads = 1;
  /// Where the coordinator is, to be told while it does not answer; empty: not told.
  std::string endpoint{};
  /// Told to stop, how long what is being traced may take.
  Time drain = std::chrono::seconds(25);
  /// Ends after so long without a word from the coordinator; Time::max(): never.
  Time orphan_timeout = std::chrono::seconds(60);
  /// Ends (done) after so long without anything to build, trace or fetch; Time::max(): never.
  Time idle_timeout = Time::max();
  /// Results that are kept in memory for a coordinator that is away.
  uint64_t result_bytes = uint64_t{256} << 20;
  /// Where they are kept beyond that, and when the worker has to end; empty: nowhere. The folder of
  /// `cache`, where there is one, and its budget.
  std::filesystem::path spool_folder{};
  uint64_t spool_budget_bytes = uint64_t{1} << 30;
  /// So many workers before this one were killed for the memory of their group: each time it takes
  /// fewer tiles at one time.
  uint64_t memory_kills = 0;
  TileRendererFactory make_renderer;
  /// Keeps blobs on disk; null: nowhere. Used by no one else.
  std::shared_ptr<BlobCache> cache{};
  /// Where threads note what may crash them, and which frames have done that; null: nowhere. It
  /// must outlive run_worker().
  CrashRecord* crash_record = nullptr;
  /// Whether the coordinator is on this machine, and may share its blobs' memory.
  bool shares_memory = false;
  /// Of a coordinator in this process, whose blobs need no way to the worker; asked by the thread
  /// of run_worker().
  BlobsAtHand at_hand{};
  /// What it says of itself; other values are for tests.
  uint32_t protocol_major = 0;  ///< 0: kProtocolMajor
  std::string numerics_id;      ///< empty: kNumericsId
};

struct WorkerEnd {
  ExitCode exit_code = ExitCode::done;
  /// For the log; names both sides where the coordinator refused. Empty where it left of itself.
  std::string reason;
};

/// Arranges that this process is killed when its parent ends; false if that has already ended.
/// Called first thing in a local worker.
bool die_with_parent(pid_t parent);

/// Works for the coordinator behind `transport` until that says to end, refuses this worker
/// (bad_usage), stays silent too long (render_failed), there is nothing to do for too long (done),
/// or `stop` is set (done): tiles that it has not begun are given back at once, the others once
/// they are traced or that took too long.
WorkerEnd run_worker(ClientTransport& transport, const WorkerOptions& options,
                     const std::atomic<bool>& stop);

}  // namespace tessera
