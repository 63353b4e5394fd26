#include "web/log_ring.h"

#include <algorithm>
#include <chrono>
#include <utility>

#include "base/log.h"

namespace tessera {
namespace {

constexpr size_t kLines = 500;

}  // namespace

class LogRing::Sink : public spdlog::sinks::base_sink<std::mutex> {
 public:
  explicit Sink(std::shared_ptr<LogRing> ring) : ring_(std::move(ring)) {}

 private:
  void sink_it_(const spdlog::details::log_msg& message) override {
    const auto since_1970 = message.time.time_since_epoch();
    const auto level = spdlog::level::to_string_view(message.level);
    ring_->add({0, std::chrono::duration_cast<std::chrono::milliseconds>(since_1970).count(),
                std::string(level.data(), level.size()),
                std::string(message.payload.data(), message.payload.size())});
  }
  void flush_() override {}

  std::shared_ptr<LogRing> ring_;
};

std::shared_ptr<LogRing> LogRing::attach() {
  auto ring = std::make_shared<LogRing>();
  spdlog::default_logger()->sinks().push_back(std::make_shared<Sink>(ring));
  return ring;
}

void LogRing::add(Line line) {
  const std::scoped_lock lock(mutex_);
  line.number = ++count_;
  lines_.push_back(std::move(line));
  if (lines_.size() > kLines) lines_.pop_front();
}

std::vector<LogRing::Line> LogRing::after(uint64_t after) const {
  const std::scoped_lock lock(mutex_);
  std::vector<Line> result;
  std::copy_if(lines_.begin(), lines_.end(), std::back_inserter(result),
               [after](const Line& line) { return line.number > after; });
  return result;
}

}  // namespace tessera
