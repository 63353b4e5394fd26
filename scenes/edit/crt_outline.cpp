#include "scenes/edit/crt_outline.h"

#include <fmt/format.h>

#include <map>

#include "scenes/edit/crt_syntax.h"
#include "scenes/edit/crt_words.h"
#include "scenes/formats/crt/crt_lexer.h"

namespace tessera::edit {
namespace {

using P = CrtPart;

bool is_literal(P part) {
  return part == P::integer || part == P::real || part == P::text || part == P::boolean;
}

/// A function that makes no entity.
bool is_function(std::string_view name) {
  constexpr std::string_view kNames[] = {
      "rgb",   "rgba", "vec3", "sin",   "cos",    "tan",       "asin",  "acos",  "atan",
      "atan2", "exp",  "log",  "pow",   "sqrt",   "abs",       "floor", "ceil",  "round",
      "min",   "max",  "int",  "float", "length", "normalize", "dot",   "cross", "rand"};
  for (const std::string_view known : kNames)
    if (known == name) return true;
  return false;
}

/// Makes entities and fields of a script's tree. As deep as the tree is, which is bounded.
class CrtOutliner {
 public:
  CrtOutliner(std::string_view text, const SyntaxTree& tree)
      : text_(text), tree_(tree), variables_(crt_variables(text, tree)) {}

  std::vector<Entity> run() {
    Entity scene{.kind = EntityKind::scene, .type = "Script"};
    scene.range = scene.body = tree_[0].range;
    made_.push_back(std::move(scene));
    counts_.emplace_back();
    children(0, 0);
    return std::move(made_);
  }

 private:
  size_t add(int32_t i, size_t parent, EntityKind kind, std::string type, std::string name) {
    const SyntaxNode& node = tree_[i];
    Entity entity{.parent = static_cast<int>(parent), .kind = kind};
    const std::string label = name.empty() ? type : name;
    const int index = counts_[parent][label]++;
    const std::string& above = made_[parent].path;
    entity.path = (above.empty() ? "" : above + ".") + label;
    if (index > 0 || name.empty()) entity.path += fmt::format("[{}]", index);
    entity.type = std::move(type);
    entity.name = std::move(name);
    entity.range = node.range;
    entity.body = node.body;
    entity.syntax = static_cast<uint32_t>(i);
    made_.push_back(std::move(entity));
    counts_.emplace_back();
    return made_.size() - 1;
  }

  void children(int32_t i, size_t parent, int skipped = 0) {
    for (int32_t k = tree_[i].first_child; k >= 0; k = tree_[k].next)
      if (skipped-- <= 0) visit(k, parent, "", k);
  }

  /// `outer`: the statement that the node is the value of, whose range is the entity's.
  void visit(int32_t i, size_t parent, std::string name, int32_t outer) {
    const SyntaxNode& node = tree_[i];
    const std::string word(text_of(text_, node.name));
    switch (crt_part(node)) {
      case P::settings:
      case P::object:
        return object(i, add(outer, parent, kind_of(word), word, std::move(name)));
      case P::scene:
        return children(i, add(outer, parent, EntityKind::group, "Scene", ""));
      case P::group:
        return children(i,
                        with_body(i, add(outer, parent, EntityKind::group, word, std::move(name))));
      case P::macro:
        return children(
            i, with_body(i, add(outer, parent, EntityKind::macro, "Macro", std::move(name))));
      case P::loop:
      case P::branch:
        return children(i, add(outer, parent, EntityKind::group, word, ""), 1);
      case P::block:
        return children(i, parent);
      case P::assignment:
        return assignment(i, parent);
      case P::modifiers:
        return modifiers(i, parent, std::move(name), outer);
      case P::call:
        return call(i, parent, std::move(name), outer);
      case P::identifier:
        add(outer, parent, EntityKind::call, std::string(text_of(text_, node.range)),
            std::move(name));
        return;
      case P::list:
      case P::computed:
        return several(i, parent, std::move(name), outer);
      default:
        return;
    }
  }

  size_t with_body(int32_t i, size_t entity) {
    made_[entity].body = tree_[i].body;
    return entity;
  }

  static EntityKind kind_of(std::string_view word) {
    const CrtObjectWord* found = find_crt_word(word);
    return found ? found->kind : EntityKind::other;
  }

