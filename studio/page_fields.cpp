#include "studio/page_fields.h"

#include <fmt/format.h>

#include <cmath>

namespace tessera::page {
namespace {

using Json = nlohmann::json;

constexpr size_t kMostOverrides = 64, kMostEntities = 1000, kMostEchoed = 200;

/// Of what a page said, so much as tells which it was.
std::string beginning_of(std::string_view text) {
  size_t size = kMostEchoed;
  if (text.size() <= size) return std::string(text);
  while (size > 0 && (static_cast<unsigned char>(text[size]) & 0xC0) == 0x80) --size;
  return std::string(text.substr(0, size)) + "...";
}

}  // namespace

Error wrong(std::string_view what, std::string_view found, std::string_view expected) {
  return scene_error(
      fmt::format("{}: {}; expected {}", beginning_of(what), beginning_of(found), expected));
}

void Fields::get(const char* name, std::string& value) const {
  if (const Json* field = find(name)) {
    if (!field->is_string()) throw wrong(name, field->dump(), "a text");
    value = field->get<std::string>();
  }
}

void Fields::get(const char* name, bool& value) const {
  if (const Json* field = find(name)) {
    if (!field->is_boolean()) throw wrong(name, field->dump(), "true or false");
    value = field->get<bool>();
  }
}

void Fields::get(const char* name, double& value) const {
  if (const Json* field = find(name)) value = number(name, *field);
}

void Fields::get(const char* name, std::array<double, 3>& value) const {
  if (const Json* field = find(name)) {
    if (!field->is_array() || field->size() != 3) throw wrong(name, field->dump(), "3 numbers");
    for (size_t i = 0; i < 3; ++i) value[i] = number(name, (*field)[i]);
  }
}

void Fields::get(const char* name, std::vector<std::pair<std::string, std::string>>& value) const {
  const Json* field = find(name);
  if (!field) return;
  if (!field->is_object() || field->size() > kMostOverrides)
    throw wrong(name, "something else", "an object of at most 64 options");
  for (const auto& [key, option] : field->items()) {
    if (option.is_string()) {
      value.emplace_back(key, option.get<std::string>());
    } else if (option.is_number() || option.is_boolean()) {
      value.emplace_back(key, option.dump());
    } else if (!option.is_null()) {
      throw wrong(key, option.dump(), "a number, text or flag");
    }
  }
}

void Fields::get(const char* name, std::vector<EntityRef>& value) const {
  const Json* field = find(name);
  if (!field) return;
  if (!field->is_array() || field->size() > kMostEntities)
    throw wrong(name, "something else", "a list of at most 1000 entities");
  for (const Json& each : *field) {
    if (!each.is_array() || each.size() != 2 || !each[0].is_string() || !each[1].is_string())
      throw wrong(name, each.dump(), "[file, entity]");
    value.push_back({each[0].get<std::string>(), each[1].get<std::string>()});
  }
}

const Json* Fields::find(const char* name) const {
  const auto at = object_.find(name);
  return at == object_.end() || at->is_null() ? nullptr : &*at;
}

double Fields::number(const char* name, const Json& field) {
  const double value = field.is_number() ? field.get<double>() : NAN;
  if (!std::isfinite(value)) throw wrong(name, field.dump(), "a finite number");
  return value;
}

int64_t Fields::whole(const char* name, const Json& field, int64_t least, int64_t most) {
  const double value = number(name, field);
  if (value != std::floor(value) || value < static_cast<double>(least) ||
      value > static_cast<double>(most)) {
    throw wrong(name, field.dump(), fmt::format("a whole number from {} to {}", least, most));
  }
  return static_cast<int64_t>(value);
}

}  // namespace tessera::page
