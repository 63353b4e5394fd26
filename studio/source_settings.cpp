#include "studio/source_settings.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdlib>
#include <optional>
#include <string_view>

#include "scenes/edit/edit_sequence.h"

namespace tessera {
namespace {

struct Setting {
  std::string_view option;
  std::string_view field;  ///< of a message Settings
  bool is_enum = false;
  std::string_view prefix = "";  ///< of the names of its enumeration
};
constexpr std::array kSettings{
    Setting{"width", "width"},
    Setting{"height", "height"},
    Setting{"spp", "sampling.samples_per_pixel"},
    Setting{"target-error", "sampling.target_error"},
    Setting{"min-spp", "sampling.min_samples"},
    Setting{"seed", "sampling.seed"},
    Setting{"pattern", "sampling.pattern", true},
    Setting{"filter", "sampling.filter", true},
    Setting{"integrator", "integrator.kind"},
    Setting{"max-depth", "integrator.max_depth"},
    Setting{"shadows", "integrator.shadows", true, "SHADOWS_"},
    Setting{"exposure", "output.exposure"},
    Setting{"tone-map", "output.tone_map", true},
    Setting{"transfer", "output.transfer", true},
    Setting{"gamma", "output.gamma"},
};

edit::Change no_setting(std::string found, std::string expected) {
  edit::Change change;
  change.refusal = edit::Refusal{std::move(found), std::move(expected), {}};
  return change;
}

/// As the schema names the values of its enumerations.
std::string enum_name(std::string text) {
  for (char& c : text) {
    if (c == '-') c = '_';
    if ('a' <= c && c <= 'z') c = static_cast<char>(c - 'a' + 'A');
  }
  return text;
}

edit::Change set_message(const edit::Outline& outline, std::string_view option,
                         const std::string& value) {
  const auto setting = std::find_if(kSettings.begin(), kSettings.end(),
                                    [&](const Setting& each) { return each.option == option; });
  if (setting == kSettings.end())
    return no_setting(std::string(option), "an option that scenes have a setting for");
  return edit::set_field(
      outline, 0, fmt::format("settings.{}", setting->field),
      setting->is_enum ? std::string(setting->prefix) + enum_name(value) : value);
}

/// A script takes n x n samples.
edit::Change set_script(const edit::Outline& outline, std::string_view option, std::string value) {
  std::string field;
  if (option == "width" || option == "height") field = option;
  if (option == "max-depth") field = "recursiondepth";
  if (option == "spp") {
    const double side = std::sqrt(std::strtod(value.c_str(), nullptr));
    if (side != std::floor(side))
      return no_setting(fmt::format("{} samples", value), "a square number: scripts take n x n");
    field = "supersampling";
    value = fmt::format("{}", side);
  }
  if (field.empty()) return no_setting(std::string(option), "width, height, max-depth or spp");
  for (size_t i = 0; i < outline.entities().size(); ++i) {
    if (outline.entities()[i].kind == edit::EntityKind::settings)
      return edit::set_field(outline, static_cast<int>(i), field, value);
  }
  return no_setting("no Settings", "a Settings block in the script");
}

}  // namespace

edit::Change write_settings(const edit::Outline& outline,
                            const std::vector<std::pair<std::string, std::string>>& options) {
  using edit::Language;
  if (options.empty()) return no_setting("no options", "settings that the view overrides");
  edit::EditSequence sequence(outline);
  for (const auto& [option, value] : options) {
    sequence.then([&option = option, &value = value](const edit::Outline& now) {
      switch (now.language()) {
        case Language::tessera:
        case Language::json:
          return set_message(now, option, value);
        case Language::crt:
          return set_script(now, option, value);
        default:
          return no_setting("a language without settings", ".tessera, .json or .crt");
      }
    });
  }
  return sequence.finish();
}

}  // namespace tessera