  void object(int32_t i, size_t entity) {
    made_[entity].body = tree_[i].body;
    made_[entity].syntax = static_cast<uint32_t>(i);
    const CrtObjectWord* word = find_crt_word(made_[entity].type);
    for (int32_t k = tree_[i].first_child; k >= 0; k = tree_[k].next) {
      const SyntaxNode& attribute = tree_[k];
      const std::string name(text_of(text_, attribute.name));
      const CrtAttributeWord* known = find_crt_attribute(word, name);
      Field field = known ? describe(*known) : Field{};
      field.name = name;
      add_field(entity, std::move(field), k, attribute.first_child);
      inner_objects(attribute.first_child, entity);
    }
  }

  /// Objects that stand in values: "material -> Material { ... }".
  void inner_objects(int32_t i, size_t entity) {
    if (i < 0) return;
    const P part = crt_part(tree_[i]);
    if (part == P::object || part == P::group) return visit(i, entity, "", i);
    for (int32_t k = tree_[i].first_child; k >= 0; k = tree_[k].next) inner_objects(k, entity);
  }

  void assignment(int32_t i, size_t parent) {
    const int32_t target = tree_[i].first_child;
    const int32_t value = target >= 0 ? tree_[target].next : -1;
    std::string name(text_of(text_, tree_[i].name));
    if (value >= 0 && makes_entity(value)) return visit(value, parent, std::move(name), i);
    const size_t entity = add(i, parent, EntityKind::variable, "variable", std::move(name));
    Field field;
    field.name = "value";
    if (value >= 0) add_field(entity, std::move(field), i, value);
  }

  bool makes_entity(int32_t i) const {
    const P part = crt_part(tree_[i]);
    if (part == P::object || part == P::group || part == P::macro) return true;
    if (part == P::call) return !is_function(text_of(text_, tree_[i].name));
    if (part == P::modifiers && tree_[i].first_child >= 0) return true;
    if (part != P::list && part != P::computed) return false;
    for (int32_t k = tree_[i].first_child; k >= 0; k = tree_[k].next)
      if (makes_entity(k)) return true;
    return false;
  }

  void several(int32_t i, size_t parent, std::string name, int32_t outer) {
    if (!makes_entity(i)) return;
    const bool is_list = crt_part(tree_[i]) == P::list;
    children(i, add(outer, parent, EntityKind::group, is_list ? "list" : "set operation",
                    std::move(name)));
  }

  void modifiers(int32_t i, size_t parent, std::string name, int32_t outer) {
    const int32_t base = tree_[i].first_child;
    if (base < 0) return;
    const size_t before = made_.size();
    visit(base, parent, std::move(name), outer);
    if (made_.size() == before) return;
    for (int32_t k = tree_[base].next; k >= 0; k = tree_[k].next) {
      const size_t step =
          add(k, before, EntityKind::step, std::string(text_of(text_, tree_[k].name)), "");
      Field field;
      field.name = "value";
      if (tree_[k].first_child >= 0) add_field(step, std::move(field), k, tree_[k].first_child);
    }
  }

  void call(int32_t i, size_t parent, std::string name, int32_t outer) {
    const std::string word(text_of(text_, tree_[i].name));
    if (is_function(word)) return;
    const size_t entity = add(outer, parent, EntityKind::call, word, std::move(name));
    int index = 0;
    for (int32_t k = tree_[i].first_child; k >= 0; k = tree_[k].next) {
      Field field;
      field.name = fmt::format("[{}]", index++);
      add_field(entity, std::move(field), k, k);
      inner_objects(k, entity);
    }
  }

  /// `holder`: the attribute or statement; `value`: the node of its value, -1: none.
  void add_field(size_t entity, Field field, int32_t holder, int32_t value) {
    field.is_present = true;
    field.range = tree_[holder].range;
    field.value = value >= 0 ? tree_[value].range : tree_[holder].value;
    field.text = text_of(text_, field.value);
    field.syntax = value;
    if (value < 0) {
      field.locked = "a value is missing";
    } else {
      value_of(field, value);
    }
    made_[entity].fields.push_back(std::move(field));
  }

  void value_of(Field& field, int32_t value) {
    const SyntaxNode& node = tree_[value];
    const P part = crt_part(node);
    if (part == P::object || part == P::group) {
      field.kind = ValueKind::reference;
      field.locked = "an object that is written in place: set its own fields";
      return;
    }
    if (part == P::list) {
      field.kind = ValueKind::list;
      field.locked = "a list: set its items";
      return;
    }
    if (part == P::identifier && field.kind == ValueKind::reference) return;
    const int32_t literal = crt_literal(text_, tree_, variables_, value);
    if (literal < 0) {
      if (part != P::identifier || !refers(value)) return computed(field, node);
      field.kind = ValueKind::reference;
      return;
    }
    if (literal != value) {
      field.uses = variables_[text_of(text_, node.range)].uses;
      field.literal = tree_[literal].range;
    }
    literal_of(field, literal);
  }

