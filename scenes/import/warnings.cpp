#include "scenes/import/warnings.h"

#include <fmt/format.h>

#include "base/plain_text.h"

namespace tessera {

uint64_t& Warnings::entry(std::string_view what) {
  const auto known = index_.find(what);
  if (known != index_.end()) return entries_[known->second].second;
  if (entries_.size() == kMostEntries) return dropped_;
  index_.emplace(what, entries_.size());
  return entries_.emplace_back(what, 0).second;
}

std::vector<std::string> Warnings::list(std::string_view file) const {
  std::vector<std::string> lines;
  for (const auto& [what, count] : entries_)
    lines.push_back(escape_controls(count == 1
                                        ? fmt::format("{}: {}", file, what)
                                        : fmt::format("{}: {} ({} times)", file, what, count)));
  if (dropped_) lines.push_back(fmt::format("{}: and {} warnings of other kinds", file, dropped_));
  return lines;
}

}  // namespace tessera
