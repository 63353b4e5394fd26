#include "scenes/edit/crt_edit.h"

#include <fmt/format.h>

#include <algorithm>

#include "base/error.h"
#include "scenes/edit/crt_literals.h"
#include "scenes/edit/crt_outline.h"
#include "scenes/edit/crt_syntax.h"
#include "scenes/edit/crt_words.h"
#include "scenes/edit/layout.h"
#include "scenes/edit/literal.h"
#include "scenes/edit/message_edit.h"
#include "scenes/edit/message_outline.h"

namespace tessera::edit {
namespace {

using P = CrtPart;

Layout layout_of(const Outline& outline) { return {outline.text(), "--"}; }

Change refused(Refusal refusal, SourceRange range = {}) {
  if (refusal.range.is_empty()) refusal.range = range;
  Change change;
  change.refusal = std::move(refusal);
  return change;
}

/// Sets what stands at a node of the tree.
class CrtSetter {
 public:
  CrtSetter(const Outline& outline, const Field& field)
      : outline_(outline),
        tree_(outline.tree()),
        field_(field),
        variables_(crt_variables(outline.text(), outline.tree())) {}

  Change set(int32_t node, std::string_view value) {
    if (crt_part(tree_[node]) == P::identifier && field_.kind == ValueKind::reference) {
      if (auto refusal = check_crt_reference(outline_, value))
        return refused(*refusal, tree_[node].range);
      replace(node, std::string(trimmed(value)));
      return change_;
    }
    const int32_t literal = crt_literal(outline_.text(), tree_, variables_, node);
    if (literal < 0)
      return refuse(fmt::format("computed: {}", word(node)), "a literal in the text",
                    tree_[node].range);
    count_uses(node, literal);
    if (is_crt_vector(outline_.text(), tree_[literal])) return vector(literal, value);
    if (auto refusal = check_scalar(literal, value)) return refused(*refusal, tree_[literal].range);
    scalar(literal, value);
    return change_;
  }

 private:
  std::string_view word(int32_t node) const { return text_of(outline_.text(), tree_[node].range); }

  void count_uses(int32_t node, int32_t literal) {
    if (node == literal) return;
    change_.changed = std::max(change_.changed, variables_[word(node)].uses);
  }

  std::optional<Refusal> check_scalar(int32_t literal, std::string_view value) const {
    const P part = crt_part(tree_[literal]);
    Field field = field_;
    if (part == P::text) {
      if (field.kind != ValueKind::choice && field.kind != ValueKind::file)
        field.kind = ValueKind::text;
    } else if (part == P::boolean) {
      field.kind = ValueKind::boolean;
      field.choices = {"false", "true"};
    } else if (field.kind != ValueKind::integer) {
      field.kind = ValueKind::number;
    }
    return check_value(field, value);
  }

  void scalar(int32_t literal, std::string_view value) {
    const std::string_view old = word(literal);
    switch (crt_part(tree_[literal])) {
      case P::text:
        if (unquote(old) != value) replace(literal, quote(value, '"', false));
        return;
      case P::boolean:
        return replace(literal, std::string(trimmed(value)));
      default:
        return replace(literal, crt_number(trimmed(value), old));
    }
  }

  Change vector(int32_t call, std::string_view value) {
    if (auto refusal = check_crt_parts(field_, value)) return refused(*refusal, tree_[call].range);
    const auto parts = typed_parts(value);
    size_t i = 0;
    for (int32_t k = tree_[call].first_child; k >= 0 && i < parts.size(); k = tree_[k].next, ++i) {
      const int32_t literal = crt_literal(outline_.text(), tree_, variables_, k);
      if (literal >= 0 && word(literal) == parts[i]) continue;
      if (literal < 0 && word(k) == parts[i]) continue;
      const P part = literal >= 0 ? crt_part(tree_[literal]) : P::computed;
      if (part != P::integer && part != P::real)
        return refuse(fmt::format("computed: {}", word(k)), "a number in the text", tree_[k].range);
      count_uses(k, literal);
      replace(literal, crt_number(parts[i], word(literal)));
    }
    if (i < parts.size())
      return refuse("a vector of less than 3 parts", "vec3(x, y, z)", tree_[call].range);
    std::sort(change_.edits.begin(), change_.edits.end(),
              [](const TextEdit& a, const TextEdit& b) { return a.range.begin < b.range.begin; });
    const auto last =
        std::unique(change_.edits.begin(), change_.edits.end(),
                    [](const TextEdit& a, const TextEdit& b) { return a.range == b.range; });
    if (last != change_.edits.end())
      return refuse("one variable for several parts", "a literal for each", tree_[call].range);
    return change_;
  }

