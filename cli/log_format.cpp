#include "cli/log_format.h"

#include <CLI/CLI.hpp>
#include <array>
#include <string>

#include "front/option_values.h"

namespace tessera {

void add_log_format(CLI::App& command, bool& json) {
  command
      .add_option_function<std::string>(
          "--log-format",
          [&json](const std::string& text) {
            static const std::array<std::string, 2> kFormats = {"text", "json"};
            json = parse_choice("--log-format", text, kFormats) == "json";
          },
          "How to write the log: for people, or one JSON object a line [text]")
      ->type_name("text|json");
}

}  // namespace tessera
