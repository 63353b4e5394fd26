#include "image/plain/pnm_format.h"

#include <algorithm>
#include <charconv>
#include <cstring>
#include <string_view>

namespace tessera {
namespace {

using namespace std::literals;

/// Reads the numbers of a file. They stand between white space, and comments from # to the line's
/// end.
class NumberReader {
 public:
  explicit NumberReader(std::string_view text) : text_(text) {}

  std::optional<uint32_t> number() {
    skip_space();
    uint32_t value = 0;
    const auto [end, error] = std::from_chars(text_.data(), text_.data() + text_.size(), value);
    if (error != std::errc()) return std::nullopt;
    text_.remove_prefix(static_cast<size_t>(end - text_.data()));
    return value;
  }
  /// A sample of P1, which needs no space around it.
  std::optional<uint32_t> bit() {
    skip_space();
    if (text_.empty() || (text_[0] != '0' && text_[0] != '1')) return std::nullopt;
    const auto value = static_cast<uint32_t>(text_[0] - '0');
    text_.remove_prefix(1);
    return value;
  }
  /// What follows the single white space after the header.
  std::string_view raster() const { return text_.substr(std::min<size_t>(1, text_.size())); }

 private:
  void skip_space() {
    for (;;) {
      text_.remove_prefix(std::min(text_.find_first_not_of(" \t\r\n\v\f"sv), text_.size()));
      if (!text_.starts_with('#')) return;
      text_.remove_prefix(std::min(text_.find_first_of("\r\n"sv), text_.size()));
    }
  }

  std::string_view text_;
};

struct Header {
  bool is_text = false, is_bitmap = false;
  uint32_t most = 1;  ///< the largest value of a sample
  PixelLayout layout;

  size_t samples() const {
    return static_cast<size_t>(layout.width) * static_cast<size_t>(layout.height) *
           static_cast<size_t>(layout.channels);
  }
};

std::optional<Header> read_header(char kind, NumberReader& in) {
  Header header;
  header.is_text = kind <= '3';
  header.is_bitmap = kind == '1' || kind == '4';
  const bool is_rgb = kind == '3' || kind == '6';
  const auto width = in.number(), height = width ? in.number() : std::nullopt;
  const auto most = header.is_bitmap ? std::optional(1U) : height ? in.number() : std::nullopt;
  if (!height || !most || *most < 1 || *most > UINT16_MAX) return std::nullopt;
  if (std::max(*width, *height) > PixelLayout::kMostSide) return std::nullopt;
  header.most = *most;
  header.layout = {static_cast<int32_t>(*width), static_cast<int32_t>(*height), is_rgb ? 3 : 1,
                   UINT8_MAX % *most == 0 ? 8 : 32};
  if (!header.layout.is_legal()) return std::nullopt;
  return header;
}

/// `value(i)` is sample i of the file, or nothing where it has no such.
template <typename Value>
bool store(const Header& header, std::vector<char>& out, const Value& value) {
  out.resize(header.layout.bytes());
  const bool is_float = header.layout.bits == 32;
  const uint32_t scale = UINT8_MAX / std::min<uint32_t>(header.most, UINT8_MAX);  // to 8 bits
  for (size_t i = 0; i < header.samples(); ++i) {
    const std::optional<uint32_t> given = value(i);
    if (!given) return false;
    const uint32_t sample = std::min(*given, header.most);
    if (is_float) {
      const float share = static_cast<float>(sample) / static_cast<float>(header.most);
      std::memcpy(&out[i * sizeof share], &share, sizeof share);
    } else {
      out[i] = static_cast<char>(sample * scale);
    }
  }
  return true;
}

bool read_text(const Header& header, NumberReader in, std::vector<char>& out) {
  // A sample has at least one character, so that the file bounds what is allocated for it.
  if (in.raster().size() < header.samples()) return false;
  if (!header.is_bitmap) return store(header, out, [&in](size_t) { return in.number(); });
  return store(header, out, [&in](size_t) {
    const auto black = in.bit();
    return black ? std::optional(1 - *black) : std::nullopt;
  });
}

bool read_binary(const Header& header, std::string_view raster, std::vector<char>& out) {
  const auto byte = [raster](size_t at) { return static_cast<uint8_t>(raster[at]); };
  const auto fits = [&](size_t bytes) { return raster.size() >= bytes; };
  if (header.is_bitmap) {
    const auto width = static_cast<size_t>(header.layout.width), stride = (width + 7) / 8;
    if (!fits(stride * static_cast<size_t>(header.layout.height))) return false;
    return store(header, out, [&](size_t i) {
      const size_t x = i % width;
      return std::optional(1U - (byte(i / width * stride + x / 8) >> (7 - x % 8) & 1U));
    });
  }
  const bool is_wide = header.most > UINT8_MAX;
  if (!fits(header.samples() * (is_wide ? 2 : 1))) return false;
  if (!is_wide) {
    return store(header, out, [&](size_t i) { return std::optional<uint32_t>(byte(i)); });
  }
  return store(header, out, [&](size_t i) {
    return std::optional<uint32_t>(byte(2 * i) << 8 | byte(2 * i + 1));
  });
}

}  // namespace

std::optional<ImageAnswer> decode_pnm(std::span<const char> file, bool names_channels) {
  const std::string_view text(file.data(), file.size());
  if (text.size() < 2 || text[0] != 'P' || text[1] < '1' || text[1] > '6') return std::nullopt;
  NumberReader in(text.substr(2));
  const std::optional<Header> header = read_header(text[1], in);
  if (!header) return std::nullopt;
  ImageAnswer answer;
  answer.layout = header->layout;
  answer.meaning.from_integers = true;
  if (names_channels) answer.names = header->layout.channels == 3 ? "R\0G\0B\0"s : "Y\0"s;
  const bool is_whole = header->is_text ? read_text(*header, in, answer.payload)
                                        : read_binary(*header, in.raster(), answer.payload);
  if (!is_whole) return std::nullopt;
  return answer;
}

}  // namespace tessera
