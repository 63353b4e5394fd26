#include <fmt/format.h>

#include <algorithm>
#include <map>

#include "base/error.h"
#include "bench/error_bench.h"
#include "renderer/accel/make_accelerator.h"
#include "renderer/scene/read_settings.h"

namespace tessera {
namespace {

const std::map<std::string, int> kPatterns{{"center", v1::Sampling::CENTER},
                                           {"owen", v1::Sampling::OWEN_SOBOL},
                                           {"centered-grid", v1::Sampling::CENTERED_GRID},
                                           {"corner-grid", v1::Sampling::CORNER_GRID},
                                           {"independent", v1::Sampling::INDEPENDENT}};
const std::map<std::string, int> kFilters{{"box", v1::Sampling::BOX},
                                          {"tent", v1::Sampling::TENT},
                                          {"gaussian", v1::Sampling::GAUSSIAN},
                                          {"mitchell", v1::Sampling::MITCHELL},
                                          {"blackman-harris", v1::Sampling::BLACKMAN_HARRIS}};
constexpr char kAdaptive[] = "adaptive";

bool is_among(const std::string& word, const std::vector<std::string>& names) {
  return std::find(names.begin(), names.end(), word) != names.end();
}

[[noreturn]] void fail_word(const std::string& word, const std::string& text) {
  std::vector<std::string> known{kAdaptive};
  for (const auto* names : {&kPatterns, &kFilters})
    for (const auto& [name, value] : *names) known.push_back(name);
  known.insert(known.end(), integrator_names().begin(), integrator_names().end());
  const auto& accelerators = available_accelerators();
  known.insert(known.end(), accelerators.begin(), accelerators.end());
  throw usage_error(fmt::format("'{}' in '{}'; expected words of {} with + between{}", word, text,
                                fmt::join(known, ", "), suggestion(word, known)));
}

}  // namespace

ErrorMethod parse_error_method(const std::string& text) {
  ErrorMethod out{text};
  const auto twice = [&text](bool is_set) {
    if (is_set)
      throw usage_error(fmt::format("'{}'; expected one word of each kind at most", text));
  };
  for (size_t start = 0; start <= text.size();) {
    const size_t end = std::min(text.find('+', start), text.size());
    const std::string word = text.substr(start, end - start);
    start = end + 1;
    if (const auto pattern = kPatterns.find(word); pattern != kPatterns.end()) {
      twice(out.pattern.has_value());
      out.pattern = pattern->second;
    } else if (const auto filter = kFilters.find(word); filter != kFilters.end()) {
      twice(out.filter.has_value());
      out.filter = filter->second;
    } else if (word == kAdaptive) {
      twice(out.is_adaptive);
      out.is_adaptive = true;
    } else if (is_among(word, integrator_names())) {
      twice(!out.integrator.empty());
      out.integrator = word;
    } else if (is_among(word, available_accelerators())) {
      twice(!out.accelerator.empty());
      out.accelerator = word;
    } else {
      fail_word(word, text);
    }
  }
  return out;
}

}  // namespace tessera
