#include "proto/transport/allow_list.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <vector>

#include "base/error.h"
#include "proto/transport/text_lines.h"

namespace tessera {
namespace {

constexpr size_t kLongestName = 64;
constexpr std::array kRoles{Role::worker, Role::submitter, Role::viewer};

/// Hostile bytes of a file do not reach a terminal.
std::string shown(std::string_view text) {
  constexpr size_t kMost = 80;
  std::string result(text.substr(0, kMost));
  std::replace_if(
      result.begin(), result.end(), [](char c) { return c < ' ' || c > '~'; }, '?');
  return result;
}

}  // namespace

std::string_view role_name(Role role) {
  switch (role) {
    case Role::worker:
      return "worker";
    case Role::submitter:
      return "submitter";
    case Role::viewer:
      return "viewer";
    case Role::any:
      break;
  }
  return "any";
}

Role parse_role(std::string_view text, const std::string& place) {
  std::vector<std::string> names;
  for (const Role role : kRoles) {
    if (text == role_name(role)) return role;
    names.emplace_back(role_name(role));
  }
  throw usage_error(fmt::format("{}: role '{}'; expected {}{}", place, shown(text),
                                fmt::join(names, ", "), suggestion(text, names)));
}

void check_key_name(std::string_view name, const std::string& place) {
  const auto good = [](char c) {
    return (c >= 'a' && c <= 'z') || (c >= 'A' && c <= 'Z') || (c >= '0' && c <= '9') || c == '.' ||
           c == '_' || c == '-';
  };
  if (!name.empty() && name.size() <= kLongestName && std::all_of(name.begin(), name.end(), good)) {
    return;
  }
  throw usage_error(fmt::format("{}: name '{}'; expected 1 to {} of A-Z a-z 0-9 . _ -", place,
                                shown(name), kLongestName));
}

AllowList AllowList::parse(std::string_view text, const std::string& file) {
  AllowList list;
  for (const TextLine& line : text_lines(text)) {
    const auto place = [&](size_t word) {
      return SourcePlace{file, line.number, line.words[word].column}.str();
    };
    const auto key = parse_key(line.words[0].text);
    if (!key) {
      throw usage_error(
          fmt::format("{}: '{}'; expected a public key of 64 digits 0-9 a-f, as 'tessera keygen' "
                      "prints it",
                      place(0), shown(line.words[0].text)));
    }
    if (line.words.size() != 3) {
      const size_t last = std::min<size_t>(line.words.size() - 1, 3);
      throw usage_error(fmt::format("{}: {} words; expected three: KEY ROLE NAME", place(last),
                                    line.words.size()));
    }
    if (line.words[1].text == "coordinator") {
      throw usage_error(
          fmt::format("{}: a coordinator's own key; expected keys of workers, "
                      "submitters and viewers",
                      place(1)));
    }
    AllowedKey allowed{parse_role(line.words[1].text, place(1)), std::string(line.words[2].text),
                       key_text(*key)};
    check_key_name(allowed.name, place(2));
    if (!list.keys_.emplace(key_text(*key), std::move(allowed)).second) {
      throw usage_error(
          fmt::format("{}: this key is listed twice; expected one role for each key", place(0)));
    }
  }
  return list;
}

std::string AllowList::line(const Key& key, const AllowedKey& allowed) {
  return fmt::format("{} {} {}\n", key_text(key), role_name(allowed.role), allowed.name);
}

size_t AllowList::count(Role role) const {
  return static_cast<size_t>(std::count_if(
      keys_.begin(), keys_.end(), [role](const auto& key) { return key.second.role == role; }));
}

const AllowedKey* AllowList::find(const std::string& hex) const {
  const auto it = keys_.find(hex);
  return it == keys_.end() ? nullptr : &it->second;
}

}  // namespace tessera
