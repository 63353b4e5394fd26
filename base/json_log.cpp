#include "base/json_log.h"

#include <fmt/chrono.h>
#include <fmt/format.h>
#include <spdlog/details/log_msg.h>
#include <spdlog/formatter.h>

#include <chrono>
#include <iterator>
#include <memory>
#include <nlohmann/json.hpp>
#include <string>

#include "base/log.h"

namespace tessera {
namespace {

class JsonFormatter : public spdlog::formatter {
 public:
  void format(const spdlog::details::log_msg& message, spdlog::memory_buf_t& line) override {
    const auto since_1970 = message.time.time_since_epoch();
    const auto milliseconds =
        std::chrono::duration_cast<std::chrono::milliseconds>(since_1970).count();
    const auto view = [](spdlog::string_view_t text) {
      return std::string(text.data(), text.size());
    };
    const nlohmann::ordered_json json{
        {"time", fmt::format("{:%Y-%m-%dT%H:%M:%S}.{:03}Z",
                             fmt::gmtime(static_cast<std::time_t>(milliseconds / 1000)),
                             milliseconds % 1000)},
        {"level", view(spdlog::level::to_string_view(message.level))},
        {"process", view(message.logger_name)},
        {"text", view(message.payload)}};
    // Bytes that are no UTF-8 come from other processes, and must not end this one.
    fmt::format_to(std::back_inserter(line), "{}\n",
                   json.dump(-1, ' ', false, nlohmann::ordered_json::error_handler_t::replace));
  }
  std::unique_ptr<spdlog::formatter> clone() const override {
    return std::make_unique<JsonFormatter>();
  }
};

}  // namespace

void log_as_json() { spdlog::default_logger()->set_formatter(std::make_unique<JsonFormatter>()); }

}  // namespace tessera
