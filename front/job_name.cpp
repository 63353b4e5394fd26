#include "front/job_name.h"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <charconv>
#include <optional>
#include <vector>

#include "base/error.h"
#include "base/plural.h"
#include "proto/wire/printable.h"

namespace tessera {
namespace {

std::optional<uint64_t> whole(const std::string& text) {
  uint64_t value = 0;
  const auto [end, error] = std::from_chars(text.data(), text.data() + text.size(), value);
  const bool all = error == std::errc() && end == text.data() + text.size();
  return all ? std::optional(value) : std::nullopt;
}

constexpr size_t kMostListed = 8;

/// "there are 2 jobs: 1 knot, 2 mosaic", of many the latest.
std::string those_there(const v1::JobList& list) {
  std::vector<std::string> jobs;
  for (const v1::JobStatus& job : list.jobs()) {
    jobs.push_back(fmt::format("{} {}", job.job(), printable(job.name())));
  }
  const size_t listed = std::min(jobs.size(), kMostListed);
  return fmt::format("there {} {}: {}{}", jobs.size() == 1 ? "is" : "are",
                     counted(jobs.size(), "job"), jobs.size() > listed ? "... " : "",
                     fmt::join(jobs.end() - static_cast<ptrdiff_t>(listed), jobs.end(), ", "));
}

/// Of several jobs of that name, the latest is meant.
std::string which_is_meant(const std::string& name, const std::vector<uint64_t>& jobs) {
  const size_t others = jobs.size() - 1, listed = std::min(others, kMostListed);
  const auto last = jobs.end() - 1;
  return fmt::format("{} have the name '{}': job {}, the latest, is meant, not {}{}",
                     counted(jobs.size(), "job"), printable(name), jobs.back(),
                     others > listed ? "... " : "",
                     fmt::join(last - static_cast<ptrdiff_t>(listed), last, ", "));
}

}  // namespace

uint64_t find_job(FarmClient& client, const std::string& text,
                  const std::function<void(const std::string&)>& tell) {
  const v1::JobList list = client.list();
  const auto number = whole(text);
  std::vector<uint64_t> found;
  std::vector<std::string> names;
  for (const v1::JobStatus& job : list.jobs()) {
    names.push_back(printable(job.name()));
    if (number ? job.job() == *number : job.name() == text) found.push_back(job.job());
  }
  if (found.size() > 1) tell(which_is_meant(text, found));
  if (!found.empty()) return found.back();
  if (list.jobs().empty()) throw usage_error(fmt::format("JOB: '{}': there are no jobs", text));
  const bool forgotten = number && *number >= 1 && *number <= list.last();
  throw usage_error(fmt::format("JOB: '{}' is {}; {}{}", text, forgotten ? "forgotten" : "no job",
                                those_there(list), number ? "" : suggestion(text, names)));
}

}  // namespace tessera
