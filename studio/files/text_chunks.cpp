#include "studio/files/text_chunks.h"

#include <algorithm>
#include <bit>
#include <cstdint>
#include <cstring>
#include <iterator>

namespace tessera {
namespace {

constexpr size_t kChunkBytes = 4096;
/// Smaller ones are joined with their neighbour.
constexpr size_t kSmallChunk = kChunkBytes / 4;

unsigned byte_of(char c) { return static_cast<unsigned char>(c); }
bool is_continuation(char c) { return (byte_of(c) & 0xC0) == 0x80; }

/// The extent of the character or line end at `at`.
TextExtent step_at(std::string_view text, size_t at) {
  const unsigned first = byte_of(text[at]);
  if (first == '\n') return {.bytes = 1, .units = 1, .lf = 1};
  if (first == '\r') {
    if (at + 1 < text.size() && text[at + 1] == '\n') return {.bytes = 2, .units = 1, .crlf = 1};
    return {.bytes = 1, .units = 1, .cr = 1};
  }
  if (first < 0x80) return {.bytes = 1, .units = 1};
  if (first < 0xE0) return {.bytes = 2, .units = 1};
  if (first < 0xF0) return {.bytes = 3, .units = 1};
  return {.bytes = 4, .units = 2};
}

/// The last position of `text` that is not beyond `at`.
size_t position_before(std::string_view text, size_t at) {
  if (at >= text.size()) return text.size();
  while (at > 0 && is_continuation(text[at])) --at;
  if (at > 0 && text[at] == '\n' && text[at - 1] == '\r') --at;
  return at;
}

constexpr uint64_t kHighBits = 0x8080808080808080;

/// The first of the eight bytes lowest; zeros behind the end.
uint64_t word_at(std::string_view text, size_t at) {
  uint64_t word = 0;
  const size_t size = std::min(text.size() - at, sizeof word);
  if constexpr (std::endian::native == std::endian::little) {
    std::memcpy(&word, text.data() + at, size);
  } else {
    for (size_t i = 0; i < size; ++i) word |= uint64_t{byte_of(text[at + i])} << (8 * i);
  }
  return word;
}

/// The highest bit of each byte that is `wanted`, which is ASCII.
uint64_t equal_bytes(uint64_t word, char wanted) {
  const uint64_t other = word ^ (byte_of(wanted) * (kHighBits >> 7));  // zero where equal
  return ~(((other & ~kHighBits) + ~kHighBits) | other) & kHighBits;
}

/// Of the bytes whose highest bit is set.
size_t count_of(uint64_t mask) { return ((mask & kHighBits) >> 7) * (kHighBits >> 7) >> 56; }

/// From `done` bytes of `text`, before which lies `at`, on as long as `stays(next)`: first by
/// blocks, then by characters. Where it falls, it stays so.
template <typename Stays>
void advance(std::string_view text, size_t& done, TextExtent& at, const Stays& stays) {
  constexpr size_t kBlock = 256;
  for (const bool by_blocks : {true, false}) {
    while (done < text.size()) {
      const size_t end = by_blocks ? position_before(text, done + kBlock) : done;
      TextExtent next = at;
      next += by_blocks ? extent_of(text.substr(done, end - done)) : step_at(text, done);
      if (!stays(next)) break;
      done += next.bytes - at.bytes;
      at = next;
    }
  }
}

size_t bytes_of(const TextExtent& extent) { return extent.bytes; }
size_t units_of(const TextExtent& extent) { return extent.units; }
size_t text_bytes_of(const TextExtent& extent) { return extent.text_bytes(); }
size_t any_ends_of(const TextExtent& extent) { return extent.line_ends(); }
size_t lf_ends_of(const TextExtent& extent) { return extent.lf + extent.crlf; }

}  // namespace

TextExtent& TextExtent::operator+=(const TextExtent& other) {
  bytes += other.bytes;
  units += other.units;
  lf += other.lf;
  crlf += other.crlf;
  cr += other.cr;
  return *this;
}

TextExtent extent_of(std::string_view text) {
  // Eight bytes at a time; of each the highest bit of its byte in a mask says that it is counted.
  size_t inside = 0, pairs = 0, newlines = 0, returns = 0, joined = 0;
  uint64_t before = 0;  // the returns of the word before
  for (size_t at = 0; at < text.size(); at += sizeof(uint64_t)) {
    const uint64_t word = word_at(text, at);
    const uint64_t is_newline = equal_bytes(word, '\n'), is_return = equal_bytes(word, '\r');
    inside += count_of(word & ~(word << 1));
    pairs += count_of(word & word << 1 & word << 2 & word << 3);
    newlines += count_of(is_newline);
    returns += count_of(is_return);
    joined += count_of(is_newline & (is_return << 8 | before >> 56));
    before = is_return;
  }
  return {.bytes = text.size(),
          .units = text.size() - inside + pairs - joined,
          .lf = newlines - joined,
          .crlf = joined,
          .cr = returns - joined};
}

TextChunks::TextChunks(std::string_view text) {
  cut(text, chunks_);
  sum_up(0);
}

void TextChunks::cut(std::string_view text, std::vector<Chunk>& chunks) {
  while (!text.empty()) {
    // Not a small rest behind a full chunk.
    const size_t most = text.size() < kChunkBytes + kSmallChunk ? text.size() : kChunkBytes;
    const std::string_view part = text.substr(0, position_before(text, most));
    chunks.push_back({std::make_shared<const std::string>(part), extent_of(part)});
    text.remove_prefix(part.size());
  }
}

void TextChunks::sum_up(size_t first) {
  starts_.resize(chunks_.size() + 1);
  for (size_t i = first; i < chunks_.size(); ++i) {
    starts_[i + 1] = starts_[i];
    starts_[i + 1] += chunks_[i].extent;
  }
}

size_t TextChunks::chunk_before(Measure measure, size_t most) const {
  const auto beyond =
      std::partition_point(starts_.begin() + 1, starts_.end(),
                           [&](const TextExtent& start) { return measure(start) <= most; });
  return static_cast<size_t>(std::distance(starts_.begin(), beyond)) - 1;
}

TextExtent TextChunks::prefix(Measure measure, size_t most) const {
  const size_t index = chunk_before(measure, most);
  TextExtent at = starts_[index];
  if (index == chunks_.size()) return at;
  const std::string_view text = *chunks_[index].text;
  size_t done = 0;
  advance(text, done, at, [&](const TextExtent& next) { return measure(next) <= most; });
  return at;
}

TextExtent TextChunks::prefix_of_bytes(size_t bytes) const {
  const size_t index = chunk_before(bytes_of, bytes);
  TextExtent at = starts_[index];
  if (index == chunks_.size()) return at;
  const std::string_view text = *chunks_[index].text;
  at += extent_of(text.substr(0, position_before(text, bytes - at.bytes)));
  return at;
}

TextExtent TextChunks::prefix_of_units(size_t units) const {
  const size_t index = chunk_before(units_of, units);
  if (index < chunks_.size() && chunks_[index].extent.units == chunks_[index].extent.bytes)
    return prefix_of_bytes(starts_[index].bytes + units - starts_[index].units);
  return prefix(units_of, units);
}

TextExtent TextChunks::prefix_of_text_bytes(size_t bytes) const {
  const size_t index = chunk_before(text_bytes_of, bytes);
  if (index < chunks_.size() && chunks_[index].extent.crlf == 0)
    return prefix_of_bytes(starts_[index].bytes + bytes - starts_[index].text_bytes());
  return prefix(text_bytes_of, bytes);
}

TextExtent TextChunks::prefix_of_lines(size_t lines, LineRule rule) const {
  if (lines == 0) return {};
  const Measure ends = rule == LineRule::any ? any_ends_of : lf_ends_of;
  const size_t index = chunk_before(ends, lines - 1);
  TextExtent at = starts_[index];
  if (index == chunks_.size()) return at;
  const std::string_view text = *chunks_[index].text;
  size_t done = 0;
  advance(text, done, at, [&](const TextExtent& next) { return ends(next) < lines; });
  if (done < text.size()) at += step_at(text, done);
  return at;
}

int TextChunks::byte_at(size_t at) const {
  const size_t index = chunk_before(bytes_of, at);
  if (index == chunks_.size()) return -1;
  return static_cast<int>(byte_of((*chunks_[index].text)[at - starts_[index].bytes]));
}

TextChunks::UnitCursor::Place TextChunks::UnitCursor::find(size_t units) {
  const std::vector<TextExtent>& starts = text_.starts_;
  if (const size_t chunk = text_.chunk_before(units_of, units); chunk != chunk_) {
    chunk_ = chunk;
    done_ = 0;
    at_ = starts[chunk];
  }
  if (chunk_ == text_.chunks_.size()) return {starts.back().bytes, starts.back().units};
  const auto& [text, extent] = text_.chunks_[chunk_];
  if (extent.units == extent.bytes)
    return {starts[chunk_].bytes + units - starts[chunk_].units, units};
  advance(*text, done_, at_, [units](const TextExtent& next) { return next.units <= units; });
  return {at_.bytes, at_.units};
}

TextRewriter::TextRewriter(const TextChunks& text)
    : text_(text), lf_(text.extent().lf), crlf_(text.extent().crlf), cr_(text.extent().cr) {
  made_.reserve(text.chunks_.size());
}

template <typename Take>
void TextRewriter::pass_to(size_t byte, const Take& take) {
  while (at_ < byte) {
    const Chunk& chunk = text_.chunks_[chunk_];
    const size_t start = text_.starts_[chunk_].bytes, end = text_.starts_[chunk_ + 1].bytes;
    const size_t to = std::min(byte, end);
    take(std::string_view(*chunk.text).substr(at_ - start, to - at_), chunk);
    at_ = to;
    if (to == end) ++chunk_;
  }
}

void TextRewriter::keep_to(size_t byte) {
  pass_to(byte, [this](std::string_view piece, const Chunk& chunk) {
    const bool is_whole = piece.size() == chunk.text->size();
    const bool ends_an_end = open_.ends_with('\r') && piece.starts_with('\n');
    const bool is_small = !open_.empty() && open_.size() < kSmallChunk;
    if (!is_whole || ends_an_end || is_small) return append(piece);
    flush();
    made_.push_back(chunk);
    if (chunk.extent.line_ends() > 0) chunk_of_last_end_ = chunk.text.get();
  });
}

void TextRewriter::replace_to(size_t byte, std::string_view text) {
  pass_to(byte, [this](std::string_view piece, const Chunk&) {
    const TextExtent removed = extent_of(piece);
    lf_ -= removed.lf;
    crlf_ -= removed.crlf;
    cr_ -= removed.cr;
  });
  const TextExtent added = extent_of(text);
  lf_ += added.lf;
  crlf_ += added.crlf;
  cr_ += added.cr;
  append(text);
}

void TextRewriter::append(std::string_view piece) {
  if (const size_t at = piece.find_last_of("\r\n"); at != std::string_view::npos) {
    const int before = at > 0 ? piece[at - 1] : last_byte();
    last_end_ = piece[at] == '\r' ? "\r" : before == '\r' ? "\r\n" : "\n";
    chunk_of_last_end_ = nullptr;
  }
  open_ += piece;
}

int TextRewriter::last_byte() const {
  if (!open_.empty()) return static_cast<int>(byte_of(open_.back()));
  return made_.empty() ? -1 : static_cast<int>(byte_of(made_.back().text->back()));
}

std::string_view TextRewriter::last_end() const {
  if (chunk_of_last_end_ != nullptr) {
    const std::string& text = *chunk_of_last_end_;
    const size_t at = text.find_last_of("\r\n");
    if (text[at] == '\r') return "\r";
    return at > 0 && text[at - 1] == '\r' ? "\r\n" : "\n";
  }
  if (!last_end_.empty()) return last_end_;
  if (lf_ >= crlf_ && lf_ >= cr_) return "\n";
  return crlf_ >= cr_ ? "\r\n" : "\r";
}

void TextRewriter::flush() {
  TextChunks::cut(open_, made_);
  open_.clear();
}

TextChunks TextRewriter::finish() {
  keep_to(text_.extent().bytes);
  if (!open_.empty() && open_.size() < kSmallChunk && !made_.empty()) {
    open_.insert(0, *made_.back().text);
    made_.pop_back();
  }
  flush();
  TextChunks made;
  made.chunks_ = std::move(made_);
  made.sum_up(0);
  return made;
}

}  // namespace tessera
