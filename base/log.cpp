#include "base/log.h"

#include <spdlog/sinks/stdout_color_sinks.h>

#include <memory>

namespace tessera {

void configure_logging(std::string_view level, std::string_view process_name) {
  auto sink = std::make_shared<spdlog::sinks::stderr_color_sink_mt>();
  auto logger = std::make_shared<spdlog::logger>(std::string(process_name), std::move(sink));
  logger->set_level(spdlog::level::from_str(std::string(level)));
  // Local time with its zone, as ISO 8601 has it: logs outlive a day and leave their machine.
  logger->set_pattern("%Y-%m-%dT%H:%M:%S.%e%z %n %^%l%$ %v");
  spdlog::set_default_logger(std::move(logger));
}

}  // namespace tessera
