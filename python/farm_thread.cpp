#include "python/farm_thread.h"

#include <unistd.h>

#include <exception>
#include <utility>

#include "base/error.h"

namespace tessera {

FarmThread::FarmThread(Start start)
    : process_(getpid()), start_(std::move(start)), thread_([this] { run(); }) {}

FarmThread::~FarmThread() {
  if (getpid() == process_) {
    close();
  } else {
    // The thread stayed in the parent: there is nothing to join, and it must not be ended.
    new std::thread(std::move(thread_));
  }
}

void FarmThread::submit(std::shared_ptr<FrameTask> task) {
  const std::lock_guard lock(mutex_);
  if (closed_) throw usage_error("farm: it is closed; expected one that is open");
  waiting_.push_back(std::move(task));
  changed_.notify_all();
}

void FarmThread::close() {
  {
    const std::lock_guard lock(mutex_);
    closed_ = true;
    if (running_) running_->cancel();
    for (const auto& task : waiting_) task->cancel();
    changed_.notify_all();
  }
  if (thread_.joinable()) thread_.join();
}

std::shared_ptr<FrameTask> FarmThread::next_task() {
  std::unique_lock lock(mutex_);
  running_ = nullptr;
  changed_.wait(lock, [this] { return closed_ || !waiting_.empty(); });
  if (waiting_.empty()) return nullptr;
  running_ = std::move(waiting_.front());
  waiting_.pop_front();
  return running_;
}

void FarmThread::run() {
  std::unique_ptr<TracingFarm> farm;
  std::exception_ptr failure;
  try {
    farm = start_();
  } catch (...) {
    failure = std::current_exception();
  }
  while (const auto task = next_task()) {
    if (failure) {
      task->fail(failure);
      continue;
    }
    task->run(*farm);
  }
}

}  // namespace tessera
