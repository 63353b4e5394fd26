#include "scenes/import/token_reader.h"

#include <fmt/format.h>

#include <algorithm>
#include <limits>

#include "base/file.h"
#include "scenes/import/decimal.h"

namespace tessera {
namespace {

bool is_line_end(char c) { return c == '\n' || c == '\r'; }
bool is_space(char c) { return c == ' ' || c == '\t' || c == '\v' || c == '\f' || is_line_end(c); }

}  // namespace

std::string_view TokenReader::word() {
  while (at_ < end_ && is_space(text_[at_])) ++at_;
  word_ = at_;
  while (at_ < end_ && !is_space(text_[at_])) ++at_;
  return text_.substr(word_, at_ - word_);
}

std::string_view TokenReader::rest_of_line() {
  while (at_ < text_.size() && is_space(text_[at_]) && !is_line_end(text_[at_])) ++at_;
  word_ = at_;
  while (at_ < text_.size() && !is_line_end(text_[at_])) ++at_;
  size_t last = at_;
  while (last > word_ && is_space(text_[last - 1])) --last;
  const std::string_view rest = text_.substr(word_, last - word_);
  if (text_.substr(at_).starts_with("\r\n")) ++at_;
  if (at_ < text_.size()) ++at_;
  return rest;
}

void TokenReader::enter_line() {
  while (at_ < text_.size() && is_space(text_[at_])) ++at_;
  end_ = at_;
  while (end_ < text_.size() && !is_line_end(text_[end_])) ++end_;
}

void TokenReader::leave_line() {
  at_ = end_;
  end_ = text_.size();
}

double TokenReader::number() {
  const std::string_view text = word();
  double value = 0;
  const auto [stop, problem] = read_decimal(text.data(), text.data() + text.size(), value);
  const bool is_number =
      problem != std::errc::invalid_argument && stop == text.data() + text.size();
  if (!is_number) return std::numeric_limits<double>::quiet_NaN();
  return problem == std::errc::result_out_of_range ? std::numeric_limits<double>::infinity()
                                                   : value;
}

SourcePlace TokenReader::place() const {
  int line = 1;
  size_t begin = 0;
  for (size_t i = 0; i < word_; ++i) {
    if (!is_line_end(text_[i])) continue;
    if (text_[i] == '\r' && i + 1 < word_ && text_[i + 1] == '\n') ++i;
    ++line;
    begin = i + 1;
  }
  return {name_, line, static_cast<int>(word_ - begin) + 1};
}

std::string TokenReader::quoted_word() const {
  constexpr size_t kLongestShown = 40;
  size_t stop = word_;
  while (stop < text_.size() && !is_space(text_[stop])) ++stop;
  if (stop == word_) return word_ == text_.size() ? "the file ends here" : "the line ends here";
  const std::string_view word = text_.substr(word_, std::min(stop - word_, kLongestShown));
  return fmt::format("'{}{}'", to_utf8(word), stop - word_ > kLongestShown ? "..." : "");
}

}  // namespace tessera
