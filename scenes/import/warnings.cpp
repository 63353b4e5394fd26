#include "scenes/import/warnings.h"

#include <fmt/format.h>

#include "base/plain_text.h"

namespace tessera {

void add_warning(LoadedScene& loaded, const std::string& file, const std::string& what) {
  loaded.warnings.push_back(fmt::format("{}: {}", file, what));
  loaded.warning_diagnostics.push_back(make_diagnostic({file}, what, ""));
}

void Warnings::add(std::string_view what, const Where& where, uint64_t times) {
  const auto known = index_.find(what);
  if (known != index_.end()) {
    entries_[known->second].count += times;
  } else if (entries_.size() >= kMostEntries) {
    dropped_ += times;
  } else {
    index_.emplace(what, entries_.size());
    entries_.push_back({std::string(what), where ? where() : SourcePlace{}, times, {}});
  }
}

void Warnings::repair(std::string_view found, std::string_view expected, std::string_view taken,
                      const Where& where, std::string_view path) {
  const size_t named = path.find_last_not_of("/0123456789");
  std::string_view name = path.substr(0, named == path.npos ? 0 : path.find('/', named));
  name.remove_prefix(name.rfind('/') + 1);
  const std::string key = fmt::format("{}\n{}\n{}", name, expected, taken);
  if (const auto known = index_.find(key); known != index_.end()) {
    ++entries_[known->second].count;
    return;
  }
  if (entries_.size() >= kMostInAll) {
    ++dropped_;
    return;
  }
  index_.emplace(key, entries_.size());
  const std::string said = path.empty() ? std::string(found) : fmt::format("{}: {}", path, found);
  const SourcePlace place = where ? where() : SourcePlace{};
  entries_.push_back({fmt::format("{}; expected {}; {}", said, expected, taken), place, 1,
                      make_diagnostic(place, said, expected)});
}

void Warnings::repair(const Error& error, std::string_view taken) {
  const Diagnostic& told = error.diagnostics().front();
  repair(told.found, told.expected, taken, [&] { return told.place; });
}

void Warnings::missing(std::string_view what, const Where& where) {
  add(what, where);
  const auto known = index_.find(what);
  if (known == index_.end()) return;
  Entry& entry = entries_[known->second];
  if (!entry.repair) entry.repair = make_diagnostic(entry.place, what, "");
}

std::vector<std::string> Warnings::list(const std::string& file) const {
  std::vector<std::string> lines;
  for (const Entry& entry : entries_) {
    const std::string place = entry.place.file.empty() ? file : entry.place.str();
    const std::string times = entry.count == 1 ? "" : fmt::format(" ({} times)", entry.count);
    lines.push_back(escape_controls(fmt::format("{}: {}{}", place, entry.what, times)));
  }
  if (dropped_) lines.push_back(fmt::format("{}: and {} warnings of other kinds", file, dropped_));
  return lines;
}

void Warnings::add_to(LoadedScene& loaded, const std::string& file) const {
  for (std::string& line : list(file)) loaded.warnings.push_back(std::move(line));
  for (const Entry& entry : entries_) {
    const SourcePlace place = entry.place.file.empty() ? SourcePlace{file} : entry.place;
    loaded.warning_diagnostics.push_back(make_diagnostic(place, entry.what, ""));
    if (!entry.repair) continue;
    loaded.repairs.push_back(*entry.repair);
    loaded.repairs.back().place = place;
  }
  if (dropped_) {
    loaded.warning_diagnostics.push_back(
        make_diagnostic({file}, fmt::format("and {} warnings of other kinds", dropped_), ""));
  }
}

}  // namespace tessera
