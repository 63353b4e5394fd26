#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <functional>
#include <set>

#include "scenes/formats/x3d/document/x3d_document.h"
#include "scenes/formats/x3d/document/x3d_tree.h"
#include "scenes/import/decimal.h"

namespace tessera {
namespace {

constexpr size_t kMostShown = 40;  ///< of a word that an error or a warning tells

bool is_space(char c) { return c == ' ' || c == ',' || c == '\t' || c == '\n' || c == '\r'; }
bool is_mark(char c) { return c == '[' || c == ']' || c == '{' || c == '}' || c == '"'; }

bool is_letter(char c) {
  return (c >= 'a' && c <= 'z') || (c >= 'A' && c <= 'Z') || c == '_' ||
         static_cast<unsigned char>(c) >= 0x80;
}

bool is_bool(std::string_view word) {
  return word == "TRUE" || word == "FALSE" || word == "true" || word == "false";
}

/// Whether it is a number that is not finite, such as "nan", which begins as a name does.
bool is_endless(std::string_view word) {
  const char* const end = word.data() + word.size();
  double value = 0;
  const auto [stop, problem] = read_decimal(word.data(), end, value);
  return stop == end && problem == std::errc() && !std::isfinite(value);
}

/// Where the string ends whose opening quote is at `at`: behind the closing one, or npos.
size_t end_of_string(std::string_view text, size_t at) {
  for (++at; at < text.size(); ++at) {
    if (text[at] == '\\')
      ++at;
    else if (text[at] == '"')
      return at + 1;
  }
  return std::string_view::npos;
}

/// Comments become spaces, so that every place stays what it is.
void blank_comments(std::string& text) {
  for (size_t at = 0; at < text.size();) {
    if (text[at] == '"') {
      at = std::min(end_of_string(text, at), text.size());
    } else if (text[at] == '#') {
      for (; at < text.size() && text[at] != '\n' && text[at] != '\r'; ++at) text[at] = ' ';
    } else {
      ++at;
    }
  }
}

}  // namespace

/// Turns the classic encoding (ISO/IEC 19776-2) and VRML97's, which is nearly the same, into nodes.
/// What a field's value is shows in how it begins: a name begins a node, all else is a value.
class X3dClassicReader {
 public:
  X3dClassicReader(std::string_view text, const std::string& name, const X3dPrototypeFinder& find)
      : document_(text, name, true), tree_(document_, find) {}

  X3dDocument read() {
    read_header();
    blank_comments(document_.text_);
    X3dNode& scene = tree_.add("Scene", 0, 0);
    document_.scene_ = &scene;
    while (!at_end()) read_statement(scene, "children", 0);
    tree_.end();
    return std::move(document_);
  }

 private:
  struct Token {
    std::string_view text;  ///< a word, a mark or a string with its quotes; empty: the end
    size_t offset = 0;
    bool is_string() const { return text.starts_with('"'); }
    bool is(std::string_view other) const { return text == other; }
    bool is_name() const { return !text.empty() && is_letter(text[0]) && !is_bool(text); }
    /// Whether it is a string, a word or a number, and not the end or a bracket.
    bool is_value() const { return is_string() || (!text.empty() && !is_mark(text[0])); }
  };

  void read_header() {
    const std::string_view text = document_.text_;
    const std::string_view line = text.substr(0, text.find_first_of("\r\n"));
    if (line.starts_with("#VRML V1"))
      throw document_.error(0, "VRML 1.0, a different language", "VRML 2.0 (VRML97) or X3D");
    if (line.starts_with("#VRML V2"))
      document_.version_ = 20;
    else if (line.starts_with("#X3D V") && line.size() >= 9 && (line[6] == '3' || line[6] == '4') &&
             line[7] == '.' && line[8] >= '0' && line[8] <= '9')
      document_.version_ = (line[6] - '0') * 10 + (line[8] - '0');
    else if (line.starts_with("#X3D") || line.starts_with("#VRML"))
      document_.remarks_.push_back({0, fmt::format("'{}' is read as X3D 3.3", line.substr(0, 40))});
    else
      throw document_.error(0, "a file that does not say what it is",
                            "'#X3D V3.x utf8', '#VRML V2.0 utf8' or XML");
  }

  bool at_end() { return peek().text.empty(); }

  /// The token at `at` or behind it.
  Token token_from(size_t at) const {
    const std::string_view text = document_.text_;
    while (at < text.size() && is_space(text[at])) ++at;
    if (at == text.size()) return {text.substr(at), at};
    size_t end = at + 1;
    if (text[at] == '"') {
      end = end_of_string(text, at);
      if (end == std::string_view::npos)
        throw document_.error(at, "a string without an end", "a closing quote");
    } else if (!is_mark(text[at])) {
      while (end < text.size() && !is_space(text[end]) && !is_mark(text[end])) ++end;
    }
    return {text.substr(at, end - at), at};
  }

