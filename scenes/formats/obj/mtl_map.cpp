#include "scenes/formats/obj/mtl_map.h"

#include <fmt/format.h>

#include <cmath>
#include <string_view>
#include <vector>

#include "base/file.h"
#include "scenes/import/decimal.h"

namespace tessera {
namespace {

using namespace std::string_view_literals;

std::optional<double> as_number(std::string_view word) {
  float value = 0;
  const auto [stop, problem] = read_decimal(word.data(), word.data() + word.size(), value);
  if (problem != std::errc() || stop != word.data() + word.size() || !std::isfinite(value))
    return std::nullopt;
  return value;
}

/// The options of one map statement. Names of files may hold spaces, so that the last word that can
/// belong to an option has to be found before the name begins.
class MapLine {
 public:
  MapLine(LineReader& in, const std::string& keyword, Warnings& warnings)
      : keyword_(keyword), warnings_(warnings), text_(in.rest()), place_(in.place()) {}

  MtlMap read() {
    skip_space();
    while (text_.substr(at_).starts_with('-') && option(word())) skip_space();
    map_.file = to_utf8(text_.substr(at_));
    if (map_.file.size() > 2 && map_.file.front() == '"' && map_.file.back() == '"')
      map_.file = map_.file.substr(1, map_.file.size() - 2);
    if (map_.file.empty()) throw error(fmt::format("{} without a file", keyword_), "a picture");
    for (char& c : map_.file)
      if (c == '\\') c = '/';
    return std::move(map_);
  }

 private:
  /// False where what looks like an option is the beginning of the file's name.
  bool option(std::string_view name) {
    if (name == "-s") return numbers(map_.scale, 1);
    if (name == "-o") return numbers(map_.offset, 0);
    if (name == "-bm") return map_.multiplier = number(), true;
    if (name == "-clamp") return map_.clamp = on_or_off(), true;
    if (name == "-imfchan") return channel();
    if (name == "-colorspace") return color_space();
    if (name == "-mm") return range();
    if (name == "-blendu" || name == "-blendv" || name == "-cc") {
      if (on_or_off() == (name == "-cc")) ignore(name);
      return true;
    }
    if (name == "-boost" || name == "-texres") return number(), ignore(name), true;
    if (name == "-type") return word(), ignore(name), true;
    if (name == "-t") {
      std::array<double, 3> turbulence{};
      return numbers(turbulence, 0), ignore(name), true;
    }
    at_ = word_;
    return false;
  }

  void ignore(std::string_view name) {
    warnings_.add(fmt::format("option {} of {} is not read", name, keyword_));
  }

  bool numbers(std::array<double, 3>& values, double rest) {
    values = {number(), rest, rest};
    for (size_t i = 1; i < values.size(); ++i) {
      const size_t before = at_;
      const auto value = as_number(word());
      if (!value || at_end()) return at_ = before, true;  // the last word is the file
      values[i] = *value;
    }
    return true;
  }

  bool range() {
    const double base = number();
    map_.gain = number();
    if (std::abs(base) > kMtlRounding || map_.gain < 0) ignore("-mm with a base"), map_.gain = 1;
    return true;
  }

  bool channel() {
    constexpr std::array kNames{"r"sv, "g"sv, "b"sv, "m"sv, "l"sv, "z"sv};
    const std::string_view name = word();
    for (size_t i = 0; i < kNames.size(); ++i) {
      if (name != kNames[i]) continue;
      map_.luminance = i >= 4;
      map_.channel.reset();
      if (i < 4) map_.channel = static_cast<v1::FloatInput::Channel>(i);
      if (name == "z")
        warnings_.add(
            fmt::format("{} -imfchan z asks for depths, which no picture holds; luminance is taken",
                        keyword_),
            [&] { return place_; });
      return true;
    }
    throw error(fmt::format("'{}'", to_utf8(name)), "a channel: r, g, b, m, l or z");
  }

  bool color_space() {
    const std::string_view name = word();
    if (name == "sRGB" || name == "srgb")
      map_.encoding = v1::Texture::Image::ENCODING_SRGB;
    else if (name == "linear")
      map_.encoding = v1::Texture::Image::ENCODING_LINEAR;
    else
      throw error(fmt::format("'{}'", to_utf8(name)), "a colour space: sRGB or linear");
    return true;
  }

  bool on_or_off() {
    const std::string_view value = word();
    if (value != "on" && value != "off")
      throw error(fmt::format("'{}'", to_utf8(value)), "on or off");
    return value == "on";
  }

  double number() {
    const std::string_view text = word();
    const auto value = as_number(text);
    if (!value) throw error(fmt::format("'{}'", to_utf8(text)), "a finite number");
    return *value;
  }

  static bool is_space(char c) { return c == ' ' || c == '\t' || c == '\v' || c == '\f'; }
  void skip_space() {
    while (at_ < text_.size() && is_space(text_[at_])) ++at_;
  }
  bool at_end() {
    skip_space();
    return at_ == text_.size();
  }
  std::string_view word() {
    skip_space();
    word_ = at_;
    while (at_ < text_.size() && !is_space(text_[at_])) ++at_;
    return std::string_view(text_).substr(word_, at_ - word_);
  }

  Error error(std::string_view found, std::string_view expected) const {
    SourcePlace place = place_;
    place.column += static_cast<int>(word_);
    return scene_error(place, found, expected);
  }

  const std::string& keyword_;
  Warnings& warnings_;
  std::string text_;
  SourcePlace place_;
  size_t at_ = 0, word_ = 0;
  MtlMap map_;
};

}  // namespace

MtlMap read_mtl_map(LineReader& reader, const std::string& keyword, Warnings& warnings) {
  return MapLine(reader, keyword, warnings).read();
}

}  // namespace tessera
