#include "front/farm_thread.h"

#include <exception>
#include <utility>

#include "base/error.h"

namespace tessera {

FarmThread::FarmThread(Start start) : state_(std::make_unique<State>()) {
  state_->start = std::move(start);
  state_->thread = std::thread([state = state_.get()] { state->run(); });
}

FarmThread::~FarmThread() {
  if (state_.is_ours()) close();
}

void FarmThread::submit(std::shared_ptr<FrameTask> task) {
  const std::lock_guard lock(state_->mutex);
  if (state_->closed) throw usage_error("farm: it is closed; expected one that is open");
  state_->waiting.push_back(std::move(task));
  state_->changed.notify_all();
}

void FarmThread::close() {
  {
    const std::lock_guard lock(state_->mutex);
    state_->closed = true;
    if (state_->running) state_->running->cancel();
    for (const auto& task : state_->waiting) task->cancel();
    state_->changed.notify_all();
  }
  if (state_->thread.joinable()) state_->thread.join();
}

std::shared_ptr<FrameTask> FarmThread::State::next_task() {
  std::unique_lock lock(mutex);
  changed.wait(lock, [this] { return closed || !waiting.empty(); });
  if (waiting.empty()) return nullptr;
  running = std::move(waiting.front());
  waiting.pop_front();
  return running;
}

void FarmThread::State::run() {
  std::unique_ptr<TracingFarm> farm;
  std::exception_ptr failure;
  try {
    farm = start();
  } catch (...) {
    failure = std::current_exception();
  }
  while (const auto task = next_task()) {
    if (failure) {
      task->fail(failure);
    } else {
      task->run(*farm);
    }
    // `task` may be the last that has it: it is freed once the lock is given back.
    const std::lock_guard lock(mutex);
    running = nullptr;
  }
}

}  // namespace tessera
