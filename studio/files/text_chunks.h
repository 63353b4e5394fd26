#pragma once

#include <cstddef>
#include <memory>
#include <string>
#include <string_view>
#include <vector>

namespace tessera {

/// How long a text is, by each measure that somebody counts it in.
struct TextExtent {
  size_t bytes = 0;  ///< as the file has them
  size_t units = 0;  ///< UTF-16 code units, each line end being one
  size_t lf = 0;     ///< lines that end with \n alone
  size_t crlf = 0;   ///< lines that end with \r\n
  size_t cr = 0;     ///< lines that end with \r alone

  size_t line_ends() const { return lf + crlf + cr; }
  /// Bytes of UTF-8 where each line end is one.
  size_t text_bytes() const { return bytes - crlf; }
  TextExtent& operator+=(const TextExtent& other);
  friend bool operator==(const TextExtent&, const TextExtent&) = default;
};

/// The extent of UTF-8 that does not end within a character or between \r and \n.
TextExtent extent_of(std::string_view text);

/// What a reader of scene files takes for the end of a line when it counts them.
enum class LineRule {
  lf,  ///< \n alone, also after \r: text and JSON of our own, glTF, X3D
  any  ///< \n, \r\n and \r, as the editor does: .crt, .obj, .mtl, .ply, .stl
};

/// UTF-8 with its line ends as the file has them, in chunks of a few kilobytes, so that a change of
/// one character in a text of megabytes touches one of them. A value: copies share chunks, and cost
/// a pointer a chunk. A position lies between two characters, and not between \r and \n.
class TextChunks {
 public:
  explicit TextChunks(std::string_view text = {});

  const TextExtent& extent() const { return starts_.back(); }
  /// Calls `take` with each chunk's bytes, in order.
  template <typename Take>
  void for_each(const Take& take) const {
    for (const Chunk& chunk : chunks_) take(std::string_view(*chunk.text));
  }

  /// What lies before the last position that is not beyond so many bytes, units or text bytes.
  TextExtent prefix_of_bytes(size_t bytes) const;
  TextExtent prefix_of_units(size_t units) const;
  TextExtent prefix_of_text_bytes(size_t bytes) const;
  /// The first `lines` lines with their ends; everything where there are not that many.
  TextExtent prefix_of_lines(size_t lines, LineRule rule) const;

  /// The byte at a position; -1 at the end.
  int byte_at(size_t at) const;

  /// Finds positions by units that do not descend, in one pass.
  class UnitCursor {
   public:
    /// The text must outlive this.
    explicit UnitCursor(const TextChunks& text) : text_(text) {}
    struct Place {
      size_t bytes = 0, units = 0;
    };
    /// The last position that is not beyond so many units.
    Place find(size_t units);

   private:
    const TextChunks& text_;
    size_t chunk_ = 0, done_ = 0;  ///< `at_` is so many bytes behind the chunk's beginning
    TextExtent at_;
  };

 private:
  friend class TextRewriter;
  struct Chunk {
    std::shared_ptr<const std::string> text;
    TextExtent extent;
  };
  using Measure = size_t (*)(const TextExtent&);

  TextExtent prefix(Measure measure, size_t most) const;
  size_t chunk_before(Measure measure, size_t most) const;
  void sum_up(size_t first);
  static void cut(std::string_view text, std::vector<Chunk>& chunks);

  std::vector<Chunk> chunks_;
  std::vector<TextExtent> starts_;  ///< of each chunk, and the end of the text
};

/// Makes another text of one, from the beginning to the end. What does not change is shared.
class TextRewriter {
 public:
  /// The text must outlive this.
  explicit TextRewriter(const TextChunks& text);

  /// Takes over what lies before that byte of the text and was not dealt with yet.
  void keep_to(size_t byte);
  /// Puts `text` in its place. What is joined must not make one end of two: \r before \n.
  void replace_to(size_t byte, std::string_view text);
  /// Of what was made so far; -1 where that is nothing.
  int last_byte() const;
  /// The last line end of what was made so far; where there is none, such as most ends are.
  std::string_view last_end() const;
  /// With all that was not dealt with yet.
  TextChunks finish();

 private:
  using Chunk = TextChunks::Chunk;
  /// Calls `take` with each piece before that byte that was not dealt with yet, and its chunk.
  template <typename Take>
  void pass_to(size_t byte, const Take& take);
  void append(std::string_view piece);
  void flush();

  const TextChunks& text_;
  size_t chunk_ = 0, at_ = 0;  ///< the byte that is next, and its chunk
  std::vector<Chunk> made_;
  std::string open_;                                ///< behind these, not cut into chunks yet
  std::string_view last_end_;                       ///< empty: none, unless in the next
  const std::string* chunk_of_last_end_ = nullptr;  ///< that was taken over as it is
  size_t lf_, crlf_, cr_;                           ///< of the whole text as it is by now
};

}  // namespace tessera
