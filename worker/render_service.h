#pragma once

#include <condition_variable>
#include <deque>
#include <functional>
#include <memory>
#include <mutex>
#include <optional>
#include <thread>
#include <vector>

#include "worker/crash_record.h"
#include "worker/run_worker.h"
#include "worker/trace_run.h"

namespace tessera {

/// The threads that build scenes and trace tiles, so that whoever owns the socket never waits. All
/// functions are for the owner; `wake` is called by the service's threads when outcomes are there
/// that is_worth_telling(). What they do they note in `record`, null: nowhere.
class RenderService {
 public:
  RenderService(TileRendererFactory factory, int threads, std::function<void()> wake,
                CrashRecord* record = nullptr);
  /// Waits for what runs: cancel it first.
  ~RenderService();
  RenderService(const RenderService&) = delete;
  RenderService& operator=(const RenderService&) = delete;

  void build(std::shared_ptr<const BuildRun> run);
  void trace(std::shared_ptr<TraceRun> run);
  std::optional<BuildOutcome> take_built();
  std::optional<TraceOutcome> take_traced();

  /// Whether the owner shall hear of a traced tile at once, or better of several together: while
  /// enough others wait for the threads, and not for long.
  static bool is_worth_telling(size_t waiting, int threads, Time since_told);

 private:
  void end_threads();
  void work(int number);
  BuildOutcome build_now(const BuildRun& run) const;

  TileRendererFactory factory_;
  int thread_count_;
  std::function<void()> wake_;
  CrashRecord* record_;
  std::mutex mutex_;
  std::condition_variable changed_;
  std::deque<std::shared_ptr<const BuildRun>> builds_;
  std::deque<std::shared_ptr<TraceRun>> runs_;
  std::deque<BuildOutcome> built_;
  std::deque<TraceOutcome> traced_;
  Time told_{};  ///< when the owner last heard of one
  bool stop_ = false;
  std::vector<std::thread> threads_;
};

}  // namespace tessera
