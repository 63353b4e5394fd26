#include "scenes/edit/x3d_words.h"

#include <algorithm>
#include <string_view>
#include <vector>

#include "scenes/edit/literal.h"
#include "scenes/formats/x3d/document/x3d_nodes.h"

namespace tessera::edit {
namespace {

struct X3dField {
  std::string_view node, name;  ///< an empty node: any
  ValueKind kind;
  std::string_view fallback, unit;
  FieldLimits limits;
  std::string_view choices = {};  ///< between blanks
};

constexpr FieldLimits kAny{};
constexpr FieldLimits kShare{.least = 0, .most = 1};
constexpr FieldLimits kNotNegative{.least = 0, .most = {}};
constexpr FieldLimits kPositive{.least = 0, .most = {}, .above_least = true};
constexpr FieldLimits kHalfTurn{.least = 0, .most = 3.14159265358979, .above_least = true};
constexpr ValueKind kNumber = ValueKind::number, kVector = ValueKind::vector,
                    kColor = ValueKind::color, kBoolean = ValueKind::boolean,
                    kList = ValueKind::list, kInteger = ValueKind::integer;

/// Fields whose values people change, and all others that readers take for more than text; the
/// first that fits counts.
constexpr X3dField kFields[] = {
    {"Sphere", "radius", kNumber, "1", "m", kPositive},
    {"Cylinder", "radius", kNumber, "1", "m", kPositive},
    {"Cylinder", "height", kNumber, "2", "m", kPositive},
    {"Cone", "bottomRadius", kNumber, "1", "m", kPositive},
    {"Cone", "height", kNumber, "2", "m", kPositive},
    {"Box", "size", kVector, "2 2 2", "m", kPositive},
    {"SpotLight", "radius", kNumber, "100", "m", kNotNegative},
    {"", "radius", kNumber, "100", "m", kNotNegative},
    {"Viewpoint", "position", kVector, "0 0 10", "m", kAny},
    {"OrthoViewpoint", "position", kVector, "0 0 10", "m", kAny},
    {"Viewpoint", "fieldOfView", kNumber, "0.7854", "rad", kHalfTurn},
    {"", "orientation", ValueKind::list, "0 0 1 0", "", kAny},
    {"", "rotation", ValueKind::list, "0 0 1 0", "", kAny},
    {"", "scaleOrientation", ValueKind::list, "0 0 1 0", "", kAny},
    {"", "translation", kVector, "0 0 0", "m", kAny},
    {"Transform", "scale", kVector, "1 1 1", "", kAny},
    {"Transform", "center", kVector, "0 0 0", "m", kAny},
    {"", "centerOfRotation", kVector, "0 0 0", "m", kAny},
    {"", "location", kVector, "0 0 0", "m", kAny},
    {"", "direction", kVector, "0 0 -1", "", kAny},
    {"", "attenuation", kVector, "1 0 0", "", kNotNegative},
    {"", "intensity", kNumber, "1", "", kNotNegative},
    {"", "ambientIntensity", kNumber, "0", "", kShare},
    {"", "beamWidth", kNumber, "0.7854", "rad", kAny},
    {"", "cutOffAngle", kNumber, "1.5708", "rad", kAny},
    {"", "on", kBoolean, "true", "", kAny},
    {"", "global", kBoolean, "false", "", kAny},
    {"", "shadows", kBoolean, "false", "", kAny},
    {"", "solid", kBoolean, "true", "", kAny},
    {"", "ccw", kBoolean, "true", "", kAny},
    {"", "convex", kBoolean, "true", "", kAny},
    {"", "visible", kBoolean, "true", "", kAny},
    {"", "diffuseColor", kColor, "0.8 0.8 0.8", "", kShare},
    {"", "specularColor", kColor, "0 0 0", "", kShare},
    {"", "emissiveColor", kColor, "0 0 0", "", kNotNegative},
    {"", "baseColor", kColor, "1 1 1", "", kShare},
    {"", "shininess", kNumber, "0.2", "", kShare},
    {"", "transparency", kNumber, "0", "", kShare},
    {"", "metallic", kNumber, "1", "", kShare},
    {"", "roughness", kNumber, "1", "", kShare},
    {"", "visibilityRange", kNumber, "0", "m", kNotNegative},
    {"Color", "color", ValueKind::list, "", "", kShare},
    {"", "color", kColor, "1 1 1", "", kNotNegative},
    {"", "alphaMode", ValueKind::choice, "AUTO", "", kAny, "AUTO OPAQUE MASK BLEND"},
    {"", "alphaCutoff", kNumber, "0.5", "", kShare},
    {"", "fogType", ValueKind::choice, "LINEAR", "", kAny, "LINEAR EXPONENTIAL"},
    {"", "castShadow", kBoolean, "true", "", kAny},
    {"", "shadowCaster", kBoolean, "true", "", kAny},
    {"", "shadowIntensity", kNumber, "1", "", kShare},
    {"", "mirror", kNumber, "0", "", kShare},
    {"", "normalScale", kNumber, "1", "", kAny},
    {"", "separateBackColor", kBoolean, "false", "", kAny},
    {"", "axisOfRotation", kVector, "0 1 0", "", kAny},
    {"", "headlight", kBoolean, "true", "", kAny},
    {"", "viewAll", kBoolean, "false", "", kAny},
    {"", "nearDistance", kNumber, "-1", "m", kAny},
    {"", "farDistance", kNumber, "-1", "m", kAny},
    {"", "load", kBoolean, "true", "", kAny},
    {"", "repeatS", kBoolean, "true", "", kAny},
    {"", "repeatT", kBoolean, "true", "", kAny},
    {"", "side", kBoolean, "true", "", kAny},
    {"", "top", kBoolean, "true", "", kAny},
    {"", "bottom", kBoolean, "true", "", kAny},
    {"", "beginCap", kBoolean, "true", "", kAny},
    {"", "endCap", kBoolean, "true", "", kAny},
    {"", "colorPerVertex", kBoolean, "true", "", kAny},
    {"", "normalPerVertex", kBoolean, "true", "", kAny},
    {"", "creaseAngle", kNumber, "0", "rad", kNotNegative},
    {"", "innerRadius", kNumber, "0", "m", kNotNegative},
    {"", "outerRadius", kNumber, "1", "m", kPositive},
    {"", "xSpacing", kNumber, "1", "m", kPositive},
    {"", "zSpacing", kNumber, "1", "m", kPositive},
    {"", "spacing", kNumber, "1", "", kAny},
    {"", "maxExtent", kNumber, "0", "m", kNotNegative},
    {"", "applied", kBoolean, "true", "", kAny},
    {"", "linetype", kInteger, "1", "", kAny},
    {"", "linewidthScaleFactor", kNumber, "0", "", kAny},
    {"", "skyColor", kList, "0 0 0", "", kShare},
    {"", "groundColor", kList, "", "", kShare},
    {"", "skyAngle", kList, "", "rad", kAny},
    {"", "groundAngle", kList, "", "rad", kAny},
    {"", "url", ValueKind::file, "", "", kAny},
    {"", "DEF", ValueKind::text, "", "", kAny},
    {"", "USE", ValueKind::reference, "", "", kAny},
    {"", "description", ValueKind::text, "", "", kAny},
    {"", "name", ValueKind::text, "", "", kAny},
    {"", "xDimension", ValueKind::integer, "0", "", kNotNegative},
    {"", "zDimension", ValueKind::integer, "0", "", kNotNegative},
    {"", "uDimension", ValueKind::integer, "0", "", kNotNegative},
    {"", "vDimension", ValueKind::integer, "0", "", kNotNegative},
    {"", "uOrder", ValueKind::integer, "3", "", kNotNegative},
    {"", "vOrder", ValueKind::integer, "3", "", kNotNegative},
    {"", "order", ValueKind::integer, "3", "", kNotNegative},
    {"", "whichChoice", ValueKind::integer, "-1", "", kAny},
};

/// The first word from `at` on; empty: there is none.
SourceRange next_word(std::string_view text, uint32_t at, uint32_t end) {
  while (at < end && (is_space(text[at]) || text[at] == ',')) ++at;
  const uint32_t begin = at;
  while (at < end && !is_space(text[at]) && text[at] != ',') ++at;
  return {begin, at};
}

bool is_numbers(std::string_view value, size_t& count) {
  count = 0;
  const auto end = static_cast<uint32_t>(value.size());
  for (SourceRange word = next_word(value, 0, end); !word.is_empty();
       word = next_word(value, word.end, end), ++count)
    if (!typed_number(text_of(value, word))) return false;
  return count > 0;
}

std::vector<std::string_view> words_of(std::string_view text) {
  std::vector<std::string_view> words;
  while (!text.empty()) {
    const size_t end = std::min(text.find(' '), text.size());
    words.push_back(text.substr(0, end));
    text.remove_prefix(std::min(end + 1, text.size()));
  }
  return words;
}

}  // namespace

EntityKind x3d_entity_kind(std::string_view node) {
  if (node == "Inline") return EntityKind::include;
  if (node == "head" || node == "meta") return EntityKind::metadata;
  if (node == "Fog") return EntityKind::fog;
  if (node == "Shape") return EntityKind::shape;
  if (node.ends_with("Viewpoint")) return EntityKind::camera;
  if (node.ends_with("Light")) return EntityKind::light;
  if (node.ends_with("Background")) return EntityKind::background;
  const X3dNodeType* type = find_x3d_node_type(node);
  if (!type) return EntityKind::group;
  if (type->container == "geometry") return EntityKind::shape;
  if (type->container == "material" || type->container == "appearance") return EntityKind::material;
  if (type->container.starts_with("texture")) return EntityKind::texture;
  return type->container == "children" ? EntityKind::node : EntityKind::other;
}

Field describe_x3d(std::string_view node, std::string_view name, std::string_view value) {
  Field field;
  field.name = name;
  field.is_present = false;
  for (const X3dField& known : kFields) {
    if (known.name != name || (!known.node.empty() && known.node != node)) continue;
    field.kind = known.kind;
    field.fallback = field.text = known.fallback;
    field.unit = known.unit;
    field.limits = known.limits;
    if (known.kind == kBoolean) field.choices = {"false", "true"};
    for (const std::string_view choice : words_of(known.choices))
      field.choices.emplace_back(choice);
    size_t numbers = 0;
    const bool is_triple = known.kind == kVector || known.kind == kColor;
    if (is_triple && is_numbers(value, numbers) && numbers != 3) field.kind = ValueKind::list;
    return field;
  }
  size_t count = 0;
  if (value == "true" || value == "false" || value == "TRUE" || value == "FALSE") {
    field.kind = kBoolean;
    field.choices = {"false", "true"};
  } else if (is_numbers(value, count)) {
    const bool is_whole = name.ends_with("Index") || name.ends_with("Count");
    field.kind = count > 1 ? ValueKind::list : is_whole ? ValueKind::integer : kNumber;
  }
  return field;
}

std::vector<SourceRange> number_words(std::string_view text, SourceRange body) {
  std::vector<SourceRange> words;
  for (SourceRange word = next_word(text, body.begin, body.end); !word.is_empty();
       word = next_word(text, word.end, body.end))
    words.push_back(word);
  return words;
}

int x3d_parts(const Field& field) {
  if (field.kind == kVector || field.kind == kColor) return 3;
  const bool is_turn = field.kind == ValueKind::list && field.fallback == "0 0 1 0";
  return is_turn ? 4 : 0;
}

}  // namespace tessera::edit
