#include <pybind11/stl.h>
#include <spdlog/sinks/base_sink.h>

#include <deque>
#include <memory>
#include <mutex>
#include <string>
#include <utility>
#include <vector>

#include "base/log.h"
#include "python/bindings.h"

namespace py = pybind11;

namespace tessera {
namespace {

constexpr size_t kMostKept = 1000;

/// Keeps what is logged until Python takes it: who logs never waits for the GIL. Of more
/// than kMostKept messages the first are dropped.
class LogQueue : public spdlog::sinks::base_sink<std::mutex> {
 public:
  std::vector<std::pair<int, std::string>> take() {
    const std::lock_guard lock(mutex_);
    std::vector<std::pair<int, std::string>> out(kept_.begin(), kept_.end());
    kept_.clear();
    return out;
  }

 protected:
  void sink_it_(const spdlog::details::log_msg& message) override {
    if (kept_.size() == kMostKept) kept_.pop_front();
    kept_.emplace_back(static_cast<int>(message.level),
                       std::string(message.payload.data(), message.payload.size()));
  }
  void flush_() override {}

 private:
  std::deque<std::pair<int, std::string>> kept_;
};

}  // namespace

void bind_log(py::module_& module) {
  auto queue = std::make_shared<LogQueue>();
  auto logger = std::make_shared<spdlog::logger>("tessera", queue);
  logger->set_level(spdlog::level::info);
  spdlog::set_default_logger(std::move(logger));
  // Levels are those of spdlog: 0 trace to 5 critical.
  module.def("take_log", [queue] { return queue->take(); });
}

}  // namespace tessera
