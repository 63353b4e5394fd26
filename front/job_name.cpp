#include "front/job_name.h"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <charconv>
#include <optional>
#include <string_view>
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

/// "3 jobs have the name 'knot'"
std::string how_many_have_it(const std::string& name, const std::vector<uint64_t>& jobs) {
  return fmt::format("{} have the name '{}'", counted(jobs.size(), "job"), printable(name));
}

/// "1, 4, 7", of many the latest.
std::string listed(const std::vector<uint64_t>& jobs) {
  const size_t shown = std::min(jobs.size(), kMostListed);
  return fmt::format("{}{}", jobs.size() > shown ? "... " : "",
                     fmt::join(jobs.end() - static_cast<ptrdiff_t>(shown), jobs.end(), ", "));
}

/// The jobs that a text means.
struct Meant {
  std::string name;            ///< empty where the text is a number
  std::vector<uint64_t> jobs;  ///< at least one; of a number just one
};

Meant jobs_meant(FarmClient& client, const std::string& text) {
  constexpr std::string_view kByName = "name:";
  const v1::JobList list = client.list();
  const bool by_name = text.starts_with(kByName);
  const auto number = by_name ? std::nullopt : whole(text);
  Meant meant{.name = number ? "" : by_name ? text.substr(kByName.size()) : text, .jobs = {}};
  std::vector<std::string> names;
  bool is_a_name = false;
  for (const v1::JobStatus& job : list.jobs()) {
    names.push_back(printable(job.name()));
    is_a_name |= job.name() == text;
    if (number ? job.job() == *number : job.name() == meant.name) meant.jobs.push_back(job.job());
  }
  if (!meant.jobs.empty()) return meant;
  if (list.jobs().empty()) throw usage_error(fmt::format("JOB: '{}': there are no jobs", text));
  const bool forgotten = number && *number >= 1 && *number <= list.last();
  const std::string near = is_a_name ? fmt::format("; did you mean '{}{}'?", kByName, text)
                           : number  ? ""
                                     : suggestion(meant.name, names);
  throw usage_error(fmt::format("JOB: '{}' is {}; {}{}", text, forgotten ? "forgotten" : "no job",
                                those_there(list), near));
}

}  // namespace

uint64_t find_job(FarmClient& client, const std::string& text,
                  const std::function<void(const std::string&)>& tell) {
  const auto [name, jobs] = jobs_meant(client, text);
  if (jobs.size() > 1) {
    tell(fmt::format("{}: job {}, the latest, is meant, not {}", how_many_have_it(name, jobs),
                     jobs.back(), listed({jobs.begin(), jobs.end() - 1})));
  }
  return jobs.back();
}

uint64_t find_job_to_change(FarmClient& client, const std::string& text) {
  const auto [name, jobs] = jobs_meant(client, text);
  if (jobs.size() == 1) return jobs.front();
  throw usage_error(fmt::format("JOB: {}: {}; expected one of these numbers",
                                how_many_have_it(name, jobs), listed(jobs)));
}

}  // namespace tessera
