#include "scenes/edit/outline.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>

#include "base/lower_case.h"
#include "scenes/edit/crt_outline.h"
#include "scenes/edit/crt_syntax.h"
#include "scenes/edit/gltf_edit.h"
#include "scenes/edit/message_outline.h"
#include "scenes/edit/statement_edit.h"
#include "scenes/edit/syntax_tree.h"
#include "scenes/edit/x3d_edit.h"
#include "scenes/edit/xml_syntax.h"

namespace tessera::edit {

std::optional<Language> language_of(std::string_view path) {
  constexpr std::pair<std::string_view, Language> kEndings[] = {
      {".tessera", Language::tessera},  {".json", Language::json},
      {".crt", Language::crt},          {".x3d", Language::x3d},
      {".x3dv", Language::classic_x3d}, {".wrl", Language::classic_x3d},
      {".obj", Language::obj},          {".mtl", Language::mtl},
      {".gltf", Language::gltf}};
  const std::string lower = lower_case(std::string(path));
  for (const auto& [ending, language] : kEndings)
    if (lower.ends_with(ending)) return language;
  return {};
}

std::string_view name_of(EntityKind kind) {
  constexpr std::array<std::string_view, 21> kNames{
      "scene",    "metadata", "settings", "camera", "background", "fog",   "light",
      "material", "texture",  "object",   "node",   "shape",      "step",  "key",
      "include",  "blob",     "variable", "macro",  "call",       "group", "other"};
  return kNames[static_cast<size_t>(kind)];
}

std::string_view name_of(ValueKind kind) {
  constexpr std::array<std::string_view, 12> kNames{"number",    "integer", "vector",     "color",
                                                    "choice",    "text",    "boolean",    "file",
                                                    "reference", "list",    "expression", "data"};
  return kNames[static_cast<size_t>(kind)];
}

bool FieldLimits::allows(double value) const {
  if (least && (above_least ? !(value > *least) : !(value >= *least))) return false;
  return !most || (below_most ? value < *most : value <= *most);
}

std::string FieldLimits::str() const {
  std::string text;
  if (least) text = fmt::format("{} {}", above_least ? "above" : "at least", *least);
  if (most)
    text += fmt::format("{}{} {}", least ? " and " : "", below_most ? "below" : "at most", *most);
  return text;
}

Outline::Outline(Language language, std::string text, std::shared_ptr<const SyntaxTree> tree,
                 std::vector<Entity> entities)
    : language_(language),
      text_(std::move(text)),
      tree_(std::move(tree)),
      entities_(std::move(entities)) {}

int Outline::entity_at(size_t offset) const {
  int found = 0;
  for (size_t i = 1; i < entities_.size(); ++i) {
    const Entity& entity = entities_[i];
    // Parents stand before their children, so that the last one that holds the place is innermost.
    if (entity.range.contains(offset) && !entity.range.is_empty() &&
        entities_[static_cast<size_t>(found)].range.contains(entity.range))
      found = static_cast<int>(i);
  }
  return found;
}

std::optional<int> Outline::entity_of_path(std::string_view path) const {
  std::optional<int> found;
  size_t longest = 0;
  for (size_t i = 1; i < entities_.size(); ++i) {
    const std::string& own = entities_[i].path;
    const bool holds =
        path.starts_with(own) && (path.size() == own.size() || path[own.size()] == '.');
    if (!holds || own.size() <= longest) continue;
    found = static_cast<int>(i);
    longest = own.size();
  }
  return found;
}

std::optional<int> Outline::entity_named(EntityKind kind, std::string_view name) const {
  for (size_t i = 0; i < entities_.size(); ++i)
    if (entities_[i].kind == kind && entities_[i].name == name) return static_cast<int>(i);
  return {};
}

namespace {

/// One node: what is not told apart.
SyntaxTree whole_text(std::string_view text) {
  const SourceRange all{0, static_cast<uint32_t>(std::min<size_t>(text.size(), UINT32_MAX))};
  SyntaxTree tree;
  tree.add(-1, {.kind = SyntaxKind::block, .range = all, .value = all, .body = all});
  return tree;
}

SyntaxTree parse(Language language, std::string_view text) {
  switch (language) {
    case Language::json:
      return parse_json(text, true);
    case Language::crt:
      return parse_crt_syntax(text);
    case Language::x3d:
      return parse_xml_syntax(text);
    case Language::classic_x3d:
      return parse_classic_syntax(text);
    case Language::gltf:
      return parse_json(text, false);
    case Language::obj:
    case Language::mtl:
      return parse_statements(text, language == Language::mtl);
    case Language::tessera:
      return parse_tessera(text);
    default:
      return whole_text(text);
  }
}

std::vector<Entity> entities_of(Language language, std::string_view text, const SyntaxTree& tree) {
  switch (language) {
    case Language::crt:
      return crt_entities(text, tree);
    case Language::x3d:
      return xml_entities(text, tree, false);
    case Language::classic_x3d:
      return xml_entities(text, tree, true);
    case Language::obj:
    case Language::mtl:
      return statement_entities(text, tree);
    case Language::gltf:
      return gltf_entities(text, tree);
    case Language::tessera:
    case Language::json:
      return message_entities(text, tree);
    default:
      return {{.kind = EntityKind::scene, .range = tree[0].range, .body = tree[0].body}};
  }
}

}  // namespace

Outline outline(Language language, std::string text) {
  if (text.size() > kMaxOutlineBytes) {
    auto whole = std::make_shared<const SyntaxTree>(whole_text(text));
    std::vector<Entity> scene{
        {.kind = EntityKind::scene, .range = (*whole)[0].range, .body = (*whole)[0].body}};
    return {language, std::move(text), std::move(whole), std::move(scene)};
  }
  auto tree = std::make_shared<const SyntaxTree>(parse(language, text));
  std::vector<Entity> entities = entities_of(language, text, *tree);
  return {language, std::move(text), std::move(tree), std::move(entities)};
}

std::vector<Field> all_fields(const Outline& outline, int entity) {
  if (outline.language() == Language::crt) return all_crt_fields(outline, entity);
  if (outline.language() == Language::obj || outline.language() == Language::mtl)
    return all_statement_fields(outline, entity);
  if (outline.language() == Language::gltf)
    return outline.entities()[static_cast<size_t>(entity)].fields;
  if (outline.language() == Language::x3d || outline.language() == Language::classic_x3d)
    return all_xml_fields(outline, entity);
  return all_message_fields(outline, entity);
}

}  // namespace tessera::edit
