#include <fmt/format.h>

#include <google/protobuf/descriptor.h>

#include <algorithm>
#include <map>

#include "base/error.h"
#include "base/lower_case.h"
#include "bench/error_bench.h"
#include "renderer/accel/make_accelerator.h"
#include "renderer/scene/read_settings.h"

namespace tessera {
namespace {

using Words = std::map<std::string, int>;

/// The values of an enumeration as words: OWEN_SOBOL is "owen-sobol".
Words words_of(const google::protobuf::EnumDescriptor& descriptor) {
  Words out;
  for (int i = 0; i < descriptor.value_count(); ++i) {
    std::string word = lower_case(descriptor.value(i)->name());
    std::replace(word.begin(), word.end(), '_', '-');
    out[word] = descriptor.value(i)->number();
  }
  return out;
}

const Words& patterns() {
  static const Words words = [] {
    Words out = words_of(*v1::Sampling::Pattern_descriptor());
    out.erase("pattern-default");
    out["owen"] = v1::Sampling::OWEN_SOBOL;  // for short
    return out;
  }();
  return words;
}

const Words& filters() {
  static const Words words = words_of(*v1::Sampling::Filter_descriptor());
  return words;
}

constexpr char kAdaptive[] = "adaptive";

bool is_among(const std::string& word, const std::vector<std::string>& names) {
  return std::find(names.begin(), names.end(), word) != names.end();
}

[[noreturn]] void fail_word(const std::string& word, const std::string& text) {
  std::vector<std::string> known{kAdaptive};
  for (const auto* names : {&patterns(), &filters()})
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
    if (const auto pattern = patterns().find(word); pattern != patterns().end()) {
      twice(out.pattern.has_value());
      out.pattern = pattern->second;
    } else if (const auto filter = filters().find(word); filter != filters().end()) {
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
