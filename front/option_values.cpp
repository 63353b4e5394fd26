#include "front/option_values.h"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <charconv>
#include <cmath>
#include <utility>
#include <vector>

#include "base/choice.h"
#include "base/error.h"

namespace tessera {
namespace {

constexpr int kMaxFrameNumber = 999'999'999;

Error bad_value(std::string_view option, std::string_view text, std::string_view expected) {
  return usage_error(fmt::format("{}: '{}'; expected {}", option, text, expected));
}

template <typename Number>
std::optional<Number> whole_text_as(std::string_view text) {
  Number value{};
  const auto [end, error] = std::from_chars(text.data(), text.data() + text.size(), value);
  if (error != std::errc() || end != text.data() + text.size()) return std::nullopt;
  return value;
}

/// The numbers between separators; nothing where one of them is no number.
std::optional<std::vector<int>> split_numbers(std::string_view text, char separator) {
  std::vector<int> numbers;
  for (;;) {
    const size_t end = text.find(separator);
    const auto number = whole_text_as<int>(text.substr(0, end));
    if (!number) return std::nullopt;
    numbers.push_back(*number);
    if (end == std::string_view::npos) return numbers;
    text.remove_prefix(end + 1);
  }
}

/// Every `step`-th of the frames from `first` to `last`.
struct SteppedRange {
  int64_t first = 0, last = 0, step = 1;

