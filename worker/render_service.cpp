#include "worker/render_service.h"

#include <algorithm>
#include <exception>
#include <new>
#include <utility>

#include "base/cancellation.h"
#include "base/error.h"
#include "base/monotonic.h"
#include "base/signal_stack.h"

namespace tessera {
namespace {

constexpr Time kLongestUntold = std::chrono::milliseconds(50);

template <typename T>
std::optional<T> pop(std::mutex& mutex, std::deque<T>& queue) {
  const std::lock_guard lock(mutex);
  if (queue.empty()) return std::nullopt;
  std::optional<T> value = std::move(queue.front());
  queue.pop_front();
  return value;
}

}  // namespace

RenderService::RenderService(TileRendererFactory factory, int threads, std::function<void()> wake,
                             CrashRecord* record)
    : factory_(std::move(factory)),
      thread_count_(std::max(1, threads)),
      wake_(std::move(wake)),
      record_(record) {
  try {
    for (int i = 0; i < thread_count_; ++i) threads_.emplace_back([this, i] { work(i); });
  } catch (...) {  // no memory for another one
    end_threads();
    throw;
  }
}

RenderService::~RenderService() { end_threads(); }

void RenderService::end_threads() {
  {
    const std::lock_guard lock(mutex_);
    stop_ = true;
  }
  changed_.notify_all();
  for (std::thread& thread : threads_) thread.join();
}

void RenderService::build(std::shared_ptr<const BuildRun> run) {
  {
    const std::lock_guard lock(mutex_);
    builds_.push_back(std::move(run));
  }
  changed_.notify_one();
}

void RenderService::trace(std::shared_ptr<TraceRun> run) {
  {
    const std::lock_guard lock(mutex_);
    runs_.push_back(std::move(run));
  }
  changed_.notify_one();
}

std::optional<BuildOutcome> RenderService::take_built() { return pop(mutex_, built_); }
std::optional<TraceOutcome> RenderService::take_traced() { return pop(mutex_, traced_); }

void RenderService::work(int number) {
  const SignalStack stack;
  std::unique_lock lock(mutex_);
  while (true) {
    changed_.wait(lock, [this] { return stop_ || !builds_.empty() || !runs_.empty(); });
    if (stop_) return;
    if (!builds_.empty()) {
      const auto run = std::move(builds_.front());
      builds_.pop_front();
      lock.unlock();
      BuildOutcome outcome;
      {
        const CrashRecord::Note note(record_, number, CrashRecord::Activity::build, run->frame_id);
        outcome = build_now(*run);
      }
      lock.lock();
      built_.push_back(std::move(outcome));
    } else {
      auto run = std::move(runs_.front());
      runs_.pop_front();
      lock.unlock();
      TraceOutcome outcome;
      {
        const CrashRecord::Note note(record_, number, CrashRecord::Activity::trace, run->frame_id);
        outcome = tessera::trace(std::move(run));
      }
      if (record_ && !outcome.bands.empty()) record_->note_traced();
      lock.lock();
      traced_.push_back(std::move(outcome));
      const Time now = monotonic_now();
      if (!is_worth_telling(runs_.size(), thread_count_, now - told_)) continue;
      told_ = now;
    }
    lock.unlock();
    wake_();
    lock.lock();
  }
}

bool RenderService::is_worth_telling(size_t waiting, int threads, Time since_told) {
  const bool enough_to_do = waiting > static_cast<size_t>(threads + 1) / 2;
  return !enough_to_do || since_told >= kLongestUntold;
}

BuildOutcome RenderService::build_now(const BuildRun& run) const {
  BuildOutcome outcome;
  outcome.job = run.job;
  outcome.frame_id = run.frame_id;
  const Time start = monotonic_now();
  const Cancellation cancellation(run.dropped.get());
  run.started = true;
  try {
    Cancellation::check();
    outcome.renderer = factory_(run.scene(), run.blobs, run.frame, thread_count_);
    if (!outcome.renderer) throw render_error("the scene gave no tracer");
  } catch (const WorkCancelled&) {
    outcome.dropped = true;
  } catch (const Error& error) {
    outcome.failure = error.what();
    outcome.cause = error.code() == ExitCode::bad_scene   ? v1::SceneFailed::BAD_SCENE
                    : error.code() == ExitCode::try_again ? v1::SceneFailed::OUT_OF_RESOURCES
                                                          : v1::SceneFailed::OTHER;
  } catch (const std::bad_alloc&) {
    outcome.failure = "there is not enough memory for the scene";
    outcome.cause = v1::SceneFailed::OUT_OF_RESOURCES;
  } catch (const std::exception& error) {
    outcome.failure = error.what();
  }
  outcome.seconds = to_seconds(monotonic_now() - start);
  return outcome;
}

}  // namespace tessera
