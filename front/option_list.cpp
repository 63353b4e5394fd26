#include "front/option_list.h"

#include <algorithm>

#include "base/error.h"

namespace tessera {

std::vector<std::string> long_names(const OptionList& options) {
  std::vector<std::string> names;
  for (const Option& option : options) names.push_back(option.long_name());
  return names;
}

void assign_option(const OptionList& options, const std::string& long_name,
                   const std::string& text) {
  const auto found = std::ranges::find(options, long_name, &Option::long_name);
  if (found == options.end()) {
    throw usage_error("--" + long_name + ": no option is called so" +
                      suggestion(long_name, long_names(options)));
  }
  found->assign(text);
}

}  // namespace tessera
