#pragma once

#include <cstdint>
#include <functional>
#include <string>

#include "front/option_list.h"

namespace CLI {
class App;
}

namespace tessera {

/// Adds the options of the list to a command.
void add_options(CLI::App& command, const OptionList& options);

/// Adds an option that is a whole number in [least, most].
void add_whole(CLI::App& command, const std::string& name, int64_t least, int64_t most,
               const std::string& text, std::function<void(int64_t)> assign);
/// `value` must outlive the parsing.
template <typename Number>
void add_whole(CLI::App& command, const std::string& name, int64_t least, int64_t most,
               const std::string& text, Number& value) {
  add_whole(command, name, least, most, text,
            std::function([&value](int64_t typed) { value = static_cast<Number>(typed); }));
}

}  // namespace tessera