  int64_t count() const { return (last - first) / step + 1; }
};

/// "FIRST", "FIRST-LAST" or "FIRST-LASTxSTEP", ".." being another "-"; nothing where it is neither.
std::optional<SteppedRange> stepped_range(std::string_view text) {
  while (text.starts_with(' ')) text.remove_prefix(1);
  while (text.ends_with(' ')) text.remove_suffix(1);
  constexpr std::string_view kDigits = "0123456789";
  const std::string_view first = text.substr(0, text.find_first_not_of(kDigits));
  std::string_view rest = text.substr(first.size()), last = first, step = "1";
  if (!rest.empty()) {
    if (!rest.starts_with("-") && !rest.starts_with("..")) return std::nullopt;
    rest.remove_prefix(rest.front() == '-' ? 1 : 2);
    last = rest.substr(0, rest.find('x'));
    if (last.starts_with('-')) return std::nullopt;
    if (last.size() < rest.size()) step = rest.substr(last.size() + 1);
  }
  const auto from = whole_text_as<int>(first), to = whole_text_as<int>(last);
  const auto by = whole_text_as<int>(step);
  if (!from || !to || !by || *from > *to || *to > kMaxFrameNumber || *by < 1) return std::nullopt;
  return SteppedRange{*from, *to, *by};
}

void check_frame_size(std::string_view what, int64_t width, int64_t height) {
  const bool sides_fit =
      width >= 1 && height >= 1 && width <= kMaxFrameSide && height <= kMaxFrameSide;
  if (!sides_fit || width * height > kMaxFramePixels) {
    throw usage_error(
        fmt::format("{}: {}x{}; expected sides from 1 to {} and at most {} pixels in all", what,
                    width, height, kMaxFrameSide, kMaxFramePixels));
  }
}

}  // namespace

int64_t parse_whole(std::string_view option, std::string_view text, int64_t least, int64_t most) {
  const auto value = whole_text_as<int64_t>(text);
  if (!value || *value < least || *value > most) {
    throw bad_value(option, text, fmt::format("a whole number from {} to {}", least, most));
  }
  return *value;
}

uint64_t parse_bytes(std::string_view option, std::string_view text) {
  constexpr std::string_view kUnits = "KMGT";
  const size_t unit = text.empty() ? std::string_view::npos : kUnits.find(text.back());
  const bool has_unit = unit != std::string_view::npos;
  const auto value = whole_text_as<uint64_t>(text.substr(0, text.size() - (has_unit ? 1 : 0)));
  const unsigned shift = has_unit ? 10 * (static_cast<unsigned>(unit) + 1) : 0;
  if (!value || *value == 0 || *value > (uint64_t{1} << 62 >> shift)) {
    throw bad_value(option, text, "a number of bytes such as 500M or 10G");
  }
  return *value << shift;
}

std::chrono::seconds parse_duration(std::string_view option, std::string_view text) {
  constexpr std::string_view kUnits = "smhd";
  constexpr int64_t kSeconds[] = {1, 60, 3600, 86400}, kMost = 3650 * kSeconds[3];
  const size_t unit = text.empty() ? std::string_view::npos : kUnits.find(text.back());
  const auto value = whole_text_as<int64_t>(text.substr(0, text.empty() ? 0 : text.size() - 1));
  if (unit == std::string_view::npos || !value || *value < 1 || *value > kMost / kSeconds[unit]) {
    throw bad_value(option, text, "a duration such as 90m, 24h or 7d, at most 3650d");
  }
  return std::chrono::seconds(*value * kSeconds[unit]);
}

double parse_share(std::string_view option, std::string_view text) {
  const bool percent = text.ends_with('%');
  const auto value = whole_text_as<double>(text.substr(0, text.size() - (percent ? 1 : 0)));
  const double share = value.value_or(-1) / (percent ? 100 : 1);
  if (!(share >= 0 && share <= 1)) throw bad_value(option, text, "a share such as 1% or 0.01");
  return share;
}

double parse_number(std::string_view option, std::string_view text) {
  const auto value = whole_text_as<double>(text);
  if (!value || !std::isfinite(*value)) throw bad_value(option, text, "a finite number");
  return *value;
}

FrameSize parse_size(std::string_view option, std::string_view text) {
  const auto sides = split_numbers(text, 'x');
  if (!sides || sides->size() != 2) {
    throw bad_value(
        option, text,
        fmt::format("WIDTHxHEIGHT, whole numbers from 1 to {}, such as 1920x1080", kMaxFrameSide));
  }
  check_frame_size(option, (*sides)[0], (*sides)[1]);
  return {(*sides)[0], (*sides)[1]};
}

PixelRect parse_crop(std::string_view option, std::string_view text) {
  const auto corners = split_numbers(text, ',');
  if (corners && corners->size() == 4) {
    const PixelRect rect{(*corners)[0], (*corners)[1], (*corners)[2], (*corners)[3]};
    if (rect.x0 >= 0 && rect.y0 >= 0 && rect.x0 < rect.x1 && rect.y0 < rect.y1) return rect;
  }
  throw bad_value(option, text,
                  "X0,Y0,X1,Y1 with 0 <= X0 < X1 and 0 <= Y0 < Y1, such as 0,0,64,64");
}

FrameNumbers parse_frames(std::string_view option, std::string_view text) {
  std::vector<SteppedRange> ranges;
  int64_t count = 0;
  for (std::string_view rest = text;;) {
    const size_t end = rest.find(',');
    const auto range = stepped_range(rest.substr(0, end));
    if (!range) {
      throw bad_value(option, text,
                      "FIRST-LAST with 0 <= FIRST <= LAST <= 999999999, such as 0-23, or several "
                      "such as 1,5,10-20 or 1-100x5");
    }
    ranges.push_back(*range);
    count += range->count();
    if (end == std::string_view::npos) break;
    rest.remove_prefix(end + 1);
  }
  if (count > kMostFrames) {
    throw usage_error(
        fmt::format("{}: '{}' asks for {} frames; expected at most {}, for a job of a farm {}",
                    option, text, count, kMostFrames, kMostJobFrames));
  }
  FrameNumbers frames;
  for (const SteppedRange& range : ranges) {
    for (int64_t i = 0; i < range.count(); ++i) {
      frames.push_back(static_cast<int>(range.first + i * range.step));
    }
  }
  std::sort(frames.begin(), frames.end());
  frames.erase(std::unique(frames.begin(), frames.end()), frames.end());
  return frames;
}

std::string parse_choice(std::string_view option, const std::string& text,
                         std::span<const std::string> names) {
  if (const auto name = find_choice(names, text)) return *name;
  throw usage_error(fmt::format("{}: '{}'; expected one of {}{}", option, text,
                                fmt::join(names, ", "), suggestion(text, names)));
}

AovSet parse_aovs(std::string_view option, const std::string& text) {
  if (text == "all") return AovSet::all();
  const std::vector<std::string>& names = aov_names();
  AovSet aovs;
  for (size_t at = 0; at <= text.size();) {
    const size_t end = std::min(text.find(',', at), text.size());
    at = std::min(text.find_first_not_of(' ', at), end);
    const std::string name = parse_choice(option, text.substr(at, end - at), names);
    aovs = aovs.with(static_cast<Aov>(std::find(names.begin(), names.end(), name) - names.begin()));
    at = end + 1;
  }
  return aovs;
}

}  // namespace tessera
