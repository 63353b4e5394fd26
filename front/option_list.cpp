#include "front/option_list.h"

#include <fmt/format.h>

#include <algorithm>

#include "base/error.h"

namespace tessera {

static std::vector<std::string> long_names(const OptionList& options) {
  std::vector<std::string> names;
  for (const Option& option : options) names.push_back(option.long_name());
  return names;
}

std::string wrong_text(std::string_view text, std::string_view type) {
  return text.empty() ? fmt::format("''; expected {}", type) : std::string();
}

void assign_option(const OptionList& options, const std::string& long_name,
                   const OptionValue& value) {
  const auto found = std::ranges::find(options, long_name, &Option::long_name);
  if (found == options.end()) {
    throw usage_error("--" + long_name + ": no option is called so" +
                      suggestion(long_name, long_names(options)));
  }
  const bool* is_set = std::get_if<bool>(&value);
  const bool is_flag = found->type.empty();
  if (is_set && !is_flag) {
    const std::string text = *is_set ? "true" : "false";
    found->assign(text);  // which tells what is expected, if this is not
    throw usage_error(fmt::format("--{}: '{}'; expected {}", long_name, text, found->type));
  }
  if (!is_set && is_flag) {
    throw usage_error(
        fmt::format("--{}: '{}'; expected true or false", long_name, std::get<std::string>(value)));
  }
  if (is_set) {
    if (*is_set) found->assign("");
    return;
  }
  const std::string& text = std::get<std::string>(value);
  if (const std::string wrong = wrong_text(text, found->type); !wrong.empty()) {
    throw usage_error(fmt::format("--{}: {}", long_name, wrong));
  }
  found->assign(text);
}

}  // namespace tessera