  void replace(int32_t node, std::string text) {
    if (word(node) != text) change_.edits.push_back({tree_[node].range, std::move(text)});
  }

  const Outline& outline_;
  const SyntaxTree& tree_;
  const Field& field_;
  CrtVariables variables_;
  Change change_;
};

/// The name of a new attribute up to its arrow, which stands below those of its siblings where they
/// are aligned.
std::string arrow(const Outline& outline, int32_t object, std::string_view name) {
  const SyntaxTree& tree = outline.tree();
  size_t column = 0, count = 0, shortest = SIZE_MAX, longest = 0;
  bool is_aligned = true;
  for (int32_t k = tree[object].first_child; k >= 0; k = tree[k].next) {
    const SyntaxNode& node = tree[k];
    const size_t at = outline.text().find("->", node.name.end);
    if (at == std::string::npos) continue;
    const size_t own = at - node.name.begin;
    is_aligned &= (count == 0 || own == column) && begins_line(outline.text(), node.range.begin);
    column = own;
    shortest = std::min<size_t>(shortest, node.name.size());
    longest = std::max<size_t>(longest, node.name.size());
    ++count;
  }
  std::string made(name);
  if (is_aligned && count > 1 && shortest < longest && made.size() + 1 < column)
    made.resize(column - 1, ' ');
  return made + " -> ";
}

Change insert_attribute(const Outline& outline, const Entity& entity, const CrtObjectWord& word,
                        const Field& field, std::string_view value) {
  const SyntaxTree& tree = outline.tree();
  const auto object = static_cast<int32_t>(entity.syntax);
  if (auto refusal = check_new_crt(outline, field, value)) return refused(*refusal, entity.range);
  const std::string made = arrow(outline, object, field.name) + new_crt_literal(field, value);
  const auto index_of = [&](std::string_view name) {
    for (size_t i = 0; i < word.attributes.size(); ++i)
      if (word.attributes[i].name == name) return static_cast<int>(i);
    return -1;
  };
  int32_t sibling = -1;
  for (int32_t k = tree[object].first_child; k >= 0; k = tree[k].next)
    if (index_of(text_of(outline.text(), tree[k].name)) < index_of(field.name)) sibling = k;
  const Layout layout = layout_of(outline);
  Change change;
  if (sibling >= 0) {
    change.edits.push_back(layout.behind(tree[sibling].range, made));
  } else if (tree[object].first_child >= 0) {
    change.edits.push_back(layout.before(tree[tree[object].first_child].range, made));
  } else {
    change.edits.push_back(layout.inside(tree[object].body, entity.range.begin, made,
                                         indentation_unit(outline.text(), "    ")));
  }
  return change;
}

}  // namespace

Change set_crt_field(const Outline& outline, int entity, std::string_view name,
                     std::string_view value) {
  const Entity& asked = outline.entities()[static_cast<size_t>(entity)];
  const Field* field = nullptr;
  for (const Field& one : asked.fields)
    if (one.name == name) field = &one;  // the last of a name counts
  if (field && field->syntax >= 0 && field->locked.empty())
    return CrtSetter(outline, *field).set(field->syntax, value);
  if (field) return refuse(field->text, field->locked, field->value);
  const CrtObjectWord* word = find_crt_word(asked.type);
  const CrtAttributeWord* attribute = find_crt_attribute(word, name);
  if (!attribute) {
    std::vector<std::string> names;
    if (word)
      for (const CrtAttributeWord& one : word->attributes) names.emplace_back(one.name);
    return refuse(fmt::format("{} has no attribute '{}'", asked.type, name),
                  fmt::format("one of {}{}", fmt::join(names, ", "), suggestion(name, names)));
  }
  return insert_attribute(outline, asked, *word, describe(*attribute), value);
}

Change reset_crt_field(const Outline& outline, int entity, std::string_view name) {
  Change change;
  for (const Field& field : outline.entities()[static_cast<size_t>(entity)].fields)
    if (field.name == name) change.edits.push_back(layout_of(outline).without(field.range));
  return change;
}

Change remove_crt(const Outline& outline, int entity) {
  if (entity == 0) return refuse("the script itself", "a part of it");
  const Entity& asked = outline.entities()[static_cast<size_t>(entity)];
  const SyntaxTree& tree = outline.tree();
  if (!asked.name.empty()) {
    const CrtVariables variables = crt_variables(outline.text(), tree);
    const auto found = variables.find(asked.name);
    if (found != variables.end() && found->second.uses > 0)
      return refuse(fmt::format("'{}' is used {} times", asked.name, found->second.uses),
                    "what is not used", asked.range);
  }
  // Of a list or of modifiers, a comma goes with it.
  int32_t node = tree.node_at(asked.range.begin);
  while (node > 0 && tree[node].range != asked.range) node = tree[node].parent;
  const int32_t above = node > 0 ? tree[node].parent : -1;
  Change change;
  if (above >= 0 && crt_part(tree[above]) == P::attribute)
    return refuse("the value of an attribute", "an entity of its own", asked.range);
  const bool in_list =
      above >= 0 && (crt_part(tree[above]) == P::list || asked.kind == EntityKind::step);
  if (!in_list) {
    if (above >= 0 && (crt_part(tree[above]) == P::computed || crt_part(tree[above]) == P::call))
      return refuse("a part of an expression", "an entity of its own", asked.range);
    change.edits.push_back(layout_of(outline).without(asked.range));
    return change;
  }
  const bool is_step = asked.kind == EntityKind::step;
  int32_t previous = -1;
  for (int32_t k = tree[above].first_child; k != node; k = tree[k].next) previous = k;
  if (is_step && previous == tree[above].first_child) previous = -1;
  if (tree[node].next >= 0) {
    change.edits.push_back({{asked.range.begin, tree[tree[node].next].range.begin}, ""});
  } else if (previous >= 0) {
    change.edits.push_back({{tree[previous].range.end, asked.range.end}, ""});
  } else if (is_step) {
    change.edits.push_back({{tree[tree[above].first_child].range.end, tree[above].range.end}, ""});
  } else {
    change.edits.push_back({asked.range, ""});
  }
  return change;
}

Change duplicate_crt(const Outline& outline, int entity) {
  const Entity& asked = outline.entities()[static_cast<size_t>(entity)];
  const SyntaxTree& tree = outline.tree();
  int32_t node = tree.node_at(asked.range.begin);
  while (node > 0 && tree[node].range != asked.range) node = tree[node].parent;
  const P above = node > 0 ? crt_part(tree[tree[node].parent]) : P::script;
  const bool is_statement = above == P::script || above == P::scene || above == P::group ||
                            above == P::macro || above == P::loop || above == P::branch ||
                            above == P::block;
  if (node <= 0 || asked.kind == EntityKind::settings || (!is_statement && above != P::list))
    return refuse("a part of something else", "an entity of its own", asked.range);
  std::string copy(text_of(outline.text(), asked.range));
  if (!asked.name.empty()) {
    std::vector<std::string> names;
    for (const auto& [name, variable] : crt_variables(outline.text(), tree))
      names.emplace_back(name);
    copy.replace(0, asked.name.size(), free_name(asked.name, names, ""));
  }
  Change change;
  if (above == P::list)
    change.edits.push_back({{asked.range.end, asked.range.end}, ", " + copy});
  else
    change.edits.push_back(layout_of(outline).behind(asked.range, copy));
  return change;
}

}  // namespace tessera::edit
