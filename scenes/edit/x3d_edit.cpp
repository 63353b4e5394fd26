#include "scenes/edit/x3d_edit.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "base/error.h"
#include "renderer/math/elementary.h"
#include "scenes/edit/camera_numbers.h"
#include "scenes/edit/edit_sequence.h"
#include "scenes/edit/layout.h"
#include "scenes/edit/literal.h"
#include "scenes/edit/message_edit.h"
#include "scenes/edit/message_outline.h"
#include "scenes/edit/x3d_units.h"
#include "scenes/edit/x3d_words.h"
#include "scenes/edit/xml_syntax.h"
#include "scenes/formats/x3d/document/x3d_nodes.h"

namespace tessera::edit {
namespace {

bool holds_numbers(const Field& field) {
  return field.kind == ValueKind::vector || field.kind == ValueKind::color ||
         field.kind == ValueKind::list;
}

std::optional<Refusal> check_x3d(const Field& field, std::string_view value) {
  if (!holds_numbers(field)) return check_value(field, value);
  const auto parts = typed_parts(value);
  const int wanted = x3d_parts(field);
  if (parts.empty() || (wanted > 0 && static_cast<int>(parts.size()) != wanted))
    return Refusal{
        value.empty() ? "nothing" : fmt::format("'{}'", value),
        wanted > 0 ? fmt::format("{} numbers between blanks", wanted) : "numbers between blanks",
        {}};
  Field part;
  const bool is_whole = field.name.ends_with("Index") || field.name.ends_with("Count");
  part.kind = is_whole ? ValueKind::integer : ValueKind::number;
  part.limits = field.limits;
  for (const std::string& one : parts)
    if (auto refusal = check_value(part, one)) return refusal;
  return {};
}

/// Of a field that the text does not have: its kind is guessed only where it is not on record.
Field describe_new(std::string_view node, std::string_view name, std::string_view value) {
  Field field = describe_x3d(node, name, "");
  return field.kind == ValueKind::text ? describe_x3d(node, name, value) : field;
}

bool is_classic(const Outline& outline) { return outline.language() == Language::classic_x3d; }

/// What is written as a value in the classic encoding, whose texts have quotes.
std::string classic_words(const Field& field, std::string_view value);

/// What is written between the quotes.
std::string new_words(const Field& field, std::string_view value, char quote) {
  if (field.kind == ValueKind::number || field.kind == ValueKind::integer)
    return strict_number(trimmed(value));
  if (holds_numbers(field)) {
    std::string words;
    for (const std::string& part : typed_parts(value))
      words += (words.empty() ? "" : " ") + strict_number(part);
    return words;
  }
  if (field.kind == ValueKind::file) return escape_xml(fmt::format("\"{}\"", value), quote);
  return escape_xml(value, quote);
}

std::string classic_words(const Field& field, std::string_view value) {
  if (field.name == "DEF" || field.name == "USE") return std::string(value);
  const bool is_text = field.kind == ValueKind::text || field.kind == ValueKind::file ||
                       field.kind == ValueKind::choice;
  return is_text ? quote(value, '"', false) : new_words(field, value, '"');
}

Change set_attribute(const Outline& outline, const Field& field, std::string_view value) {
  const SyntaxNode& node = outline.tree()[field.syntax];
  const std::string& text = outline.text();
  Change change;
  if (auto refusal = check_x3d(field, value)) {
    refusal->range = node.value;
    change.refusal = std::move(refusal);
    return change;
  }
  if (field.text == value) return change;
  if (node.value.is_empty() || !node.is_closed)
    return refuse("an attribute without quotes", "name='value'", node.range);
  const auto parts = typed_parts(value);
  const auto words = number_words(text, node.body);
  if (!holds_numbers(field) || parts.size() != words.size()) {
    change.edits.push_back({node.body, is_classic(outline)
                                           ? classic_words(field, value)
                                           : new_words(field, value, text[node.value.begin])});
    return change;
  }
  for (size_t i = 0; i < parts.size(); ++i)
    if (text_of(text, words[i]) != parts[i])
      change.edits.push_back({words[i], strict_number(parts[i])});
  return change;
}

/// The quote that attributes around an element have.
char quote_of(const Outline& outline, int32_t element) {
  const SyntaxTree& tree = outline.tree();
  for (int32_t k = tree[element].first_child; k >= 0; k = tree[k].next)
    if (xml_part(tree[k]) == XmlPart::attribute && !tree[k].value.is_empty())
      return outline.text()[tree[k].value.begin];
  for (int32_t i = 1; i < tree.size(); ++i)
    if (xml_part(tree[i]) == XmlPart::attribute && !tree[i].value.is_empty())
      return outline.text()[tree[i].value.begin];
  return '\'';
}

Change insert_attribute(const Outline& outline, const Entity& entity, const Field& field,
                        std::string_view value) {
  const auto element = static_cast<int32_t>(entity.syntax);
  const SyntaxTree& tree = outline.tree();
  if (auto refusal = check_x3d(field, value))
    return refuse(refusal->found, refusal->expected, entity.range);
  if (is_classic(outline)) {
    const Layout layout(outline.text(), "#");
    const std::string line = fmt::format("{} {}", field.name, classic_words(field, value));
    int32_t sibling = -1;
    for (int32_t k = tree[element].first_child; k >= 0; k = tree[k].next)
      if (tree[element].body.contains(tree[k].range) && xml_part(tree[k]) == XmlPart::attribute)
        sibling = k;
    Change change;
    change.edits.push_back(sibling >= 0
                               ? layout.behind(tree[sibling].range, line)
                               : layout.inside(tree[element].body, entity.range.begin, line,
                                               indentation_unit(outline.text(), "  ")));
    return change;
  }
  const char quote = quote_of(outline, element);
  const std::string made =
      fmt::format("{}={}{}{}", field.name, quote, new_words(field, value, quote), quote);
  int32_t last = -1;
  for (int32_t k = tree[element].first_child; k >= 0; k = tree[k].next)
    if (xml_part(tree[k]) == XmlPart::attribute) last = k;
  Change change;
  if (last < 0) {
    const uint32_t at = tree[element].name.end;
    change.edits.push_back({{at, at}, " " + made});
    return change;
  }
  const SourceRange there = tree[last].range;
  const std::string gap = begins_line(outline.text(), there.begin)
                              ? std::string(line_ending(outline.text(), there.begin)) +
                                    std::string(indentation(outline.text(), there.begin))
                              : " ";
  change.edits.push_back({{there.end, there.end}, gap + made});
  return change;
}

Change add_classic(const Outline& outline, const EntityTemplate& made, const X3dNodeType& type) {
  std::string text = made.type + " {";
  for (const auto& [name, value] : made.fields) {
    const Field field = describe_new(made.type, name, value);
    if (auto refusal = check_x3d(field, value)) return refuse(refusal->found, refusal->expected);
    text += fmt::format(" {} {}", name, classic_words(field, value));
  }
  text += " }";
  const std::string place =
      made.position ? fmt::format("translation {} ", written_position(made)) : "";
  if (type.container == "geometry") {
    text = fmt::format(
        "Transform {{ {}children Shape {{ appearance Appearance {{ material Material {{ }} }} "
        "geometry "
        "{} }} }}",
        place, text);
  } else if (made.position) {
    text = fmt::format("Transform {{ {}children {} }}", place, text);
  }
  Change change;
  change.edits.push_back(Layout(outline.text(), "#").at_end(text));
  return change;
}

std::vector<std::string> defined_names(const Outline& outline) {
  std::vector<std::string> names;
  for (const Entity& entity : outline.entities())
    for (const Field& field : entity.fields)
      if (field.name == "DEF") names.push_back(field.text);
  return names;
}

}  // namespace

Change set_xml_field(const Outline& outline, int entity, std::string_view name,
                     std::string_view value) {
  const Entity& asked = outline.entities()[static_cast<size_t>(entity)];
  if (asked.syntax == 0) return refuse("the document", "one of its elements");
  int uses = 1;
  for (const Field& field : asked.fields) uses = std::max(uses, field.uses);
  const auto counted = [&](Change change) {
    change.changed = uses;
    return change;
  };
  for (const Field& field : asked.fields) {
    if (field.name != name) continue;
    if (!field.locked.empty()) return refuse(field.text, field.locked, field.value);
    return counted(set_attribute(outline, field, value));
  }
  const X3dNodeType* type = find_x3d_node_type(asked.type);
  if (type && !type->has_field(name)) {
    const auto names = type->field_names();
    return refuse(fmt::format("{} has no field '{}'", asked.type, name),
                  fmt::format("one of {}{}", fmt::join(names, ", "), suggestion(name, names)));
  }
  if (!asked.name.empty() && std::any_of(asked.fields.begin(), asked.fields.end(),
                                         [](const Field& f) { return f.name == "USE"; }))
    return refuse(fmt::format("a use of '{}'", asked.name), "its definition", asked.range);
  const Field field = in_units(describe_new(asked.type, name, value), x3d_units(outline));
  return counted(insert_attribute(outline, asked, field, value));
}

Change reset_xml_field(const Outline& outline, int entity, std::string_view name) {
  Change change;
  for (const Field& field : outline.entities()[static_cast<size_t>(entity)].fields) {
    if (field.name != name) continue;
    uint32_t begin = field.range.begin;
    while (begin > 0 && is_space(outline.text()[begin - 1])) --begin;
    change.edits.push_back({{begin, field.range.end}, ""});
    return change;
  }
  return change;
}

Change remove_xml(const Outline& outline, int entity) {
  const Entity& asked = outline.entities()[static_cast<size_t>(entity)];
  if (entity == 0 || asked.type == "X3D" || asked.type == "Scene")
    return refuse("the scene itself", "a part of it");
  for (const Field& field : asked.fields)
    if (field.name == "DEF" && field.uses > 1)
      return refuse(fmt::format("'{}' is used {} times", field.text, field.uses - 1),
                    "what is not used", asked.range);
  Change change;
  change.edits.push_back(
      Layout(outline.text(), is_classic(outline) ? "#" : "").without(asked.range));
  return change;
}

Change duplicate_xml(const Outline& outline, int entity) {
  const Entity& asked = outline.entities()[static_cast<size_t>(entity)];
  if (entity == 0 || asked.type == "X3D" || asked.type == "Scene")
    return refuse("the scene itself", "a part of it");
  if (!outline.tree()[static_cast<int32_t>(asked.syntax)].is_closed)
    return refuse("an element that is never closed", "its end", asked.range);
  if (xml_part(outline.tree()[static_cast<int32_t>(asked.syntax)]) == XmlPart::held)
    return refuse("the one node of its field", "a node among others", asked.range);
  std::vector<std::string> names = defined_names(outline);
  std::vector<TextEdit> renamed;
  for (size_t i = static_cast<size_t>(entity);
       i < outline.entities().size() && asked.range.contains(outline.entities()[i].range); ++i)
    for (const Field& field : outline.entities()[i].fields) {
      if (field.name != "DEF") continue;
      names.push_back(free_name(field.text, names, ""));
      renamed.push_back(
          {{field.value.begin - asked.range.begin, field.value.end - asked.range.begin},
           names.back()});
    }
  std::sort(renamed.begin(), renamed.end(),
            [](const TextEdit& a, const TextEdit& b) { return a.range.begin < b.range.begin; });
  Change change;
  change.edits.push_back(
      Layout(outline.text(), "")
          .behind(asked.range, apply_edits(text_of(outline.text(), asked.range), renamed)));
  return change;
}

std::vector<EntityTemplate> xml_templates() {
  return {{"file", "Inline", {{"url", ""}}},
          {"camera", "Viewpoint", {{"position", "0 0 10"}}},
          {"sphere", "Sphere", {{"radius", "1"}}},
          {"box", "Box", {{"size", "2 2 2"}}},
          {"cylinder", "Cylinder", {{"radius", "1"}, {"height", "2"}}},
          {"cone", "Cone", {{"bottomRadius", "1"}, {"height", "2"}}},
          {"point light", "PointLight", {{"location", "2 4 3"}}},
          {"directional light", "DirectionalLight", {{"direction", "-1 -2 -1"}}},
          {"spot light", "SpotLight", {{"location", "0 5 0"}, {"direction", "0 -1 0"}}}};
}

Change add_xml(const Outline& outline, const EntityTemplate& wanted) {
  EntityTemplate made = wanted;
  if (made.position)
    for (double& each : *made.position) each /= x3d_units(outline).length;
  const X3dNodeType* type = find_x3d_node_type(made.type);
  if (!type) return refuse(made.type, "a node of X3D");
  if (is_classic(outline)) return add_classic(outline, made, *type);
  const SyntaxTree& tree = outline.tree();
  const Entity* scene = nullptr;
  for (const Entity& entity : outline.entities())
    if (entity.type == "Scene" && !scene) scene = &entity;
  if (!scene) return refuse("a document without Scene", "<Scene> to add it to");
  const auto node = static_cast<int32_t>(scene->syntax);
  const char quote = quote_of(outline, node);
  std::string text = "<" + made.type;
  for (const auto& [name, value] : made.fields) {
    const Field field = describe_new(made.type, name, value);
    if (auto refusal = check_x3d(field, value)) return refuse(refusal->found, refusal->expected);
    text += fmt::format(" {}={}{}{}", name, quote, new_words(field, value, quote), quote);
  }
  text += "/>";
  const std::string place =
      made.position ? fmt::format(" translation={0}{1}{0}", quote, written_position(made)) : "";
  if (type->container == "geometry") {
    text = fmt::format(
        "<Transform{}><Shape><Appearance><Material/></Appearance>{}</Shape></Transform>", place,
        text);
  } else if (made.position) {
    text = fmt::format("<Transform{}>{}</Transform>", place, text);
  }
  int32_t last = -1;
  for (int32_t k = tree[node].first_child; k >= 0; k = tree[k].next)
    if (xml_part(tree[k]) == XmlPart::element) last = k;
  const Layout layout(outline.text(), "");
  Change change;
  const SourceRange slash{tree[node].range.end - 2, tree[node].range.end};
  if (text_of(outline.text(), slash) == "/>") {
    change.edits.push_back({slash, ">" + text + "</Scene>"});
    return change;
  }
  change.edits.push_back(last >= 0 ? layout.behind(tree[last].range, text)
                                   : layout.inside(scene->body, scene->range.begin, text,
                                                   indentation_unit(outline.text(), "  ")));
  return change;
}

}  // namespace tessera::edit
