#include "scenes/formats/x3d/document/x3d_values.h"

#include <fmt/format.h>

#include <algorithm>
#include <charconv>
#include <cmath>
#include <limits>

#include "base/plural.h"
#include "scenes/formats/x3d/document/x3d_number.h"

namespace tessera {
namespace {

bool is_separator(char c) { return c == ' ' || c == ',' || c == '\t' || c == '\n' || c == '\r'; }

std::string shown(std::string_view word) {
  constexpr size_t kLongest = 40;
  return word.size() > kLongest ? fmt::format("'{}...'", word.substr(0, kLongest))
                                : fmt::format("'{}'", word);
}

/// Calls action(word, offset in `text`) for each word between separators.
template <typename Action>
void for_each_word(std::string_view text, const Action& action) {
  for (size_t at = 0; at < text.size();) {
    if (is_separator(text[at])) {
      ++at;
      continue;
    }
    const size_t begin = at;
    while (at < text.size() && !is_separator(text[at])) ++at;
    action(text.substr(begin, at - begin), begin);
  }
}

/// What stands between the quotes of the string that begins at `at`, which is moved behind it. One
/// without an end goes to the end of the text.
std::string unquote(std::string_view text, size_t& at) {
  std::string out;
  for (++at; at < text.size() && text[at] != '"'; ++at) {
    if (text[at] == '\\' && at + 1 < text.size() && (text[at + 1] == '"' || text[at + 1] == '\\'))
      ++at;
    out += text[at];
  }
  ++at;
  return out;
}

}  // namespace

const X3dField* X3dValues::read_field(const X3dNode& node, std::string_view name) const {
  const X3dField* field = node.field(name);
  if (!field) return nullptr;
  spend(field->text.size(), field->offset);
  return field;
}

void X3dValues::spend(size_t bytes, size_t offset) const {
  read_bytes_ += bytes;
  if (read_bytes_ > kMaxReadBytes + kMaxReadTimes * document_.length())
    throw document_.error(offset, "lists that are used too often",
                          fmt::format("at most {} MiB, and {} times the file, read in all",
                                      kMaxReadBytes >> 20, kMaxReadTimes));
}

void X3dValues::tell_remarks() const {
  for (const X3dDocument::Remark& remark : document_.remarks())
    if (remark.taken.empty())
      warn(remark.offset, remark.text);
    else
      repair(remark.offset, remark.text, remark.expected, remark.taken);
}

void X3dValues::repair(const X3dNode& node, std::string_view name, std::string_view expected,
                       std::string_view taken) const {
  const X3dField& field = *node.field(name);
  repair(node, name, field.offset, shown(field.text), expected, taken);
}

void X3dValues::repair(const X3dNode& node, std::string_view name, size_t offset,
                       std::string_view found, std::string_view expected,
                       std::string_view taken) const {
  const auto where = [&] { return document_.place(offset); };
  warnings_.repair(found, expected, taken, where, fmt::format("{} of {}", name, node.type));
}

template <typename Number>
std::vector<Number> X3dValues::list(const X3dNode& node, std::string_view name, size_t width,
                                    std::string_view taken, bool clamps) const {
  std::vector<Number> values;
  const X3dField* field = read_field(node, name);
  if (!field) return values;
  for_each_word(field->text, [&](std::string_view word, size_t at) {
    Number value = 0;
    if (const char* const rule = read_x3d_number(word, value)) {
      if (!clamps) value = std::numeric_limits<Number>::quiet_NaN();
      repair(node, name, field->offset + at, shown(word), rule,
             std::isnan(value) ? taken : fmt::format("{:.6g} is taken", value));
    }
    values.push_back(value);
  });
  if (values.size() % width != 0) {
    repair(node, name, field->offset, counted(values.size(), "number"),
           fmt::format("a multiple of {}", width), "the last ones are left out");
    values.resize(values.size() / width * width);
  }
  return values;
}

template <typename Number>
std::vector<Number> X3dValues::finite_list(const X3dNode& node, std::string_view name,
                                           size_t width) const {
  std::vector<Number> values = list<Number>(node, name, width, "0 is taken", true);
  for (Number& value : values)
    if (std::isnan(value)) value = 0;
  return values;
}

bool X3dValues::boolean(const X3dNode& node, std::string_view name, bool otherwise) const {
  const X3dField* field = node.field(name);
  if (!field) return otherwise;
  std::string lower;
  for (const char c : field->text)
    if (!is_separator(c)) lower += static_cast<char>(c >= 'A' && c <= 'Z' ? c + 32 : c);
  if (lower != "true" && lower != "false") {
    repair(node, name, "true or false", fmt::format("{} is taken", otherwise));
    return otherwise;
  }
  if (lower != field->text && !document_.quotes_strings())
    warn(field->offset, fmt::format("{}='{}' is read as {}", name, field->text, lower));
  return lower == "true";
}

std::vector<double> X3dValues::exactly(const X3dNode& node, std::string_view name,
                                       size_t count) const {
  constexpr std::string_view kLeftOut = "the field is left out";
  std::vector<double> values = list<double>(node, name, 1, kLeftOut, true);
  const X3dField* field = node.field(name);
  if (field && values.size() != count)
    repair(node, name, field->offset, counted(values.size(), "number"), fmt::format("{}", count),
           values.size() < count ? kLeftOut
           : count == 1          ? "the first one is taken"
                                 : "the first ones are taken");
  values.resize(values.size() < count ? 0 : count);
  for (const double value : values)
    if (std::isnan(value)) return {};
  return values;
}

double X3dValues::number(const X3dNode& node, std::string_view name, double otherwise) const {
  const auto values = exactly(node, name, 1);
  return values.empty() ? otherwise : values[0];
}

double X3dValues::angle(const X3dNode& node, std::string_view name, double otherwise) const {
  const auto values = exactly(node, name, 1);
  return values.empty() ? otherwise : values[0] * document_.radians_per_unit();
}

std::vector<double> X3dValues::angles(const X3dNode& node, std::string_view name) const {
  std::vector<double> all = numbers(node, name, 1);
  for (double& angle : all) angle *= document_.radians_per_unit();
  return all;
}

double X3dValues::clamped(const X3dNode& node, std::string_view name, double value,
                          std::string_view expected, double most) const {
  const double inside = std::clamp(value, 0., most);
  if (inside != value) repair(node, name, expected, fmt::format("{:.6g} is taken", inside));
  return inside;
}

double X3dValues::clamped_angle(const X3dNode& node, std::string_view name, double angle,
                                std::string_view expected, double most) const {
  constexpr double kRounding = 1e-3;  // of pi written with few digits, as 3.142
  const bool is_rounded = angle > most && angle <= most * (1 + kRounding);
  return is_rounded ? most : clamped(node, name, angle, expected, most);
}

double X3dValues::amount(const X3dNode& node, std::string_view name, double otherwise) const {
  return clamped(node, name, number(node, name, otherwise));
}

double X3dValues::share(const X3dNode& node, std::string_view name, double otherwise) const {
  return clamped(node, name, number(node, name, otherwise), "0 to 1", 1);
}

int64_t X3dValues::integer(const X3dNode& node, std::string_view name, int64_t otherwise) const {
  constexpr std::string_view kLeftOut = "the field is left out";
  const Integers values = integers(node, name, kNoInteger, kLeftOut);
  const X3dField* field = node.field(name);
  if (!field) return otherwise;
  const size_t count = values.values.size();
  if (count != 1)
    repair(node, name, field->offset, counted(count, "number"), "1",
           count == 0 ? kLeftOut : "the first one is taken");
  return count == 0 || values.values[0] == kNoInteger ? otherwise : values.values[0];
}

Vec3 X3dValues::vec3(const X3dNode& node, std::string_view name, const Vec3& otherwise) const {
  const auto v = exactly(node, name, 3);
  return v.empty() ? otherwise : Vec3{v[0], v[1], v[2]};
}

Color X3dValues::clamped(const Color& color, const X3dNode& node, std::string_view name) const {
  const Color inside{std::clamp(color.r, 0., 1.), std::clamp(color.g, 0., 1.),
                     std::clamp(color.b, 0., 1.)};
  if (!(inside == color)) repair(node, name, "0 to 1", "the nearest colour is taken");
  return inside;
}

Color X3dValues::color(const X3dNode& node, std::string_view name, const Color& otherwise) const {
  const auto v = exactly(node, name, 3);
  return v.empty() ? otherwise : clamped({v[0], v[1], v[2]}, node, name);
}

std::vector<size_t> X3dValues::runs(const X3dNode& node, std::string_view name, size_t least,
                                    size_t points) const {
  const Integers counts = integers(node, name);
  std::vector<size_t> begins{0};
  for (size_t i = 0; i < counts.values.size(); ++i) {
    const size_t left = points - begins.back(),
                 given = static_cast<size_t>(std::max(counts.values[i], 0));
    if (given < least || given > left) {
      repair(counts.offsets[i],
             fmt::format("{} {} of {}, which has {} left", name, counts.values[i], describe(node),
                         counted(left, "point")),
             fmt::format("{} or more, and no more than are left", least),
             "the points there are taken");
    }
    begins.push_back(begins.back() + std::min(given, left));
  }
  return begins;
}

std::vector<Color> X3dValues::colors(const X3dNode& node, std::string_view name) const {
  const auto v = numbers(node, name, 3);
  std::vector<Color> out;
  for (size_t i = 0; i < v.size(); i += 3)
    out.push_back(clamped({v[i], v[i + 1], v[i + 2]}, node, name));
  return out;
}

X3dRotation X3dValues::rotation(const X3dNode& node, std::string_view name) const {
  const auto v = exactly(node, name, 4);
  if (v.empty()) return {};
  X3dRotation rotation{{v[0], v[1], v[2]}, v[3] * document_.radians_per_unit()};
  if (rotation.axis == Vec3{}) {
    if (rotation.angle != 0) repair(node, name, "an axis other than 0 0 0", "it is left out");
    return {};
  }
  return rotation;
}

std::string X3dValues::text(const X3dNode& node, std::string_view name) const {
  const X3dField* field = node.field(name);
  if (!field) return "";
  if (!document_.quotes_strings()) return std::string(field->text);
  const auto all = strings(node, name);
  return all.empty() ? "" : all[0];
}

std::vector<std::string> X3dValues::strings(const X3dNode& node, std::string_view name) const {
  std::vector<std::string> out;
  const X3dField* field = read_field(node, name);
  if (!field) return out;
  const std::string_view text = field->text;
  const size_t first = std::find_if_not(text.begin(), text.end(), is_separator) - text.begin();
  if (first == text.size()) return out;
  if (text[first] != '"') {
    if (document_.quotes_strings()) repair(node, name, "a string in quotes", "it is taken for one");
    return {std::string(text)};
  }
  for (size_t at = first; at < text.size();) {
    if (is_separator(text[at])) {
      ++at;
    } else if (text[at] == '"') {
      out.push_back(unquote(text, at));
    } else {
      repair(node, name, field->offset + at, shown(text.substr(at)), "a string in quotes",
             "what follows is left out");
      break;
    }
  }
  return out;
}

std::vector<double> X3dValues::numbers(const X3dNode& node, std::string_view name,
                                       size_t width) const {
  return finite_list<double>(node, name, width);
}

std::vector<float> X3dValues::floats(const X3dNode& node, std::string_view name,
                                     size_t width) const {
  return finite_list<float>(node, name, width);
}

std::vector<float> X3dValues::points(const X3dNode& node) const {
  return list<float>(node, "point", 3, "what is there is left out", false);
}

X3dValues::Integers X3dValues::integers(const X3dNode& node, std::string_view name, int32_t none,
                                        std::string_view taken) const {
  Integers out;
  const X3dField* field = read_field(node, name);
  if (!field) return out;
  for_each_word(field->text, [&](std::string_view word, size_t at) {
    const bool hex = word.starts_with("0x") || word.starts_with("0X");
    const char* begin = word.data() + (hex ? 2 : word.starts_with('+') ? 1 : 0);
    const char* end = word.data() + word.size();
    int64_t value = 0;
    const auto [stop, problem] = std::from_chars(begin, end, value, hex ? 16 : 10);
    if (stop != end || problem != std::errc() || value > std::numeric_limits<uint32_t>::max() ||
        value < std::numeric_limits<int32_t>::min()) {
      repair(node, name, field->offset + at, shown(word), "a 32-bit integer", taken);
      value = none;
    }
    out.values.push_back(static_cast<int32_t>(value));
    out.offsets.push_back(static_cast<uint32_t>(field->offset + at));
  });
  return out;
}

size_t X3dValues::choice(const X3dNode& node, std::string_view name, std::string_view given,
                         std::span<const std::string_view> choices) const {
  const auto at = std::find(choices.begin(), choices.end(), given);
  if (at != choices.end()) return static_cast<size_t>(at - choices.begin());
  if (!given.empty())
    repair(node, name, fmt::format("one of {}", fmt::join(choices, ", ")),
           fmt::format("{} is taken", choices[0]));
  return 0;
}

}  // namespace tessera
