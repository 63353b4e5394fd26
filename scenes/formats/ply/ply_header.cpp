#include "scenes/formats/ply/ply_header.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <charconv>
#include <utility>

#include "base/file.h"
#include "scenes/import/token_reader.h"

namespace tessera {
namespace {

constexpr std::array<std::pair<std::string_view, PlyType>, 16> kTypes{
    {{"char", PlyType::int8},
     {"int8", PlyType::int8},
     {"uchar", PlyType::uint8},
     {"uint8", PlyType::uint8},
     {"short", PlyType::int16},
     {"int16", PlyType::int16},
     {"ushort", PlyType::uint16},
     {"uint16", PlyType::uint16},
     {"int", PlyType::int32},
     {"int32", PlyType::int32},
     {"uint", PlyType::uint32},
     {"uint32", PlyType::uint32},
     {"float", PlyType::float32},
     {"float32", PlyType::float32},
     {"double", PlyType::float64},
     {"float64", PlyType::float64}}};

class HeaderReader {
 public:
  HeaderReader(std::string_view bytes, const std::string& name, Warnings& warnings)
      : in_(bytes, name), warnings_(warnings) {}

  PlyHeader read() {
    if (in_.word() != "ply") throw in_.error(in_.quoted_word(), "'ply', as PLY files begin");
    in_.rest_of_line();
    for (;;) {
      const std::string keyword(in_.word());
      if (keyword == "end_header") break;
      statement(keyword);
      in_.rest_of_line();
    }
    in_.rest_of_line();
    if (!has_format_) throw in_.error("no format", "a line 'format ascii 1.0' or its like");
    header_.data_begin = in_.offset();
    check_counts();
    return std::move(header_);
  }

 private:
  void statement(const std::string& keyword) {
    constexpr const char* kKeywords = "format, element, property, comment or end_header";
    if (keyword == "format")
      format();
    else if (keyword == "element")
      element();
    else if (keyword == "property")
      property();
    else if (keyword == "comment")
      comment();
    else if (in_.is_past_end())
      throw in_.error(in_.quoted_word(), kKeywords);
    else if (is_like_property())
      repair(kKeywords, "it is taken for 'property'"), property();
    else if (keyword != "obj_info")
      repair(kKeywords, "the line is left out");
  }

  /// Whether what follows the keyword is what follows 'property': its numbers are in the data.
  bool is_like_property() const {
    TokenReader line = in_;
    const std::string_view word = line.word();
    return word == "list" || std::any_of(kTypes.begin(), kTypes.end(),
                                         [&](const auto& known) { return word == known.first; });
  }

  void repair(const char* expected, const char* taken) {
    warnings_.repair(in_.quoted_word(), expected, taken, [&] { return in_.place(); });
  }

  void comment() {
    TokenReader line = in_;  // the caller goes to the next line
    if (std::string_view words = line.rest_of_line(); words.starts_with("TextureFile "))
      header_.texture_file = to_utf8(words.substr(words.find(' ') + 1)),
      header_.texture_place = in_.place();
  }

  void format() {
    const std::string_view encoding = in_.word();
    if (encoding == "ascii")
      header_.encoding = PlyHeader::Encoding::ascii;
    else if (encoding == "binary_little_endian")
      header_.encoding = PlyHeader::Encoding::little_endian;
    else if (encoding == "binary_big_endian")
      header_.encoding = PlyHeader::Encoding::big_endian;
    else
      throw in_.error(in_.quoted_word(), "ascii, binary_little_endian or binary_big_endian");
    if (in_.word() != "1.0") repair("version 1.0", "it is read as that");
    has_format_ = true;
  }

  void element() {
    constexpr size_t kMostElements = 1000;
    if (header_.elements.size() == kMostElements)
      throw in_.error("too many elements", fmt::format("at most {}", kMostElements));
    PlyElement element{.name = to_utf8(in_.word()), .count = 0, .properties = {}};
    const std::string_view count = in_.word();
    const auto [stop, problem] =
        std::from_chars(count.data(), count.data() + count.size(), element.count);
    if (problem != std::errc() || stop != count.data() + count.size())
      throw in_.error(in_.quoted_word(), fmt::format("the number of '{}'", element.name));
    header_.elements.push_back(std::move(element));
  }

  PlyType type() {
    const std::string_view name = in_.word();
    for (const auto& [known, type] : kTypes)
      if (name == known) return type;
    throw in_.error(in_.quoted_word(),
                    "a type: char, uchar, short, ushort, int, uint, float, double");
  }

  void property() {
    constexpr size_t kMostProperties = 1000;
    if (header_.elements.empty()) throw in_.error("a property", "an element before it");
    PlyElement& element = header_.elements.back();
    if (element.properties.size() == kMostProperties)
      throw in_.error("too many properties", fmt::format("at most {}", kMostProperties));
    PlyProperty property;
    const TokenReader before = in_;
    if (in_.word() == "list") {
      property.count_type = type();
      if (*property.count_type >= PlyType::float32)
        repair("a type of whole numbers", "it is taken all the same");
    } else {
      in_ = before;
    }
    property.type = type();
    property.name = to_utf8(in_.word());
    if (property.name.empty()) throw in_.error(in_.quoted_word(), "the property's name");
    element.properties.push_back(std::move(property));
  }

  /// More of anything than the rest of the file can hold is a lie; nothing is allocated for it. One
  /// more is kept, with which the file ends too early for who reads it.
  void check_counts() {
    for (PlyElement& element : header_.elements) {
      uint64_t least = 0;
      for (const PlyProperty& property : element.properties)
        least += header_.encoding == PlyHeader::Encoding::ascii
                     ? 2
                     : ply_size(property.count_type.value_or(property.type));
      // The last number of a text needs no space behind it.
      if (least > 0) element.count = std::min(element.count, (in_.remaining() + 1) / least + 1);
    }
  }

  TokenReader in_;
  Warnings& warnings_;
  PlyHeader header_;
  bool has_format_ = false;
};

}  // namespace

uint64_t PlyHeader::row_count() const {
  uint64_t count = 0;
  for (const PlyElement& element : elements)
    if (!element.properties.empty()) count += element.count;
  return count;
}

size_t ply_size(PlyType type) {
  constexpr std::array<size_t, 8> kSizes{1, 1, 2, 2, 4, 4, 4, 8};
  return kSizes[static_cast<size_t>(type)];
}

PlyHeader read_ply_header(std::string_view bytes, const std::string& name, Warnings& warnings) {
  return HeaderReader(bytes, name, warnings).read();
}

}  // namespace tessera