  Token peek() {
    if (!peeked_) next_ = token_from(at_);
    peeked_ = true;
    return next_;
  }

  Token take() {
    const Token token = peek();
    at_ = token.offset + token.text.size();
    peeked_ = false;
    return token;
  }

  Error unexpected(const Token& token, std::string_view expected) const {
    const std::string_view start = token.text.substr(0, kMostShown);
    return document_.error(
        token.offset,
        token.text.empty() ? std::string("the end of the file") : fmt::format("'{}'", start),
        expected);
  }

  void expect(std::string_view mark) {
    const Token token = take();
    if (!token.is(mark)) throw unexpected(token, fmt::format("'{}'", mark));
  }

  std::string take_name(std::string_view what) {
    const Token token = take();
    if (!token.is_name()) throw unexpected(token, what);
    return std::string(token.text);
  }

  /// Whether a node begins there, as names do that a brace follows.
  bool begins_node(const Token& token) const {
    return token.is("DEF") || token.is("USE") ||
           (token.is_name() && token_from(token.offset + token.text.size()).is("{"));
  }

  void tell_of(size_t offset, std::string_view found, std::string_view expected) {
    document_.remarks_.push_back(
        {offset, std::string(found), std::string(expected), "it is left out"});
  }

  /// Takes a value that stands where none may. False where something else does.
  bool skip_stray_value() {
    const Token token = peek();
    if (!token.is_value()) return false;
    tell_of(take().offset, fmt::format("'{}'", token.text.substr(0, kMostShown)),
            "the name of a field or a node");
    return true;
  }

  /// What may stand beside nodes. False where a node or a field begins.
  bool read_aside(int depth) {
    const Token token = peek();
    if (token.is("PROTO")) {
      take();
      declare(depth + 1);
    } else if (token.is("EXTERNPROTO")) {
      declare_elsewhere();
    } else if (token.is("ROUTE") || token.is("IMPORT") || token.is("EXPORT")) {
      tree_.add(std::string(token.text), take().offset, 0);
      take();
      if (peek().is("TO") || peek().is("AS")) {
        take();
        take();
      }
    } else {
      return !token.is_name() && skip_stray_value();
    }
    return true;
  }

  void read_statement(X3dNode& parent, const std::string& container, int depth) {
    if (read_aside(depth)) return;
    const Token token = peek();
    if (token.is("PROFILE") || token.is("COMPONENT")) {
      take();
      take();
    } else if (token.is("META")) {
      take();
      const Token name = take(), content = take();
      if (name.is_string() && content.is_string())
        document_.metadata_[inside(name)] = inside(content);
      else
        tell_of(name.offset, "META without two strings", "a name and a content in quotes");
    } else if (token.is("UNIT")) {
      read_unit();
    } else {
      tree_.add_child(parent, container, read_node(depth + 1));
    }
  }

  static std::string inside(const Token& string) {
    return std::string(string.text.substr(1, string.text.size() - 2));
  }

  void read_unit() {
    take();
    const Token category = take();
    take();  // its name
    const Token factor = take();
    tree_.set_unit(category.text, factor.text, factor.offset);
  }

  X3dNode* read_node(int depth) {
    const Token token = take();
    if (token.is("USE")) {
      const Token name = take();
      if (!name.is_value()) throw unexpected(name, "the DEF name of a node");
      return tree_.use(std::string(name.text), {}, name.offset);
    }
    std::string def;
    Token type = token;
    if (token.is("DEF")) {
      const Token name = take();
      def = name.text;
      type = take();
      if (!name.is_value()) throw unexpected(token, "DEF, a name and a node");
    }
    if (!type.is_name()) throw unexpected(type, "a node");
    const X3dPrototype* prototype = tree_.prototype(std::string(type.text));
    if (prototype) return read_instance(*prototype, def, type, depth);
    // As in XML, where the element says so.
    const bool is_elsewhere = elsewhere_.contains(type.text);
    X3dNode& node =
        tree_.add(is_elsewhere ? "ProtoInstance" : std::string(type.text), type.offset, depth);
    tree_.begin(node, def);
    read_body(node, depth);
    tree_.finish(node);
    return &node;
  }

  X3dNode* read_instance(const X3dPrototype& prototype, const std::string& def, const Token& type,
                         int depth) {
    X3dNode given;
    given.offset = type.offset;
    tree_.check_depth(type.offset, depth);
    read_body(given, depth);
    X3dNode* node = tree_.instantiate(prototype, given);
    tree_.begin(*node, def);
    tree_.finish(*node);
    return node;
  }

  void read_body(X3dNode& node, int depth) {
    expect("{");
    while (!peek().is("}")) {
      if (read_aside(depth)) continue;
      if (read_interface(node, depth)) continue;
      const std::string name = take_name("a field, or '}'");
      read_value(node, name, depth);
    }
    take();
  }

