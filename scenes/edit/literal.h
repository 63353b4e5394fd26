#pragma once

#include <google/protobuf/descriptor.h>

#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "scenes/edit/edit.h"

namespace tessera::edit {

/// Of a decimal number that a person typed, alone: nothing for "", "1,5", "nan", "inf", "0x10".
std::optional<double> typed_number(std::string_view text);
/// What is wrong with `typed` as a value of the field: nothing where it may be written.
std::optional<Refusal> check_value(const Field& field, std::string_view typed);
/// The parts of a vector: between blanks, or commas with a blank behind them.
std::vector<std::string> typed_parts(std::string_view typed);
std::string_view trimmed(std::string_view text);

/// `number` as JSON and XML have it: without a plus, with digits on both sides of the point.
std::string strict_number(std::string_view number);

/// The shortest decimal number within `tolerance` of `value`.
std::string shortest_number(double value, double tolerance);

/// A free name: `name` itself, else "name 2", "name 3"...
std::string free_name(std::string_view name, const std::vector<std::string>& taken,
                      std::string_view blank);

}  // namespace tessera::edit
