#include "bench/studio/script.h"

#include <algorithm>
#include <regex>

namespace tessera {

namespace {

using Json = nlohmann::json;

}  // namespace

PageClient::Condition of_version(uint64_t version) {
  return [version](const Json& fields) { return fields.value("version", uint64_t{0}) == version; };
}

Script::Script(PageClient& page, std::string file) : page_(page), file_(std::move(file)) {
  page_.say("open", {{"file", file_}});
  const Json document =
      page_.receive({"document"}, [&](const Json& each) { return each["file"] == file_; });
  text_ = document["text"];
  version_ = document["version"];
}

bool Script::find_place(const std::string& shown) {
  constexpr size_t kApart = 20;
  static const std::regex kFraction(R"([^\w.#](\d*\.\d+))");
  size_t last = 0;
  for (std::sregex_iterator found(text_.begin(), text_.end(), kFraction), end; found != end;
       ++found) {
    const auto at = static_cast<size_t>(found->position(1) + found->length(1));
    if (last != 0 && at - last < kApart) continue;
    last = at;
    if (is_shown(at, shown)) return true;
  }
  return false;
}

void Script::take_place(std::string_view words) {
  place_ = text_.find(words) + words.size();
  has_digit_ = false;
}

void Script::type(int number) {
  const std::string digit(1, static_cast<char>('1' + number % 8));
  page_.say("edit", {{"file", file_},
                     {"base", version_},
                     {"changes", {{place_, place_ + (has_digit_ ? 1 : 0), digit}}}});
  has_digit_ = true;
  ++version_;
}

bool Script::is_shown(size_t place, const std::string& shown) {
  page_.forget();
  place_ = place;
  has_digit_ = false;
  type(2);
  const Json problems = page_.receive({"problems"}, of_version(version_));
  const bool is_wrong = std::any_of(problems["list"].begin(), problems["list"].end(),
                                    [](const Json& each) { return each["severity"] == "error"; });
  if (!is_wrong && page_.receive({"summary"}, of_version(version_))["digest"] != shown) {
    page_.receive({"pixels"}, of_version(version_));
    return true;
  }
  page_.say("edit", {{"file", file_}, {"base", version_}, {"changes", {{place, place + 1, ""}}}});
  ++version_;
  return false;
}

}  // namespace tessera
