#include "cli/add_options.h"

#include <CLI/CLI.hpp>
#include <vector>

#include "front/option_values.h"

namespace tessera {

void add_options(CLI::App& command, const OptionList& options) {
  for (const Option& option : options) {
    if (option.type.empty()) {
      command
          .add_flag_callback(
              option.names, [assign = option.assign] { assign(""); }, option.help)
          ->group(option.group);
    } else if (option.repeats) {
      command
          .add_option_function<std::vector<std::string>>(
              option.names,
              [assign = option.assign](const std::vector<std::string>& texts) {
                for (const std::string& text : texts) assign(text);
              },
              option.help)
          ->type_name(option.type)
          ->option_text(option.type)  // not "FILE ...": one each time
          ->allow_extra_args(false)
          ->group(option.group);
    } else {
      command.add_option_function<std::string>(option.names, option.assign, option.help)
          ->type_name(option.type)
          ->group(option.group);
    }
  }
}

void add_whole(CLI::App& command, const std::string& name, int64_t least, int64_t most,
               const std::string& text, std::function<void(int64_t)> assign) {
  command
      .add_option_function<std::string>(
          name, [=](const std::string& typed) { assign(parse_whole(name, typed, least, most)); },
          text)
      ->type_name("N");
}

}  // namespace tessera
