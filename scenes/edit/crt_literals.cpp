#include "scenes/edit/crt_literals.h"

#include <fmt/format.h>

#include <array>
#include <charconv>
#include <cmath>

#include "base/error.h"
#include "scenes/edit/crt_edit.h"
#include "scenes/edit/crt_outline.h"
#include "scenes/edit/literal.h"
#include "scenes/edit/message_outline.h"

namespace tessera::edit {

/// The literal of a value that stands in the text for the first time.
std::string new_crt_literal(const Field& field, std::string_view typed) {
  switch (field.kind) {
    case ValueKind::vector:
    case ValueKind::color: {
      std::string parts;
      for (const std::string& part : typed_parts(typed))
        parts += (parts.empty() ? "" : ", ") + crt_number(part, "");
      return fmt::format("{}({})", field.kind == ValueKind::vector ? "vec3" : "rgb", parts);
    }
    case ValueKind::text:
    case ValueKind::file:
      return quote(typed, '"', false);
    case ValueKind::choice:
      return quote(trimmed(typed), '"', false);
    case ValueKind::number:
    case ValueKind::integer:
      return crt_number(trimmed(typed), "");
    default:
      return std::string(trimmed(typed));
  }
}

std::optional<Refusal> check_crt_parts(const Field& field, std::string_view typed) {
  const auto parts = typed_parts(typed);
  const bool is_color = field.kind == ValueKind::color;
  Field part;
  part.kind = ValueKind::number;
  if (is_color) part.limits.least = 0;
  if (parts.size() != 3)
    return Refusal{
        typed.empty() ? "nothing" : fmt::format("'{}'", typed), "3 numbers between blanks", {}};
  for (const std::string& one : parts)
    if (auto refusal = check_value(part, one)) return refusal;
  return {};
}

std::optional<Refusal> check_crt_reference(const Outline& outline, std::string_view typed) {
  const std::string name(trimmed(typed));
  const CrtVariables variables = crt_variables(outline.text(), outline.tree());
  const auto found = variables.find(name);
  if (found != variables.end() && found->second.assigned > 0) return {};
  std::vector<std::string> names;
  for (const auto& [known, variable] : variables)
    if (variable.assigned > 0) names.emplace_back(known);
  return Refusal{fmt::format("'{}'", name),
                 fmt::format("the name of a variable{}", suggestion(name, names)),
                 {}};
}

std::optional<Refusal> check_new_crt(const Outline& outline, const Field& field,
                                     std::string_view typed) {
  if (field.kind == ValueKind::vector || field.kind == ValueKind::color)
    return check_crt_parts(field, typed);
  if (field.kind == ValueKind::reference) return check_crt_reference(outline, typed);
  return check_value(field, typed);
}

std::string crt_number(std::string_view typed, std::string_view old) {
  std::string made = strict_number(typed);
  if (made.find_first_of("eE") != std::string::npos) {
    std::array<char, 400> digits;
    const double value = typed_number(typed).value_or(0);
    const auto [end, error] = std::to_chars(digits.data(), digits.data() + digits.size(), value,
                                            std::chars_format::fixed);
    made.assign(digits.data(), error == std::errc() ? end : digits.data());
  }
  const bool is_float = made.find('.') != std::string::npos;
  const bool was_float = old.find('.') != std::string_view::npos;
  const auto value = typed_number(made);
  constexpr double kMostInteger = 2147483647;
  if (!is_float && (was_float || (value && std::abs(*value) > kMostInteger))) made += ".0";
  return made;
}

}  // namespace tessera::edit
