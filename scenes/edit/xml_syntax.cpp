#include "scenes/edit/xml_syntax.h"

#include <algorithm>
#include <vector>

#include "scenes/edit/outline.h"

namespace tessera::edit {
namespace {

bool ends_name(char c) {
  return is_space(c) || c == '=' || c == '>' || c == '/' || c == '<' || c == '"' || c == '\'';
}

/// Cuts XML into pieces, with a stack of its own: no text nests too deep for it.
class XmlSyntaxParser {
 public:
  explicit XmlSyntaxParser(std::string_view text) : text_(text) {}

  SyntaxTree parse() {
    const auto end = static_cast<uint32_t>(text_.size());
    at_ = std::min(byte_order_mark_size(text_), end);
    SyntaxNode root{.kind = SyntaxKind::block, .range = {at_, end}};
    root.value = root.body = root.range;
    open_ = {tree_.add(-1, root)};
    while (at_ < end) {
      const size_t next = text_.find('<', at_);
      at_ = next == std::string_view::npos ? end : static_cast<uint32_t>(next);
      if (at_ < end) markup();
    }
    while (open_.size() > 1) close(end, end, false);
    return std::move(tree_);
  }

 private:
  bool starts(std::string_view mark) const { return text_.substr(at_).starts_with(mark); }

  void pass(std::string_view mark) {
    const size_t end = text_.find(mark, at_);
    at_ = static_cast<uint32_t>(end == std::string_view::npos ? text_.size() : end + mark.size());
  }

  void markup() {
    if (starts("<!--")) return pass("-->");
    if (starts("<![CDATA[")) return pass("]]>");
    if (starts("<?")) return pass("?>");
    if (starts("<!")) return doctype();
    if (starts("</")) return closing();
    element();
  }

  void doctype() {
    int brackets = 0;
    for (; at_ < text_.size(); ++at_) {
      if (text_[at_] == '[') ++brackets;
      if (text_[at_] == ']') --brackets;
      if (text_[at_] != '>' || brackets > 0) continue;
      ++at_;
      return;
    }
  }

  SourceRange name() {
    const uint32_t begin = at_;
    while (at_ < text_.size() && !ends_name(text_[at_])) ++at_;
    return {begin, at_};
  }
  void skip() {
    while (at_ < text_.size() && is_space(text_[at_])) ++at_;
  }

  /// A tag that closes none is passed over; one that closes an outer one closes all within.
  void closing() {
    const uint32_t begin = at_;
    at_ += 2;
    const std::string_view closed = text_of(text_, name());
    while (at_ < text_.size() && text_[at_] != '>' && text_[at_] != '<') ++at_;
    if (at_ < text_.size() && text_[at_] == '>') ++at_;
    size_t depth = open_.size();
    const auto is_closed = [&](int32_t node) {
      return node >= 0 ? text_of(text_, tree_[node].name) == closed : false;
    };
    if (open_.back() < 0) {
      --hidden_;
      if (hidden_ == 0) open_.pop_back();
      return;
    }
    while (depth > 1 && !is_closed(open_[depth - 1])) --depth;
    if (depth <= 1) return;
    while (open_.size() > depth) close(begin, begin, false);
    close(begin, at_, true);
  }

  void close(uint32_t body_end, uint32_t end, bool is_closed) {
    const int32_t i = open_.back();
    open_.pop_back();
    if (i < 0) return;
    SyntaxNode& node = tree_[i];
    node.is_closed = is_closed;
    node.body.end = std::max(body_end, node.body.begin);
    node.range.end = node.value.end = std::max(end, node.body.end);
  }

  void element() {
    SyntaxNode made{.kind = SyntaxKind::block, .range = {at_, at_}};
    made.type = static_cast<int16_t>(XmlPart::element);
    ++at_;
    made.name = name();
    if (made.name.is_empty()) return;
    made.value = {made.range.begin, at_};
    made.body = {at_, at_};
    const bool is_hidden = open_.back() < 0 || open_.size() > kMaxOutlineDepth;
    const int32_t node = is_hidden ? -1 : tree_.add(open_.back(), made);
    uint32_t behind_last = at_;
    for (skip(); at_ < text_.size() && text_[at_] != '>' && text_[at_] != '<'; skip()) {
      if (starts("/>")) break;
      const uint32_t before = at_;
      attribute(node);
      if (at_ == before) ++at_;
      behind_last = at_;
    }
    const bool is_empty = starts("/>");
    if (is_empty) {
      at_ += 2;
    } else if (at_ < text_.size() && text_[at_] == '>') {
      ++at_;
    } else {
      at_ = std::max(behind_last, made.name.end);  // the tag is still being typed
    }
    if (node >= 0) {
      SyntaxNode& there = tree_[node];
      there.range.end = there.value.end = at_;
      there.body = is_empty ? SourceRange{at_ - 2, at_ - 2} : SourceRange{at_, at_};
    }
    if (is_empty) return;
    if (node >= 0) return open_.push_back(node);
    if (open_.back() >= 0) open_.push_back(-1);
    ++hidden_;
  }

  void attribute(int32_t node) {
    SyntaxNode made{.kind = SyntaxKind::scalar, .range = {at_, at_}};
    made.type = static_cast<int16_t>(XmlPart::attribute);
    made.name = name();
    if (made.name.is_empty()) return;
    const uint32_t after_name = at_;
    made.value = made.body = {at_, at_};
    skip();
    if (at_ >= text_.size() || text_[at_] != '=') {
      at_ = after_name;
    } else {
      ++at_;
      made.value = made.body = {at_, at_};
      const uint32_t after_sign = at_;
      skip();
      const char quote = at_ < text_.size() ? text_[at_] : '\0';
      if (quote == '"' || quote == '\'') {
        const size_t end = text_.find_first_of(quote == '"' ? "\"<" : "'<", at_ + 1);
        made.is_closed = end != std::string_view::npos && text_[end] == quote;
        const auto stop = static_cast<uint32_t>(std::min(end, text_.size()));
        made.body = {at_ + 1, stop};
        made.value = {at_, made.is_closed ? stop + 1 : stop};
        at_ = made.value.end;
      } else {
        at_ = after_sign;
      }
    }
    made.range.end = at_;
    if (node >= 0) tree_.add(node, made);
  }

  std::string_view text_;
  SyntaxTree tree_;
  std::vector<int32_t> open_;
  int hidden_ = 0;  ///< open elements that nest too deep to be told apart
  uint32_t at_ = 0;
};

}  // namespace

SyntaxTree parse_xml_syntax(std::string_view text) { return XmlSyntaxParser(text).parse(); }

std::string unescape_xml(std::string_view words) {
  constexpr std::pair<std::string_view, char> kNamed[] = {
      {"&amp;", '&'}, {"&lt;", '<'}, {"&gt;", '>'}, {"&quot;", '"'}, {"&apos;", '\''}};
  std::string text;
  for (size_t at = 0; at < words.size();) {
    bool is_named = false;
    for (const auto& [name, meant] : kNamed) {
      if (!words.substr(at).starts_with(name)) continue;
      text += meant;
      at += name.size();
      is_named = true;
      break;
    }
    if (!is_named) text += words[at++];
  }
  return text;
}

std::string escape_xml(std::string_view text, char quote) {
  std::string words;
  for (const char c : text) {
    if (c == '&') {
      words += "&amp;";
    } else if (c == '<') {
      words += "&lt;";
    } else if (c == quote) {
      words += quote == '"' ? "&quot;" : "&apos;";
    } else {
      words += c;
    }
  }
  return words;
}

}  // namespace tessera::edit
