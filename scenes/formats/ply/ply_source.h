#pragma once

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cstring>
#include <string>
#include <string_view>

#include "scenes/formats/ply/ply_header.h"
#include "scenes/import/token_reader.h"

namespace tessera {

/// The values of a PLY file's rows as text.
class PlyText {
 public:
  PlyText(std::string_view bytes, const std::string& name, size_t begin)
      : in_(bytes, name, begin) {}

  /// NaN for what is no number.
  double value(PlyType /*type*/) {
    const double value = in_.number();
    if (in_.is_past_end()) throw in_.error(in_.quoted_word(), "a number");
    return value;
  }
  void skip(PlyType /*type*/) {
    if (in_.word().empty()) throw in_.error(in_.quoted_word(), "a number");
  }
  /// How many more values the file can hold.
  uint64_t most_values(PlyType /*type*/) const { return in_.remaining() / 2 + 1; }
  /// Whether anything is left that was not read.
  bool has_more() const { return !TokenReader(in_).word().empty(); }
  /// What messages say of what was `found` in a row.
  std::string told(std::string_view /*row*/, std::string_view found) const {
    return std::string(found);
  }
  /// Of the value that was read last.
  SourcePlace place() const { return in_.place(); }
  std::string shown(double /*value*/) const { return in_.quoted_word(); }

 private:
  TokenReader in_;
};

/// The same in binary; `kSwap` where the file's order of bytes is not this machine's.
template <bool kSwap>
class PlyBinary {
 public:
  PlyBinary(std::string_view bytes, std::string name, size_t begin)
      : bytes_(bytes), name_(std::move(name)), at_(begin) {}

  double value(PlyType type) { return any_value(type); }
  void skip(PlyType type) { any_value(type); }
  uint64_t most_values(PlyType type) const { return (bytes_.size() - at_) / ply_size(type); }
  bool has_more() const { return at_ < bytes_.size(); }
  std::string told(std::string_view row, std::string_view found) const {
    return fmt::format("{}{} (before byte {})", row, found, at_);
  }
  SourcePlace place() const { return {name_}; }
  std::string shown(double value) const { return fmt::format("{} (before byte {})", value, at_); }

 private:
  template <typename Number>
  double take() {
    std::array<char, sizeof(Number)> raw;
    if (bytes_.size() - at_ < raw.size())
      throw scene_error(place(), told("", "the file ends here"),
                        "the data that its header announces");
    std::memcpy(raw.data(), bytes_.data() + at_, raw.size());
    at_ += raw.size();
    if constexpr (kSwap) std::reverse(raw.begin(), raw.end());
    Number number;
    std::memcpy(&number, raw.data(), raw.size());
    return static_cast<double>(number);
  }

  double any_value(PlyType type) {
    switch (type) {
      case PlyType::int8:
        return take<int8_t>();
      case PlyType::uint8:
        return take<uint8_t>();
      case PlyType::int16:
        return take<int16_t>();
      case PlyType::uint16:
        return take<uint16_t>();
      case PlyType::int32:
        return take<int32_t>();
      case PlyType::uint32:
        return take<uint32_t>();
      case PlyType::float32:
        return take<float>();
      case PlyType::float64:
        break;
    }
    return take<double>();
  }

  std::string_view bytes_;
  std::string name_;
  size_t at_;
};

}  // namespace tessera
