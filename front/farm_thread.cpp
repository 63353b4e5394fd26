#include "front/farm_thread.h"

#include <exception>
#include <stdexcept>
#include <utility>
#include <vector>

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
  if (state_->closed) throw std::runtime_error("farm: it is closed; expected one that is open");
  if (state_->running || !state_->waiting.empty()) task->queue();
  state_->waiting.push_back(std::move(task));
  state_->wake();
}

void FarmThread::close() {
  // To cancel frees scenes that nobody else has: once the lock is given back.
  std::vector<std::shared_ptr<FrameTask>> tasks;
  {
    const std::lock_guard lock(state_->mutex);
    state_->closed = true;
    tasks.assign(state_->waiting.begin(), state_->waiting.end());
    if (state_->running) tasks.push_back(state_->running);
    state_->wake();
  }
  for (const auto& task : tasks) task->cancel();
  if (state_->thread.joinable()) state_->thread.join();
}

void FarmThread::State::wake() {
  changed.notify_all();
  if (farm) farm->wake();
}

std::shared_ptr<FrameTask> FarmThread::State::next_task() {
  std::unique_lock lock(mutex);
  for (bool attends = farm && !failure; !closed && waiting.empty();) {
    if (!attends) {
      changed.wait(lock);
      continue;
    }
    lock.unlock();
    try {
      attends = farm->attend();
    } catch (...) {
      failure = std::current_exception();
      attends = false;
    }
    lock.lock();
  }
  if (waiting.empty()) return nullptr;
  running = std::move(waiting.front());
  waiting.pop_front();
  return running;
}

void FarmThread::State::run() {
  std::unique_ptr<TracingFarm> started;
  try {
    started = start();
  } catch (...) {
    failure = std::current_exception();
  }
  const auto set_farm = [this](TracingFarm* now) {
    const std::lock_guard lock(mutex);
    farm = now;
  };
  set_farm(started.get());
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
  set_farm(nullptr);
}

}  // namespace tessera
