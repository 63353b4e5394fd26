#include "studio/files/document.h"

#include <fmt/format.h>
#include <gtest/gtest.h>
#include <rapidcheck/gtest.h>

#include <algorithm>
#include <string>
#include <vector>

#include "base/file.h"

namespace tessera {
namespace {

// ---------------------------------------------------------------------------- a naive document

// Line ends in a text of UTF-16: no text has these characters.
constexpr char16_t kLf = 0xE000, kCrlf = 0xE001, kCr = 0xE002;

bool is_end(char16_t c) { return c >= kLf && c <= kCr; }

/// UTF-8 to UTF-16, each line end one of the three.
std::u16string naive_of(const std::string& bytes) {
  std::u16string out;
  for (size_t i = 0; i < bytes.size();) {
    const auto first = static_cast<unsigned char>(bytes[i]);
    const size_t length = first < 0x80 ? 1 : first < 0xE0 ? 2 : first < 0xF0 ? 3 : 4;
    uint32_t code = length == 1 ? first : first & (0x7Fu >> length);
    for (size_t k = 1; k < length; ++k)
      code = code << 6 | (static_cast<unsigned char>(bytes[i + k]) & 0x3F);
    i += length;
    if (code == '\r' && i < bytes.size() && bytes[i] == '\n') {
      ++i;
      out += kCrlf;
    } else if (code == '\n' || code == '\r') {
      out += code == '\n' ? kLf : kCr;
    } else if (code < 0x10000) {
      out += static_cast<char16_t>(code);
    } else {
      out += static_cast<char16_t>(0xD800 + ((code - 0x10000) >> 10));
      out += static_cast<char16_t>(0xDC00 + ((code - 0x10000) & 0x3FF));
    }
  }
  return out;
}

/// To UTF-8, with the ends of the file or \n alone.
std::string bytes_of(const std::u16string& text, bool is_plain = false) {
  std::string out;
  for (size_t i = 0; i < text.size(); ++i) {
    uint32_t code = text[i];
    if (is_end(text[i])) {
      out += is_plain || code == kLf ? "\n" : code == kCrlf ? "\r\n" : "\r";
      continue;
    }
    if (code >= 0xD800 && code < 0xDC00)
      code = 0x10000 + ((code - 0xD800) << 10) + (text[++i] - 0xDC00u);
    if (code < 0x80) {
      out += static_cast<char>(code);
    } else {
      const int more = code < 0x800 ? 1 : code < 0x10000 ? 2 : 3;
      out += static_cast<char>((more == 1 ? 0xC0 : more == 2 ? 0xE0 : 0xF0) | code >> (6 * more));
      for (int k = more; k-- > 0;) out += static_cast<char>(0x80 | (code >> (6 * k) & 0x3F));
    }
  }
  return out;
}

bool splits_pair(const std::u16string& text, size_t at) {
  return at < text.size() && text[at] >= 0xDC00 && text[at] < 0xE000;
}

char16_t new_end(const std::u16string& text, size_t at) {
  for (size_t i = at; i-- > 0;) {
    if (is_end(text[i])) return text[i];
  }
  const auto count = [&](char16_t end) { return std::count(text.begin(), text.end(), end); };
  if (count(kLf) >= count(kCrlf) && count(kLf) >= count(kCr)) return kLf;
  return count(kCrlf) >= count(kCr) ? kCrlf : kCr;
}

void naive_apply(std::u16string& text, const std::vector<TextChange>& changes) {
  std::ptrdiff_t shift = 0;
  for (const TextChange& change : changes) {
    const auto from = static_cast<size_t>(static_cast<std::ptrdiff_t>(change.from) + shift);
    const size_t count = change.to - change.from;
    std::u16string made = naive_of(change.text);
    const char16_t end = new_end(text, from);
    for (char16_t& c : made) {
      if (is_end(c)) c = end;
    }
    // \r and \n next to each other would be one end.
    const bool after_cr = from > 0 && text[from - 1] == kCr;
    const bool before_lf = from + count < text.size() && text[from + count] == kLf;
    if (made.empty() && after_cr && before_lf) text[from + count] = kCrlf;
    if (!made.empty() && before_lf && made.back() == kCr) made.back() = kCrlf;
    text.replace(from, count, made);
    shift += static_cast<std::ptrdiff_t>(made.size()) - static_cast<std::ptrdiff_t>(count);
  }
}

// ---------------------------------------------------------------------------- random texts

const std::vector<std::string> kPieces{"\n",       "\r\n",      "\r",           "a",
                                       "sphere {", "\xC3\xA9",  "\xE2\x82\xAC", "\xF0\x9F\x98\x80",
                                       "\t",       "  x -> 1.5"};

std::string random_text(int most, bool is_plain) {
  const auto picks = *rc::gen::resize(
      most, rc::gen::container<std::vector<size_t>>(rc::gen::inRange<size_t>(0, kPieces.size())));
  // Longer than a chunk, now and then.
  const auto times = *rc::gen::weightedElement<int>({{6, 1}, {1, 40}, {1, 300}});
  std::string text;
  for (int i = 0; i < times; ++i) {
    for (const size_t pick : picks) text += is_plain && pick < 3 ? "\n" : kPieces[pick];
  }
  return text;
}

std::vector<TextChange> random_changes(const std::u16string& text) {
  const auto count = *rc::gen::inRange<size_t>(1, 5);
  std::vector<size_t> at;
  for (size_t i = 0; i < 2 * count; ++i) {
    size_t offset = *rc::gen::inRange<size_t>(0, text.size() + 1);
    if (splits_pair(text, offset)) --offset;
    at.push_back(offset);
  }
  std::sort(at.begin(), at.end());
  std::vector<TextChange> changes;
  for (size_t i = 0; i < count; ++i)
    changes.push_back({at[2 * i], at[2 * i + 1], random_text(4, true)});
  return changes;
}

RC_GTEST_PROP(StudioDocument, AnUneditedTextGivesItsBytesBack, ()) {
  const std::string marks =
      *rc::gen::element<std::string>("", "\xEF\xBB\xBF", "\xEF\xBB\xBF\xEF\xBB\xBF");
  const std::string bytes = marks + random_text(60, false);
  const Document document(bytes);
  RC_ASSERT(document.is_editable());
  RC_ASSERT(document.bytes() == bytes);
  RC_ASSERT(document.hash() == Digest::of(bytes));
  RC_ASSERT(document.text() == bytes_of(naive_of(bytes.substr(marks.size())), true));
  RC_ASSERT(document.has_byte_order_mark() == !marks.empty());
}

RC_GTEST_PROP(StudioDocument, RandomEditsAreThoseOfANaiveText, ()) {
  const std::string start = random_text(60, false);
  std::u16string naive = naive_of(start);
  Document document(start);
  const auto rounds = *rc::gen::inRange<uint64_t>(1, 12);
  for (uint64_t i = 0; i < rounds; ++i) {
    const std::vector<TextChange> changes = random_changes(naive);
    const Document before = document;
    RC_ASSERT(!document.apply(changes));
    RC_ASSERT(before.bytes() == bytes_of(naive));  // a copy stays as it is
    naive_apply(naive, changes);
    RC_ASSERT(document.version() == i + 2);
    RC_ASSERT(document.bytes() == bytes_of(naive));
    RC_ASSERT(document.text() == bytes_of(naive, true));
    RC_ASSERT(document.units() == naive.size());
    // No two ends became one: the saved file is read as the very text.
    RC_ASSERT(Document(document.bytes()).text() == document.text());
  }
}

TEST(StudioDocument, ChangesThatTouchKeepEndsApartOnce) {
  for (const auto& [second, expected] : std::vector<std::pair<TextChange, std::string>>{
           {{2, 2, ""}, "\r\r\n\n"}, {{2, 3, ""}, "\r\r\n"}, {{2, 2, "\n"}, "\r\r\r\n\n"}}) {
    Document document("\r\r\n\n\n");
    EXPECT_FALSE(document.apply(std::vector<TextChange>{{1, 2, ""}, second}));
    EXPECT_EQ(document.bytes(), expected);
  }
}

RC_GTEST_PROP(StudioDocument, OffsetsAreConvertedAsByCounting, ()) {
  const std::string bytes = random_text(80, false);
  const std::u16string naive = naive_of(bytes);
  const Document document(bytes);
  const size_t asked = *rc::gen::inRange<size_t>(0, naive.size() + 3);
  size_t offset = std::min(asked, naive.size());
  if (splits_pair(naive, offset)) --offset;
  const std::u16string before = naive.substr(0, offset);
  const size_t start = static_cast<size_t>(
      std::find_if(before.rbegin(), before.rend(), is_end).base() - before.begin());
  const auto line = static_cast<size_t>(std::count_if(before.begin(), before.end(), is_end)) + 1;
  const TextPosition position{line, offset - start + 1};
  RC_ASSERT(document.position_of(asked) == position);
  RC_ASSERT(document.offset_of(position) == offset);
  const size_t byte = bytes_of(before).size(), text_byte = bytes_of(before, true).size();
  RC_ASSERT(document.file_byte_of(asked) == byte);
  RC_ASSERT(document.offset_of_file_byte(byte) == offset);
  RC_ASSERT(document.text_byte_of(asked) == text_byte);
  RC_ASSERT(document.offset_of_text_byte(text_byte) == offset);

  const TextPosition any{line, bytes_of(before.substr(start)).size() + 1};
  RC_ASSERT(document.place_of(asked, LineRule::any) == any);
  RC_ASSERT(document.offset_of_place(any.line, any.column, LineRule::any) == offset);
  const std::string text_before = bytes.substr(0, byte);
  const TextPosition lf{
      static_cast<size_t>(std::count(text_before.begin(), text_before.end(), '\n')) + 1,
      byte - (text_before.rfind('\n') + 1) + 1};
  RC_ASSERT(document.place_of(asked, LineRule::lf) == lf);
  RC_ASSERT(document.offset_of_place(lf.line, lf.column, LineRule::lf) == offset);
}

RC_GTEST_PROP(StudioDocument, ADifferenceMakesOneTextOfTheOther, ()) {
  const std::string before = random_text(20, true), after = random_text(20, true);
  Document document(before);
  const auto changes = difference(before, after);
  RC_ASSERT(!document.apply(changes));
  RC_ASSERT(document.text() == after);
  RC_ASSERT(changes.empty() == (before == after));
}

// ---------------------------------------------------------------------------- single cases

std::string edited(std::string_view bytes, std::vector<TextChange> changes) {
  Document document(bytes);
  EXPECT_EQ(document.apply(changes), std::nullopt);
  return document.bytes();
}

TEST(StudioDocument, ManyChangesOfALargeTextAreOneEdit) {
  // So many that a pass over the text for each of them would take minutes.
  std::string before, after;
  std::vector<TextChange> changes;
  size_t units = 0;
  for (int i = 0; i < 300'000; ++i) {
    const std::string line = fmt::format("ä{} b\r\n", i);
    const size_t end = units + extent_of(line).units;
    changes.push_back({end - 2, end - 1, "c\nd"});
    before += line;
    after += line.substr(0, line.size() - 3) + "c\r\nd\r\n";
    units = end;
  }
  Document document(before);
  ASSERT_EQ(document.apply(changes), std::nullopt);
  EXPECT_TRUE(document.bytes() == after);
  EXPECT_EQ(document.lines(), 600'001u);
  EXPECT_EQ(document.version(), 2u);
}

TEST(StudioDocument, NewLinesEndAsTheLineBeforeThem) {
  EXPECT_EQ(edited("a\r\nb\nc\n", {{3, 3, "\n"}}), "a\r\nb\r\n\nc\n");
  EXPECT_EQ(edited("a\r\nb\nc\n", {{4, 4, "x\ny\n"}}), "a\r\nb\nx\ny\nc\n");
  // The first line has none before it: as most lines of the file.
  EXPECT_EQ(edited("a\r\nb\r\nc\n", {{1, 1, "\n"}}), "a\r\n\r\nb\r\nc\n");
  EXPECT_EQ(edited("a\rb\r", {{0, 4, "x\ny"}}), "x\ry");
  EXPECT_EQ(edited("", {{0, 0, "x\ny"}}), "x\ny");
}

TEST(StudioDocument, AReturnAndANewlineOfTwoLinesStayTwoEnds) {
  EXPECT_EQ(edited("a\rb\nc", {{2, 3, ""}}), "a\r\r\nc");
  EXPECT_EQ(edited("a\rb\nc", {{3, 3, "\n"}}), "a\rb\r\n\nc");
  EXPECT_EQ(edited("a\rb\nc", {{2, 3, "\n"}}), "a\r\r\n\nc");
}

TEST(StudioDocument, KeepsAFileWithoutAFinalNewline) {
  EXPECT_EQ(edited("a\nb", {{0, 1, "x"}}), "x\nb");
  EXPECT_EQ(edited("\xEF\xBB\xBF"
                   "a\r\nb",
                   {{3, 3, "c"}}),
            "\xEF\xBB\xBF"
            "a\r\nbc");
}

TEST(StudioDocument, RefusesBadChangesAsAWhole) {
  const std::string text =
      "a\xF0\x9F\x98\x80"
      "b\n";
  const std::vector<std::vector<TextChange>> bad{{{0, 1, "x"}, {6, 6, "y"}},  // beyond the text
                                                 {{2, 2, ""}},  // within a pair of surrogates
                                                 {{0, 2, ""}},  // ends there
                                                 {{3, 4, "x"}, {0, 1, "y"}},  // not ascending
                                                 {{0, 3, "x"}, {1, 4, "y"}},  // overlapping
                                                 {{3, 1, ""}},                // backwards
                                                 {{0, 0, "x"}, {SIZE_MAX, SIZE_MAX, ""}},
                                                 {{0, 0, "a\r\nb"}},
                                                 {{0, 0, std::string("\0", 1)}},
                                                 {{0, 0, "\xED\xA0\x80"}},
                                                 {{0, 0, "\xFF"}}};
  for (const auto& changes : bad) {
    Document document(text);
    EXPECT_NE(document.apply(changes), std::nullopt) << changes[0].from << ' ' << changes[0].text;
    EXPECT_EQ(document.bytes(), text);
    EXPECT_EQ(document.version(), 1u);
  }
  Document document(text);
  EXPECT_EQ(document.apply(std::vector<TextChange>{{1, 3, "x"}, {3, 3, "y"}}), std::nullopt);
  EXPECT_EQ(document.bytes(), "axyb\n");
}

TEST(StudioDocument, RefusesATextThatGrowsTooLong) {
  Document document(std::string(Document::kMostBytes - 2, 'x'));
  ASSERT_TRUE(document.is_editable());
  EXPECT_NE(document.apply(std::vector<TextChange>{{0, 0, "abc"}}), std::nullopt);
  EXPECT_EQ(document.units(), Document::kMostBytes - 2);
  EXPECT_EQ(document.apply(std::vector<TextChange>{{0, 0, "ab"}}), std::nullopt);
}

TEST(StudioDocument, BytesThatAreNoTextAreShownAndKept) {
  const std::string nul("a\0b\n", 4);
  for (const std::string& bytes : {std::string("caf\xE9\r\n"), nul,
                                   std::string("\xFF\xFE"
                                               "a\0",
                                               4),
                                   std::string("\xEF\xBB\xBF\x80")}) {
    Document document(bytes);
    EXPECT_FALSE(document.is_editable());
    EXPECT_NE(document.why_not_editable(), "");
    EXPECT_NE(document.apply(std::vector<TextChange>{{0, 0, "x"}}), std::nullopt);
    EXPECT_EQ(document.bytes(), bytes);
    EXPECT_EQ(find_invalid_utf8(document.text()), std::string::npos);
    EXPECT_EQ(document.text().find('\0'), std::string::npos);
  }
  EXPECT_EQ(Document("caf\xE9\r\n").text(), "caf\xEF\xBF\xBD\n");
  EXPECT_EQ(Document(nul).text(),
            "a\xEF\xBF\xBD"
            "b\n");
  EXPECT_EQ(Document("x\ncaf\xE9").why_not_editable(),
            "line 2 has the byte 0xe9; only text in UTF-8 can be edited");
  EXPECT_EQ(Document("caf\xC3\xA9").encoding(), "UTF-8");
  EXPECT_EQ(Document("caf\xE9").encoding(), "not UTF-8");
  EXPECT_EQ(Document(std::string("ab\0", 3)).encoding(), "not UTF-8");
  EXPECT_EQ(Document(std::string("\xFF\xFE"
                                 "a\0",
                                 4))
                .encoding(),
            "UTF-16");
}

TEST(StudioDocument, OfAFileTooLongTheBeginningIsShown) {
  std::string bytes;
  while (bytes.size() <= Document::kMostBytes) bytes += "v 1 2 3 \xC3\xA9\n";
  const Document document(bytes);
  EXPECT_FALSE(document.is_editable());
  EXPECT_EQ(document.bytes(), bytes);
  const std::string text = document.text();
  EXPECT_LE(text.size(), Document::kMostBytes);
  EXPECT_TRUE(text.ends_with("\xC3\xA9\n"));
  EXPECT_FALSE(Document("short", false).is_editable());
}

TEST(StudioDocument, NamesItsLineEnds) {
  EXPECT_EQ(Document("").line_ends(), "lf");
  EXPECT_EQ(Document("a\nb\n").line_ends(), "lf");
  EXPECT_EQ(Document("a\r\nb").line_ends(), "crlf");
  EXPECT_EQ(Document("a\rb").line_ends(), "cr");
  EXPECT_EQ(Document("a\rb\n").line_ends(), "mixed");
}

TEST(StudioDocument, PlacesOutsideAreMovedInside) {
  const Document document(
      "ab\r\n\xC3\xA9"
      "d\n");
  const auto at = [&](size_t line, size_t column) {
    return document.offset_of_place(line, column, LineRule::lf);
  };
  EXPECT_EQ(at(0, 0), 0u);
  EXPECT_EQ(at(1, 0), 0u);
  EXPECT_EQ(at(1, 100), 2u);
  EXPECT_EQ(at(2, 2), 3u);  // within the letter
  EXPECT_EQ(at(2, 3), 4u);
  EXPECT_EQ(at(3, 7), document.units());
  EXPECT_EQ(at(99, 1), document.units());
  EXPECT_EQ(document.offset_of({1, 9}), 2u);
  EXPECT_EQ(document.offset_of({9, 9}), document.units());
  EXPECT_EQ(document.position_of(99), (TextPosition{3, 1}));
  EXPECT_EQ(document.position_of_place(2, 3, LineRule::lf), (TextPosition{2, 2}));
}

TEST(StudioDocument, ReadersDoNotCountByteOrderMarks) {
  const Document document(
      "\xEF\xBB\xBF"
      "ab");
  EXPECT_EQ(document.offset_of_place(1, 2, LineRule::lf), 1u);
  // One that was typed becomes one of the file's.
  Document typed("ab");
  ASSERT_EQ(typed.apply(std::vector<TextChange>{{0, 0, "\xEF\xBB\xBF"}}), std::nullopt);
  EXPECT_EQ(typed.offset_of_place(1, 2, LineRule::lf), 2u);
  EXPECT_EQ(typed.place_of(2, LineRule::lf), (TextPosition{1, 2}));
}

TEST(StudioDocument, ReadersDisagreeOnReturns) {
  EXPECT_EQ(line_rule_of("a/b.CRT"), LineRule::any);
  EXPECT_EQ(line_rule_of("b.tessera"), LineRule::lf);
  const Document document("a\rbc\nd");
  EXPECT_EQ(document.offset_of_place(1, 4, LineRule::lf), 3u);
  EXPECT_EQ(document.offset_of_place(2, 2, LineRule::any), 3u);
}

TEST(StudioDocument, TakesLineEndsOfAFileOfTheSameText) {
  Document document("a\nb\n");
  EXPECT_FALSE(document.adopt("a\nc\n"));
  EXPECT_TRUE(
      document.adopt("\xEF\xBB\xBF"
                     "a\r\nb\r\n"));
  EXPECT_EQ(document.bytes(),
            "\xEF\xBB\xBF"
            "a\r\nb\r\n");
  EXPECT_EQ(document.version(), 1u);
}

}  // namespace
}  // namespace tessera