  /// Whether the name stands for a material, camera, texture...
  bool refers(int32_t identifier) {
    const auto found = variables_.find(text_of(text_, tree_[identifier].range));
    return found != variables_.end() && found->second.value >= 0 &&
           crt_part(tree_[found->second.value]) == P::object;
  }

  static void computed(Field& field, const SyntaxNode&) {
    field.kind = ValueKind::expression;
    field.locked = fmt::format("computed: {}", field.text.substr(0, 200));
  }

  void literal_of(Field& field, int32_t literal) {
    const SyntaxNode& node = tree_[literal];
    const bool is_known = !field.help.empty() || !field.fallback.empty();
    if (is_crt_vector(text_, node)) {
      field.kind = text_of(text_, node.name) == "vec3" ? ValueKind::vector : ValueKind::color;
      field.text.clear();
      for (int32_t k = node.first_child; k >= 0; k = tree_[k].next) {
        if (!field.text.empty()) field.text += ' ';
        const int32_t part = crt_literal(text_, tree_, variables_, k);
        field.text += text_of(text_, tree_[part >= 0 ? part : k].range);
      }
      return;
    }
    field.text = text_of(text_, node.range);
    const P part = crt_part(node);
    if (part == P::text) field.text = unescape_crt(std::string_view(field.text));
    if (part == P::boolean) field.choices = {"false", "true"};
    if (is_known && field.kind != ValueKind::color && field.kind != ValueKind::vector) return;
    field.kind = part == P::text                    ? ValueKind::text
                 : part == P::boolean               ? ValueKind::boolean
                 : field.kind == ValueKind::integer ? ValueKind::integer
                                                    : ValueKind::number;
  }

  std::string_view text_;
  const SyntaxTree& tree_;
  CrtVariables variables_;
  std::vector<Entity> made_;
  std::vector<std::map<std::string, int>> counts_;
};

}  // namespace

bool is_crt_vector(std::string_view text, const SyntaxNode& node) {
  if (crt_part(node) != P::call) return false;
  const std::string_view name = text_of(text, node.name);
  return name == "vec3" || name == "rgb";
}

CrtVariables crt_variables(std::string_view text, const SyntaxTree& tree) {
  CrtVariables variables;
  for (int32_t i = 1; i < tree.size(); ++i) {
    const SyntaxNode& node = tree[i];
    const P part = crt_part(node);
    if (part == P::parameter) ++variables[text_of(text, node.range)].assigned;
    if (part == P::call && !node.name.is_empty()) ++variables[text_of(text, node.name)].uses;
    if (part != P::identifier) continue;
    CrtVariable& variable = variables[text_of(text, node.range)];
    const SyntaxNode& above = tree[node.parent];
    if (crt_part(above) == P::assignment && above.first_child == i) {
      ++variable.assigned;
      variable.value = node.next;
      variable.is_top = above.parent == 0;
    } else {
      ++variable.uses;
    }
  }
  return variables;
}

int32_t crt_literal(std::string_view text, const SyntaxTree& tree, const CrtVariables& variables,
                    int32_t node) {
  constexpr int kMostNames = 16;
  for (int i = 0; i < kMostNames && node >= 0; ++i) {
    const P part = crt_part(tree[node]);
    if (is_literal(part) || is_crt_vector(text, tree[node])) return node;
    if (part != P::identifier) return -1;
    const auto found = variables.find(text_of(text, tree[node].range));
    if (found == variables.end() || found->second.assigned != 1 || !found->second.is_top) return -1;
    node = found->second.value;
  }
  return -1;
}

std::vector<Entity> crt_entities(std::string_view text, const SyntaxTree& tree) {
  return CrtOutliner(text, tree).run();
}

std::vector<Field> all_crt_fields(const Outline& outline, int entity) {
  const Entity& asked = outline.entities()[static_cast<size_t>(entity)];
  const CrtObjectWord* word = find_crt_word(asked.type);
  if (!word) return asked.fields;
  std::vector<Field> all;
  for (const CrtAttributeWord& attribute : word->attributes) {
    bool is_there = false;
    for (const Field& field : asked.fields) {
      if (field.name != attribute.name) continue;
      all.push_back(field);
      is_there = true;
    }
    if (!is_there) all.push_back(describe(attribute));
  }
  for (const Field& field : asked.fields)
    if (!find_crt_attribute(word, field.name)) all.push_back(field);
  return all;
}

}  // namespace tessera::edit
