#pragma once

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cstring>
#include <string>
#include <string_view>

#include "base/plural.h"
#include "scenes/formats/ply/ply_header.h"
#include "scenes/import/token_reader.h"

namespace tessera {

/// The values of a PLY file's rows as text. Programs write each row into a line of its own. Where
/// a file has as many lines as rows, a line that has a value too many or too few is that row's
/// trouble alone; in any other file values follow one another whatever the lines are.
class PlyText {
 public:
  PlyText(std::string_view bytes, const std::string& name, const PlyHeader& header)
      : in_(bytes, name, header.data_begin),
        lines_(count_lines()),
        rows_(header.row_count()),
        has_line_for_each_row_(lines_ == rows_) {}

  void begin_row() {
    if (has_line_for_each_row_) in_.enter_line();
  }
  void skip_row() { in_.skip_line(); }
  void end_row() {
    if (has_line_for_each_row_) in_.leave_line();
  }
  /// Whether the row's end is known without having read its values.
  bool has_row_ends() const { return has_line_for_each_row_; }
  /// Whether the row has values that were not read. Goes to the first.
  bool has_more_in_row() { return has_line_for_each_row_ && !in_.word().empty(); }
  /// NaN for what is no number, and for what is not in the row's line.
  double value(PlyType /*type*/) {
    const double value = in_.number();
    if (in_.is_past_end() && !has_line_for_each_row_)
      throw in_.error(in_.quoted_word(), "a number" + announced());
    return value;
  }
  void skip(PlyType type) { value(type); }
  /// How many more values the file can hold, or the row's line.
  uint64_t most_values(PlyType /*type*/) const { return (in_.remaining() + 1) / 2; }
  /// Whether anything is left that was not read after the last row.
  bool has_more() const { return !TokenReader(in_).word().empty(); }
  /// What may be wrong where the lines are not those that the header announces.
  std::string announced() const {
    if (has_line_for_each_row_) return "";
    return fmt::format("; the header announces {} rows than the {} that follow it",
                       rows_ > lines_ ? "more" : "fewer", counted(lines_, "line"));
  }
  /// What messages say of what was `found` in a row.
  std::string told(std::string_view /*row*/, std::string_view found) const {
    return std::string(found);
  }
  /// Of the value that was read last.
  SourcePlace place() const { return in_.place(); }
  std::string shown(double /*value*/) const { return in_.quoted_word(); }

 private:
  uint64_t count_lines() const {
    TokenReader in = in_;
    uint64_t count = 0;
    for (in.enter_line(); in.remaining() > 0; in.enter_line()) {
      in.leave_line();
      ++count;
    }
    return count;
  }

  TokenReader in_;
  uint64_t lines_, rows_;  ///< that follow the header, and that it announces
  bool has_line_for_each_row_;
};

/// The same in binary; `kSwap` where the file's order of bytes is not this machine's.
template <bool kSwap>
class PlyBinary {
 public:
  PlyBinary(std::string_view bytes, std::string name, size_t begin)
      : bytes_(bytes), name_(std::move(name)), at_(begin) {}

  void begin_row() {}
  void skip_row() {}
  void end_row() {}
  bool has_row_ends() const { return false; }
  bool has_more_in_row() const { return false; }
  double value(PlyType type) { return any_value(type); }
  void skip(PlyType type) { any_value(type); }
  uint64_t most_values(PlyType type) const { return (bytes_.size() - at_) / ply_size(type); }
  bool has_more() const { return at_ < bytes_.size(); }
  static std::string announced() { return ""; }
  std::string told(std::string_view row, std::string_view found) const {
    return fmt::format("{}{} (before byte {})", row, found, at_);
  }
  SourcePlace place() const { return {name_}; }
  std::string shown(double value) const { return fmt::format("{}", value); }

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
