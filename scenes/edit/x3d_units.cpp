#include "scenes/edit/x3d_units.h"

#include <limits>
#include <utility>

#include "scenes/edit/layout.h"
#include "scenes/edit/literal.h"
#include "scenes/edit/x3d_words.h"
#include "scenes/edit/xml_syntax.h"

namespace tessera::edit {
namespace {

/// As the reader takes it: a factor that is none is left out.
void set_unit(X3dUnits& units, std::string_view category, std::string_view factor) {
  const double value = typed_number(factor).value_or(0);
  if (!(value >= double{std::numeric_limits<float>::min()})) return;
  if (category == "length") units.length = value;
  if (category == "angle") units.angle = value;
}

}  // namespace

X3dUnits x3d_units(std::string_view text, const SyntaxTree& tree, bool is_classic) {
  X3dUnits units;
  if (is_classic) {
    // The statement is a line that the syntax tree leaves out.
    constexpr std::string_view kStatement = "UNIT";
    for (size_t at = text.find(kStatement); at != text.npos; at = text.find(kStatement, at + 1)) {
      const auto begin = static_cast<uint32_t>(at);
      const auto words = number_words(text, {begin, line_end(text, begin)});
      if (words.size() >= 4 && begins_line(text, begin) && text_of(text, words[0]) == kStatement)
        set_unit(units, text_of(text, words[1]), text_of(text, words[3]));
    }
    return units;
  }
  for (int32_t i = 1; i < tree.size(); ++i) {
    if (xml_part(tree[i]) != XmlPart::element || text_of(text, tree[i].name) != "unit") continue;
    std::string_view category, factor;
    for (int32_t k = tree[i].first_child; k >= 0; k = tree[k].next) {
      const std::string_view name = text_of(text, tree[k].name);
      if (name == "category") category = text_of(text, tree[k].body);
      if (name == "conversionFactor") factor = text_of(text, tree[k].body);
    }
    set_unit(units, category, factor);
  }
  return units;
}

X3dUnits x3d_units(const Outline& outline) {
  return x3d_units(outline.text(), outline.tree(), outline.language() == Language::classic_x3d);
}

Field in_units(Field field, const X3dUnits& units) {
  if (field.unit == "m" && units.length != 1) field.unit.clear();
  if (field.unit != "rad" || units.angle == 1) return field;
  field.unit.clear();
  field.limits = {};
  if (!field.is_present) field.text.clear();
  field.fallback.clear();
  return field;
}

}  // namespace tessera::edit
