#pragma once

#include <cstdint>
#include <functional>
#include <string>
#include <string_view>
#include <utility>
#include <variant>
#include <vector>

namespace tessera {

/// One option of a command, by whatever front end it is given: `--spp 16` on the command line is
/// `spp=16` in Python.
struct Option {
  std::string names;  ///< as typed, such as "--spp" or "-o,--output"
  std::string type;   ///< what stands for its value in help texts; empty: a flag, without a value
  std::string group;  ///< the heading that it stands below in help texts
  std::string help;
  /// Takes the value as text; of a flag the text is empty. Throws usage_error for a wrong value.
  std::function<void(const std::string&)> assign;
  bool repeats = false;                ///< may be given more than once
  std::vector<std::string> choices{};  ///< the names that it takes; empty: what it takes is no name
  int64_t most = 0;                    ///< the largest number that it takes; 0: there is none

  /// Without dashes, such as "spp" or "output".
  std::string long_name() const { return names.substr(names.rfind("--") + 2); }
};

/// The options of a command in the order of its help text. What they assign to must outlive them.
using OptionList = std::vector<Option>;

/// What is assigned to an option: of a flag whether it is set, of others the text that is typed.
using OptionValue = std::variant<bool, std::string>;

/// What is wrong with a value as text, whatever its option: "''; expected FILE" for the empty one,
/// which is what a script's unset variable leaves. An option that is not given is left out.
/// Returns the empty text where nothing is wrong. `type`: as Option::type, not empty.
std::string wrong_text(std::string_view text, std::string_view type);
/// Assigns the option of that long name. Throws usage_error, with the nearest name, where there is
/// none, and for a value that is wrong or of the other kind.
void assign_option(const OptionList& options, const std::string& long_name,
                   const OptionValue& value);

/// Adds options of one group to a list.
class OptionGroup {
 public:
  OptionGroup(OptionList& list, std::string name) : list_(list), name_(std::move(name)) {}

  Option& add(std::string names, std::string type, std::string help,
              std::function<void(const std::string&)> assign) {
    list_.push_back({.names = std::move(names),
                     .type = std::move(type),
                     .group = name_,
                     .help = std::move(help),
                     .assign = std::move(assign)});
    return list_.back();
  }
  /// `value` takes the text as it is, and must outlive the parsing.
  Option& add_text(std::string names, std::string type, std::string help, std::string& value) {
    return add(std::move(names), std::move(type), std::move(help),
               [&value](const std::string& text) { value = text; });
  }
  /// Sets `value`, which must outlive the parsing.
  Option& add_flag(std::string names, std::string help, bool& value) {
    return add(std::move(names), "", std::move(help),
               [&value](const std::string&) { value = true; });
  }

 private:
  OptionList& list_;
  std::string name_;
};

}  // namespace tessera
