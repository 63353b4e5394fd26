#pragma once

#include <span>
#include <string_view>

#include "scenes/edit/outline.h"

namespace tessera::edit {

/// An attribute of an object of the CRT language, as docs/crt.md has it.
struct CrtAttributeWord {
  std::string_view name;
  ValueKind kind;
  std::string_view fallback;  ///< empty: it has to be there
  std::string_view help;
  std::string_view unit;
  FieldLimits limits;
  std::string_view choices;  ///< between blanks
};

struct CrtObjectWord {
  std::string_view name;
  EntityKind kind;
  std::string_view help;
  std::span<const CrtAttributeWord> attributes;
};

std::span<const CrtObjectWord> crt_words();
const CrtObjectWord* find_crt_word(std::string_view name);
const CrtAttributeWord* find_crt_attribute(const CrtObjectWord* object, std::string_view name);
/// Without a place and value.
Field describe(const CrtAttributeWord& attribute);

}  // namespace tessera::edit
