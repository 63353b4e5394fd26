#include "scenes/formats/obj/line_reader.h"

#include <fmt/format.h>

#include <algorithm>
#include <cerrno>
#include <cmath>
#include <cstring>
#include <limits>
#include <utility>

#include "base/file.h"
#include "base/input_scope.h"
#include "base/plain_text.h"
#include "scenes/import/decimal.h"

namespace tessera {
namespace {

constexpr size_t kPiece = size_t{1} << 20;
constexpr size_t kLongestLine = size_t{64} << 20;

/// The number of lines that end in [begin, end); CRLF ends one.
int64_t count_lines(const char* begin, const char* end) {
  int64_t lines = std::count(begin, end, '\n');
  for (const char* at = begin; (at = static_cast<const char*>(std::memchr(at, '\r', end - at)));
       ++at)
    if (at + 1 == end || at[1] != '\n') ++lines;
  return lines;
}

/// Behind the last line end of a piece that joins nothing; 0: there is none. CR as its last
/// character may be the half of a CRLF.
size_t last_line_end(std::string_view piece) {
  for (size_t cut = piece.size(); cut > 0;) {
    const size_t end = piece.find_last_of("\n\r", cut - 1);
    if (end == std::string_view::npos) break;
    const bool is_half = piece[end] == '\r' && end + 1 == piece.size();
    const bool is_crlf = piece[end] == '\n' && end > 0 && piece[end - 1] == '\r';
    const size_t before = is_crlf ? end - 1 : end;
    const bool joins = before > 0 && piece[before - 1] == '\\';
    if (!is_half && !joins) return end + 1;
    cut = before;
  }
  return 0;
}

}  // namespace

int LineReader::joint(const char* at) {
  if (*at != '\\' || !is_line_end(at[1])) return 0;
  return at[1] == '\r' && at[2] == '\n' ? 3 : 2;
}

LineReader::LineReader(const std::string& path) : name_(path) {
  check_input_file(path, uint64_t{1} << 40);
  if (const auto text = InputScope::text_of(path)) {
    pending_ = *text;
    return;
  }
  file_ = open_input_file(path);
  if (!file_) throw scene_error(fmt::format("{}: {}", path, std::strerror(errno)));
}

LineReader::LineReader(std::string_view text, std::string name)
    : name_(std::move(name)), pending_(text) {}

bool LineReader::refill() {
  lines_before_ += count_lines(buffer_.data(), buffer_.data() + buffer_.size());
  buffer_ = std::move(pending_);
  pending_.clear();
  bool ended = !file_;
  size_t cut = 0;
  while (!ended && cut == 0) {
    const size_t had = buffer_.size();
    if (had > kLongestLine)
      throw scene_error({name_, static_cast<int>(lines_before_) + 1}, "a line over 64 MiB long",
                        "a text file");
    buffer_.resize(had + kPiece);
    const size_t got = std::fread(buffer_.data() + had, 1, kPiece, file_.get());
    if (std::ferror(file_.get()))
      throw scene_error(fmt::format("{}: {}", name_, std::strerror(errno)));
    buffer_.resize(had + got);
    ended = got < kPiece;
    cut = last_line_end(buffer_);
  }
  if (ended) {
    file_.reset();
    // Two, since a backslash before the end would join the first.
    if (!buffer_.empty()) buffer_ += "\n\n";
    cut = buffer_.size();
  }
  pending_.assign(buffer_, cut);
  buffer_.resize(cut);
  if (std::exchange(at_start_, false)) {
    refuse_wide_text(buffer_, name_);
    buffer_.erase(0, cut - skip_byte_order_mark(buffer_).size());
  }
  at_ = word_ = buffer_.data();
  end_ = buffer_.data() + buffer_.size();
  return at_ != end_;
}

bool LineReader::next_line() {
  if (in_line_) {
    while (!is_line_end(*at_)) at_ += std::max(1, joint(at_));
    at_ += at_[0] == '\r' && at_[1] == '\n' ? 2 : 1;
  }
  in_line_ = at_ != end_ || refill();
  word_ = at_;
  return in_line_;
}

void LineReader::skip_joints() {
  while (const int length = joint(at_)) {
    at_ += length;
    while (is_blank(*at_)) ++at_;
  }
}

std::string_view LineReader::word() {
  skip_space();
  word_ = at_;
  while (!at_word_end()) ++at_;
  return {word_, static_cast<size_t>(at_ - word_)};
}

std::string LineReader::rest() {
  skip_space();
  word_ = at_;
  while (!is_line_end(*at_) && joint(at_) == 0) ++at_;
  const char* last = at_;
  while (last > word_ && is_blank(last[-1])) --last;
  return std::string(word_, last);
}

float LineReader::number(const char* what) {
  const float value = any_number();
  if (!std::isfinite(value)) throw error(quoted_word(), rule(what, value));
  return value;
}

std::string LineReader::rule(const char* what, float value) const {
  if (!is_number_) return what;
  return fmt::format("{} that {}", what,
                     std::isnan(value) ? "is finite" : "single precision can hold");
}

float LineReader::any_number() {
  constexpr float kEndless = std::numeric_limits<float>::infinity();
  skip_space();
  word_ = at_;
  float value = 0;
  const auto [stop, problem] = read_decimal(at_, end_, value);
  if (problem != std::errc::invalid_argument) at_ = stop;
  is_number_ = problem != std::errc::invalid_argument && at_word_end();
  if (!is_number_) {
    while (!at_word_end()) ++at_;
    return std::numeric_limits<float>::quiet_NaN();
  }
  if (problem == std::errc::result_out_of_range) return kEndless;
  return std::isfinite(value) ? value : std::numeric_limits<float>::quiet_NaN();
}

std::optional<float> LineReader::optional_number(const char* what) {
  if (at_line_end() || *at_ == '#') return std::nullopt;
  return number(what);
}

std::optional<int64_t> LineReader::index() {
  const char* at = at_;
  const bool negative = *at == '-';
  if (negative) ++at;
  uint64_t number = 0;
  const char* const begin = at;
  while (*at == '0') ++at;
  const char* const first = at;
  for (; *at >= '0' && *at <= '9'; ++at) number = number * 10 + static_cast<uint64_t>(*at - '0');
  at_ = at;
  if (at == begin) return std::nullopt;
  // More digits than any index has may have gone round.
  constexpr ptrdiff_t kMostDigits = 12;
  const int64_t value = at - first > kMostDigits ? kTooLarge : static_cast<int64_t>(number);
  return negative ? -value : value;
}

std::string LineReader::quoted_word() const {
  constexpr size_t kLongestShown = 40;
  const char* stop = word_;
  while (stop < end_ && !is_blank(*stop) && !is_line_end(*stop)) ++stop;
  const std::string text = to_utf8({word_, static_cast<size_t>(stop - word_)});
  if (text.empty()) return "the line ends here";
  return text.size() > kLongestShown
             ? fmt::format("'{}...'", to_utf8(text.substr(0, kLongestShown)))
             : fmt::format("'{}'", text);
}

SourcePlace LineReader::place_of(const char* at) const {
  const char* begin = buffer_.data();
  const char* line = at;
  while (line > begin && !is_line_end(line[-1])) --line;
  return {name_, static_cast<int>(lines_before_ + count_lines(begin, line)) + 1,
          static_cast<int>(at - line) + 1};
}

Error LineReader::error(std::string_view found, std::string_view expected) const {
  return scene_error(place(), found, expected);
}

}  // namespace tessera
