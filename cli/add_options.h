#pragma once

#include <cstdint>
#include <functional>
#include <optional>
#include <string>

#include "front/option_list.h"
#include "web/public_address.h"

namespace CLI {
class App;
}

namespace tessera {

/// Adds the options of the list to a command.
void add_options(CLI::App& command, const OptionList& options);

/// Has every option and argument of the command, and of those below it, checked by wrong_text(),
/// and for the name of an option in place of the value that was forgotten.
void check_texts(CLI::App& command);

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

/// Adds --http-origin of a command that serves a page; `address` must outlive the parsing.
void add_http_origin(CLI::App& command, std::optional<PublicAddress>& address);

}  // namespace tessera
