#include "scenes/edit/statement_edit.h"

#include <fmt/format.h>

#include <algorithm>

#include "base/error.h"
#include "scenes/edit/layout.h"
#include "scenes/edit/literal.h"
#include "scenes/edit/message_edit.h"
#include "scenes/edit/message_vocabulary.h"
#include "scenes/edit/word_vocabulary.h"

namespace tessera::edit {
namespace {

struct StatementWord {
  std::string_view name;
  ValueKind kind;
  std::string_view fallback, help;
  FieldLimits limits;
};

constexpr FieldLimits kAny{};
constexpr FieldLimits kShare{.least = 0, .most = 1};
constexpr FieldLimits kNotNegative{.least = 0, .most = {}};

/// In the order in which they are written.
constexpr StatementWord kMtlWords[] = {
    {"Ka", ValueKind::color, "0 0 0", "ambient colour", kNotNegative},
    {"Kd", ValueKind::color, "0.8 0.8 0.8", "diffuse colour", kNotNegative},
    {"Ks", ValueKind::color, "0 0 0", "specular colour", kNotNegative},
    {"Ke", ValueKind::color, "0 0 0", "emission", kNotNegative},
    {"Tf", ValueKind::color, "1 1 1", "what is let through", kNotNegative},
    {"Ns", ValueKind::number, "0", "exponent of highlights", kNotNegative},
    {"Ni", ValueKind::number, "1", "refractive index", kNotNegative},
    {"d", ValueKind::number, "1", "opacity", kShare},
    {"Tr", ValueKind::number, "0", "transparency", kShare},
    {"illum", ValueKind::integer, "2", "illumination model", {.least = 0, .most = 10}},
    {"Pr", ValueKind::number, "", "roughness", kShare},
    {"Pm", ValueKind::number, "", "metallic", kShare},
    {"Pc", ValueKind::number, "", "clearcoat", kShare},
    {"map_Ka", ValueKind::file, "", "ambient picture", kAny},
    {"map_Kd", ValueKind::file, "", "diffuse picture", kAny},
    {"map_Ks", ValueKind::file, "", "specular picture", kAny},
    {"map_Ke", ValueKind::file, "", "emission picture", kAny},
    {"map_d", ValueKind::file, "", "opacity picture", kAny},
    {"map_Bump", ValueKind::file, "", "picture of heights", kAny},
    {"bump", ValueKind::file, "", "picture of heights", kAny},
    {"norm", ValueKind::file, "", "picture of normals", kAny}};

/// The statement that begins a material, and its help.
constexpr std::pair<std::string_view, std::string_view> kNewMaterial{
    "newmtl", "begins a material of that name"};
/// The statements of .obj that are read, each with its help.
constexpr std::pair<std::string_view, std::string_view> kObjWords[] = {
    {"v", "a vertex: x y z, and perhaps a weight or r g b"},
    {"vt", "a texture coordinate: u v"},
    {"vn", "a normal: x y z"},
    {"f", "a face: its corners, each vertex/texture/normal, counted from 1"},
    {"o", "begins an object of that name"},
    {"g", "begins a group of these names"},
    {"s", "a smoothing group, or off"},
    {"usemtl", "the material of the faces that follow"},
    {"mtllib", "a file of materials"}};

int index_of(std::string_view name) {
  for (size_t i = 0; i < std::size(kMtlWords); ++i)
    if (kMtlWords[i].name == name) return static_cast<int>(i);
  return -1;
}

Field describe_statement(std::string_view name) {
  Field field;
  field.name = name;
  field.is_present = false;
  if (const int i = index_of(name); i >= 0) {
    const StatementWord& word = kMtlWords[i];
    field.kind = word.kind;
    field.fallback = field.text = word.fallback;
    field.help = word.help;
    field.limits = word.limits;
  }
  return field;
}

std::optional<Refusal> check_statement(const Field& field, std::string_view value) {
  if (value.find_first_of("\r\n#") != std::string_view::npos)
    return Refusal{"a line end or '#'", "one line", {}};
  if (field.kind != ValueKind::color) {
    if (trimmed(value).empty()) return Refusal{"nothing", "a value", {}};
    return check_value(field, value);
  }
  const auto parts = typed_parts(value);
  if (parts.size() != 3) return Refusal{fmt::format("'{}'", value), "3 numbers between blanks", {}};
  Field part;
  part.kind = ValueKind::number;
  part.limits = field.limits;
  for (const std::string& one : parts)
    if (auto refusal = check_value(part, one)) return refusal;
  return {};
}

std::string written(const Field& field, std::string_view value) {
  if (field.kind == ValueKind::number || field.kind == ValueKind::integer)
    return strict_number(trimmed(value));
  if (field.kind != ValueKind::color) return std::string(trimmed(value));
  std::string words;
  for (const std::string& part : typed_parts(value))
    words += (words.empty() ? "" : " ") + strict_number(part);
  return words;
}

/// The value at `range` word by word, so that only what differs is replaced.
std::vector<TextEdit> replace_words(std::string_view text, SourceRange range,
                                    std::string_view value) {
  std::vector<TextEdit> edits;
  const auto parts = typed_parts(value);
  uint32_t at = range.begin;
  for (const std::string& part : parts) {
    while (at < range.end && is_blank(text[at])) ++at;
    const uint32_t begin = at;
    while (at < range.end && !is_blank(text[at])) ++at;
    if (text_of(text, {begin, at}) != part) edits.push_back({{begin, at}, strict_number(part)});
  }
  return edits;
}

}  // namespace

SyntaxTree parse_statements(std::string_view text, bool is_mtl) {
  SyntaxTree tree;
  const uint32_t mark = byte_order_mark_size(text);
  const SourceRange all{mark, static_cast<uint32_t>(text.size())};
  tree.add(-1, {.kind = SyntaxKind::block, .range = all, .value = all, .body = all});
  int32_t holder = 0;
  for (uint32_t at = mark; at < text.size(); at = next_line(text, at)) {
    uint32_t begin = at, end = line_end(text, at);
    const size_t comment = text.substr(begin, end - begin).find('#');
    if (comment != std::string_view::npos) end = begin + static_cast<uint32_t>(comment);
    while (begin < end && is_blank(text[begin])) ++begin;
    while (end > begin && is_blank(text[end - 1])) --end;
    uint32_t name_end = begin;
    while (name_end < end && !is_blank(text[name_end])) ++name_end;
    if (name_end == begin) continue;
    uint32_t value = name_end;
    while (value < end && is_blank(text[value])) ++value;
    const std::string_view name = text.substr(begin, name_end - begin);
    const bool is_named = is_mtl
                              ? name == "newmtl"
                              : name == "o" || name == "g" || name == "usemtl" || name == "mtllib";
    SyntaxNode node{.range = {begin, end}, .name = {begin, name_end}};
    node.value = node.body = {value, end};
    if (is_named) {
      node.kind = SyntaxKind::block;
      holder = tree.add(0, node);
      SyntaxNode own = node;
      own.kind = SyntaxKind::scalar;
      tree.add(holder, own);
    } else if (is_mtl && holder > 0) {
      node.kind = SyntaxKind::scalar;
      tree.add(holder, node);
      SyntaxNode& material = tree[holder];
      material.range.end = material.value.end = material.body.end = end;
    }
  }
  return tree;
}

std::vector<Entity> statement_entities(std::string_view text, const SyntaxTree& tree) {
  Entity scene{.kind = EntityKind::scene};
  scene.range = scene.body = tree[0].range;
  std::vector<Entity> made{std::move(scene)};
  int count = 0;
  for (int32_t i = tree[0].first_child; i >= 0; i = tree[i].next) {
    Entity entity{.parent = 0};
    entity.type = text_of(text, tree[i].name);
    const bool is_part = entity.type == "o" || entity.type == "g";
    entity.kind = entity.type == "newmtl" ? EntityKind::material
                  : is_part               ? EntityKind::object
                                          : EntityKind::other;
    entity.path = fmt::format("{}[{}]", entity.type, count++);
    entity.range = tree[i].range;
    entity.body = tree[i].body;
    entity.syntax = static_cast<uint32_t>(i);
    for (int32_t k = tree[i].first_child; k >= 0; k = tree[k].next) {
      const bool is_first = k == tree[i].first_child;
      Field field = describe_statement(is_first ? "name" : text_of(text, tree[k].name));
      if (is_first && entity.type == "usemtl") field.kind = ValueKind::reference;
      field.is_present = true;
      field.range = tree[k].range;
      field.value = tree[k].value;
      field.syntax = k;
      field.text = text_of(text, tree[k].value);
      if (is_first) entity.name = field.text;
      if (field.kind == ValueKind::file && field.text.starts_with('-'))
        field.locked = "a picture with options";
      entity.fields.push_back(std::move(field));
    }
    made.push_back(std::move(entity));
  }
  return made;
}

std::vector<Field> all_statement_fields(const Outline& outline, int entity) {
  const Entity& asked = outline.entities()[static_cast<size_t>(entity)];
  std::vector<Field> all = asked.fields;
  if (asked.kind != EntityKind::material) return all;
  for (const StatementWord& word : kMtlWords)
    if (std::none_of(asked.fields.begin(), asked.fields.end(),
                     [&](const Field& field) { return field.name == word.name; }))
      all.push_back(describe_statement(word.name));
  return all;
}

Completions statement_completions(const Outline& outline, size_t offset) {
  const std::string_view text = outline.text();
  const SyntaxTree& tree = outline.tree();
  Completions made{word_around(text, offset), {}};
  auto begin = static_cast<uint32_t>(std::min(offset, text.size()));
  while (begin > 0 && text[begin - 1] != '\n' && text[begin - 1] != '\r') --begin;
  while (begin < made.replaced.begin && is_blank(text[begin])) ++begin;
  const auto add = [&](std::string_view name, std::string detail, std::string_view help) {
    made.items.push_back(
        {std::string(name), fmt::format("{} ", name), std::move(detail), std::string(help)});
  };
  if (begin < made.replaced.begin) {  // behind a word, where names have dots and slashes
    while (made.replaced.begin > begin && !is_blank(text[made.replaced.begin - 1]))
      --made.replaced.begin;
    while (made.replaced.end < text.size() && !is_space(text[made.replaced.end]))
      ++made.replaced.end;
    const SourceRange first = word_around(text, begin);
    const std::string_view name = text_of(text, first);
    if (outline.language() == Language::mtl && describe_statement(name).kind == ValueKind::file) {
      made.files = Completions::Files::picture;
    } else if (name == "usemtl") {
      for (const Entity& entity : outline.entities())
        if (entity.type == "usemtl" && entity.range.begin != first.begin &&
            std::ranges::find(made.items, entity.name, &Completion::label) == made.items.end())
          made.items.push_back({entity.name, entity.name, "material", ""});
    }
    return made;
  }
  if (outline.language() == Language::obj) {
    for (const auto& [name, help] : kObjWords) add(name, "", help);
    return made;
  }
  add(kNewMaterial.first, "", kNewMaterial.second);
  const Entity* material = nullptr;
  for (const Entity& entity : outline.entities())
    if (entity.kind == EntityKind::material && entity.range.begin < begin) material = &entity;
  if (!material) return made;
  for (const StatementWord& word : kMtlWords) {
    const bool is_there = std::ranges::any_of(material->fields, [&](const Field& field) {
      return field.name == word.name && tree[field.syntax].name != made.replaced;
    });
    if (!is_there) add(word.name, detail_of(describe_statement(word.name)), word.help);
  }
  return made;
}

std::optional<Hover> statement_hover(const Outline& outline, size_t offset) {
  const std::string_view text = outline.text();
  const SourceRange word = word_around(text, offset);
  uint32_t line = word.begin;
  while (line > 0 && is_blank(text[line - 1])) --line;
  const bool is_first = line == 0 || text[line - 1] == '\n' || text[line - 1] == '\r';
  const std::string_view name = text_of(text, word);
  if (!is_first || name.empty()) return {};
  if (outline.language() == Language::obj) {
    for (const auto& [known, help] : kObjWords)
      if (known == name) return Hover{word, std::string(name), "", std::string(help)};
    return {};
  }
  if (name == kNewMaterial.first)
    return Hover{word, std::string(name), "", std::string(kNewMaterial.second)};
  if (index_of(name) < 0) return {};
  const Field field = describe_statement(name);
  return Hover{word, std::string(name), detail_of(field), field.help};
}

Change set_statement(const Outline& outline, int entity, std::string_view name,
                     std::string_view value) {
  const Entity& asked = outline.entities()[static_cast<size_t>(entity)];
  Change change;
  const Field* there = nullptr;
  for (const Field& field : asked.fields)
    if (field.name == name) there = &field;  // the last of a name counts
  if (there && !there->locked.empty()) return refuse(there->text, there->locked, there->value);
  if (!there && (asked.kind != EntityKind::material || index_of(name) < 0)) {
    std::vector<std::string> names;
    for (const StatementWord& word : kMtlWords) names.emplace_back(word.name);
    return refuse(fmt::format("'{}' is no statement", name),
                  fmt::format("one of {}{}", fmt::join(names, ", "), suggestion(name, names)));
  }
  const Field field = there ? *there : describe_statement(name);
  if (auto refusal = check_statement(field, value)) {
    refusal->range = field.value;
    change.refusal = std::move(refusal);
    return change;
  }
  if (there && field.text == value) return change;
  if (there && field.kind == ValueKind::color && typed_parts(field.text).size() == 3) {
    change.edits = replace_words(outline.text(), field.value, value);
  } else if (there) {
    const bool is_missing =
        field.value.is_empty() && field.value.begin == outline.tree()[field.syntax].name.end;
    change.edits.push_back({field.value, (is_missing ? " " : "") + written(field, value)});
  } else {
    const Field* sibling = &asked.fields.front();
    for (const Field& one : asked.fields)
      if (index_of(one.name) < index_of(name)) sibling = &one;
    change.edits.push_back(
        Layout(outline.text(), "#")
            .behind(sibling->range, fmt::format("{} {}", name, written(field, value))));
  }
  return change;
}

Change reset_statement(const Outline& outline, int entity, std::string_view name) {
  Change change;
  for (const Field& field : outline.entities()[static_cast<size_t>(entity)].fields)
    if (field.name == name && name != "name")
      change.edits.push_back(Layout(outline.text(), "#").without(field.range));
  return change;
}

Change remove_statements(const Outline& outline, int entity) {
  if (entity == 0) return refuse("the file itself", "a part of it");
  Change change;
  change.edits.push_back(
      Layout(outline.text(), "#").without(outline.entities()[static_cast<size_t>(entity)].range));
  return change;
}

Change duplicate_statements(const Outline& outline, int entity) {
  const Entity& asked = outline.entities()[static_cast<size_t>(entity)];
  if (asked.kind != EntityKind::material || asked.name.empty())
    return refuse("what is no material", "a material", asked.range);
  std::vector<std::string> names;
  for (const Entity& one : outline.entities()) names.push_back(one.name);
  const SourceRange name = asked.fields.front().value;
  const std::string copy =
      apply_edits(text_of(outline.text(), asked.range),
                  {{{name.begin - asked.range.begin, name.end - asked.range.begin},
                    free_name(asked.name, names, "_")}});
  Change change;
  change.edits.push_back(Layout(outline.text(), "#").behind(asked.range, copy));
  return change;
}

}  // namespace tessera::edit
