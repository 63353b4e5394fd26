#include "proto/transport/allow_list.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cstdio>
#include <vector>

#include "base/error.h"
#include "proto/transport/text_lines.h"

namespace tessera {
namespace {

constexpr size_t kLongestName = 64;
constexpr std::array kRoles{Role::worker, Role::submitter, Role::viewer};
constexpr std::string_view kEnrol = "enrol:";

/// Hostile bytes of a file do not reach a terminal.
std::string shown(std::string_view text) {
  constexpr size_t kMost = 80;
  std::string result(text.substr(0, kMost));
  std::replace_if(
      result.begin(), result.end(), [](char c) { return c < ' ' || c > '~'; }, '?');
  return result;
}

/// Takes up "until=TIME" and the like. False for any other word.
bool set_attribute(AllowedKey& allowed, std::string_view word) {
  const size_t equals = word.find('=');
  if (equals == word.npos) return false;
  const std::string_view name = word.substr(0, equals), value = word.substr(equals + 1);
  if (name == "token") {
    const bool good = parse_key(value) && allowed.token.empty();
    if (good) allowed.token = value;
    return good;
  }
  if (name != "until" && name != "since") return false;
  std::optional<WallTime>& time = name == "until" ? allowed.until : allowed.since;
  const auto parsed = parse_wall_time(value);
  if (!parsed || time) return false;
  time = parsed;
  return true;
}

}  // namespace

WallTime wall_clock_now() {
  return std::chrono::floor<std::chrono::seconds>(std::chrono::system_clock::now());
}

std::string wall_time_text(WallTime time) {
  const auto day = std::chrono::floor<std::chrono::days>(time);
  const std::chrono::year_month_day date(day);
  const std::chrono::hh_mm_ss clock(time - day);
  return fmt::format("{:04}-{:02}-{:02}T{:02}:{:02}:{:02}Z", int(date.year()),
                     unsigned(date.month()), unsigned(date.day()), clock.hours().count(),
                     clock.minutes().count(), clock.seconds().count());
}

std::optional<WallTime> parse_wall_time(std::string_view text) {
  int year = 0;
  unsigned month = 0, day = 0, hour = 0, minute = 0, second = 0;
  if (std::sscanf(std::string(text).c_str(), "%4d-%2u-%2uT%2u:%2u:%2uZ", &year, &month, &day, &hour,
                  &minute, &second) != 6) {
    return std::nullopt;
  }
  const std::chrono::year_month_day date{std::chrono::year(year), std::chrono::month(month),
                                         std::chrono::day(day)};
  if (!date.ok()) return std::nullopt;
  const WallTime time = std::chrono::sys_days(date) + std::chrono::hours(hour) +
                        std::chrono::minutes(minute) + std::chrono::seconds(second);
  // Whatever was overlooked, such as the 25th hour or a sign, reads otherwise when it is written.
  return wall_time_text(time) == text ? std::optional(time) : std::nullopt;
}

std::string_view role_name(Role role) {
  switch (role) {
    case Role::worker:
      return "worker";
    case Role::submitter:
      return "submitter";
    case Role::viewer:
      return "viewer";
    case Role::enrol:
      return "enrol";
    case Role::revoked:
      return "revoked";
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
    if (line.words.size() < 3) {
      throw usage_error(fmt::format("{}: {} words; expected at least three: KEY ROLE NAME",
                                    place(line.words.size() - 1), line.words.size()));
    }
    const std::string_view role = line.words[1].text;
    if (role == "coordinator") {
      throw usage_error(
          fmt::format("{}: a coordinator's own key; expected keys of workers, "
                      "submitters and viewers",
                      place(1)));
    }
    AllowedKey allowed{{}, std::string(line.words[2].text), key_text(*key)};
    if (role.starts_with(kEnrol)) {
      allowed.role = Role::enrol;
      allowed.grants = parse_role(role.substr(kEnrol.size()), place(1));
    } else {
      allowed.role = role == role_name(Role::revoked) ? Role::revoked : parse_role(role, place(1));
    }
    for (size_t i = 3; i < line.words.size(); ++i) {
      if (set_attribute(allowed, line.words[i].text)) continue;
      throw usage_error(
          fmt::format("{}: '{}'; expected nothing, or one each of until=TIME, token=KEY and "
                      "since=TIME, TIME being such as 2026-11-24T12:00:00Z",
                      place(i), shown(line.words[i].text)));
    }
    check_key_name(allowed.name, place(2));
    if (!list.keys_.emplace(key_text(*key), std::move(allowed)).second) {
      throw usage_error(
          fmt::format("{}: this key is listed twice; expected one role for each key", place(0)));
    }
  }
  return list;
}

std::string AllowList::line(const Key& key, const AllowedKey& allowed) {
  std::string line = fmt::format(
      "{} {}{} {}", key_text(key), allowed.role == Role::enrol ? kEnrol : std::string_view(),
      role_name(allowed.role == Role::enrol ? allowed.grants : allowed.role), allowed.name);
  if (allowed.until) line += " until=" + wall_time_text(*allowed.until);
  if (!allowed.token.empty()) line += " token=" + allowed.token;
  if (allowed.since) line += " since=" + wall_time_text(*allowed.since);
  return line + "\n";
}

size_t AllowList::count(Role role, WallTime now) const {
  return static_cast<size_t>(std::count_if(keys_.begin(), keys_.end(), [&](const auto& key) {
    return key.second.role == role && admitted(key.first, now);
  }));
}

const AllowedKey* AllowList::find(const std::string& hex) const {
  const auto it = keys_.find(hex);
  return it == keys_.end() ? nullptr : &it->second;
}

const AllowedKey* AllowList::admitted(const std::string& hex, WallTime now) const {
  const AllowedKey* const key = find(hex);
  const bool in = key && key->role != Role::revoked && !(key->until && now >= *key->until);
  return in ? key : nullptr;
}

void AllowList::add(const AllowList& other) {
  keys_.insert(other.keys_.begin(), other.keys_.end());
}

}  // namespace tessera
