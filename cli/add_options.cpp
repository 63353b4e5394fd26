#include "cli/add_options.h"

#include <fmt/format.h>

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

void check_texts(CLI::App& command) {
  for (CLI::Option* option : command.get_options([](const CLI::Option*) { return true; })) {
    if (option->get_items_expected_max() == 0) continue;  // a flag
    const std::string type = option->get_type_name();
    const bool is_named = option->nonpositional();
    option->check([type, is_named, &command](const std::string& text) {
      const bool is_option =
          is_named && text.starts_with("-") && command.get_option_no_throw(text) != nullptr;
      return is_option ? fmt::format("'{}', which is an option; expected {}", text, type)
                       : wrong_text(text, type);
    });
  }
  const auto any = [](const CLI::App*) { return true; };
  for (CLI::App* below : command.get_subcommands(any)) check_texts(*below);
}

void add_whole(CLI::App& command, const std::string& name, int64_t least, int64_t most,
               const std::string& text, std::function<void(int64_t)> assign) {
  command
      .add_option_function<std::string>(
          name, [=](const std::string& typed) { assign(parse_whole(name, typed, least, most)); },
          text)
      ->type_name("N");
}

void add_http_origin(CLI::App& command, std::optional<PublicAddress>& address) {
  command
      .add_option_function<std::string>(
          "--http-origin",
          [&address](const std::string& text) {
            address = parse_public_address("--http-origin", text);
          },
          "Where browsers reach the page if a proxy is before it, such as "
          "https://farm.example/tessera/: orders of the page there are taken")
      ->type_name("URL");
}

}  // namespace tessera