  /// A field that a Script, a shader or a prototype declares. False where something else begins.
  bool read_interface(X3dNode& node, int depth) {
    constexpr std::array<std::string_view, 8> kAccess{
        "eventIn", "eventOut",     "inputOnly",      "outputOnly",
        "field",   "exposedField", "initializeOnly", "inputOutput"};
    const auto access = std::find(kAccess.begin(), kAccess.end(), peek().text);
    if (access == kAccess.end()) return false;
    take();
    take_name("the type of a field");
    const std::string name = take_name("the name of a field");
    const bool has_value = access - kAccess.begin() >= 4;
    if (has_value || peek().is("IS")) read_value(node, name, depth);
    return true;
  }

  /// The value of a field: nodes become children, all else is kept as text.
  void read_value(X3dNode& node, const std::string& name, int depth) {
    const Token first = peek();
    if (first.is("IS")) {
      take();
      node.is.push_back({name, take_name("a field of the prototype")});
    } else if (first.is("[")) {
      take();
      read_list(node, name, depth);
    } else if (begins_node(first)) {
      tree_.add_child(node, name, read_node(depth + 1));
    } else if (first.is("}")) {
      tell_of(first.offset, fmt::format("{} without a value", name), "one before '}'");
    } else {
      const Token last = skip_plain_value();
      add_field(node, name, first.offset, last.offset + last.text.size());
    }
  }

  void read_list(X3dNode& node, const std::string& name, int depth) {
    bool has_nodes = false;
    Token first{{}, peek().offset};
    size_t end = first.offset;
    for (Token token = peek(); !token.is("]"); token = peek()) {
      if (token.is_name() && read_aside(depth)) continue;
      if (begins_node(token)) {
        tree_.add_child(node, name, read_node(depth + 1));
        has_nodes = true;
        continue;
      }
      if (!token.is_value())
        throw unexpected(token, fmt::format("']' after the values of {}", name));
      if (first.text.empty()) first = token;
      end = token.offset + take().text.size();
    }
    take();
    if (!has_nodes)
      add_field(node, name, first.offset, end);
    else if (!first.text.empty())
      tell_of(first.offset, fmt::format("'{}' among nodes", first.text.substr(0, kMostShown)),
              "nodes only");
  }

  void add_field(X3dNode& node, const std::string& name, size_t begin, size_t end) {
    const std::string_view text = document_.text_;
    if (node.fields.size() < X3dTree::kMaxSearched && node.field(name))
      tree_.tell_of_second(name, describe(node), begin);
    node.fields.push_back({name, text.substr(begin, end - begin), begin});
  }

  /// One string or bool, or all numbers up to what is none. Returns the last token of it.
  Token skip_plain_value() {
    Token last = take();
    if (last.is_string() || is_bool(last.text)) return last;
    if (!last.is_value()) throw unexpected(last, "a value");
    const auto is_number = [](const Token& token) {
      return token.is_value() && !token.is_string() && !is_bool(token.text) &&
             (!token.is_name() || is_endless(token.text));
    };
    while (is_number(peek())) last = take();
    return last;
  }

  void skip_list() {
    expect("[");
    for (Token token = take(); !token.is("]"); token = take())
      if (token.text.empty()) throw unexpected(token, "']'");
  }

  void declare_elsewhere() {
    const size_t offset = take().offset;
    const std::string name = take_name("a name");
    skip_list();
    std::vector<std::string> urls;
    const auto add = [&](const Token& token) {
      if (token.is_string()) urls.push_back(inside(token));
    };
    if (!peek().is("[")) {
      add(skip_plain_value());
    } else {
      take();
      for (Token token = take(); !token.is("]"); token = take()) {
        if (token.text.empty()) throw unexpected(token, "']'");
        add(token);
      }
    }
    if (tree_.declare_elsewhere(name, urls, offset)) return;
    tree_.add("ExternProtoDeclare", offset, 0);
    elsewhere_.insert(name);
  }

  void declare(int depth) {
    tree_.check_depth(at_, depth);
    const std::string name = take_name("the name of a prototype");
    X3dPrototype made;
    tree_.begin_prototype();
    expect("[");
    while (!peek().is("]"))
      if (!read_interface(made.interface_node, depth) && !skip_stray_value())
        throw unexpected(peek(), "a field of the prototype, or ']'");
    take();
    expect("{");
    X3dNode holder;
    while (!peek().is("}")) {
      if (at_end()) throw unexpected(peek(), "'}'");
      read_statement(holder, "body", depth);
    }
    take();
    tree_.end_prototype();
    if (!holder.children.empty()) made.body = holder.children.front().node;
    tree_.declare(name, std::move(made));
  }

  X3dDocument document_;
  X3dTree tree_;
  std::set<std::string, std::less<>> elsewhere_;  ///< prototypes that are in other files
  size_t at_ = 0;
  Token next_;
  bool peeked_ = false;
};

X3dDocument X3dDocument::parse_classic(std::string_view text, const std::string& name,
                                       const X3dPrototypeFinder& find) {
  return X3dClassicReader(text, name, find).read();
}

}  // namespace tessera
