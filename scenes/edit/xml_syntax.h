#pragma once

#include <string>
#include <string_view>

#include "scenes/edit/syntax_tree.h"

namespace tessera::edit {

/// SyntaxNode::type of what XML has.
enum class XmlPart : int16_t {
  document,
  element,
  attribute,
  held,  ///< an element whose range begins with the field that holds it, in the classic encoding
};

inline XmlPart xml_part(const SyntaxNode& node) { return static_cast<XmlPart>(node.type); }

/// Elements and their attributes. An attribute's value has its quotes, its body not; an element's
/// body is what stands between its tags.
SyntaxTree parse_xml_syntax(std::string_view text);
/// The same pieces of the classic encoding and of VRML97.
SyntaxTree parse_classic_syntax(std::string_view text);

/// The text that an attribute's words stand for, and the other way round for quotes of that kind.
std::string unescape_xml(std::string_view words);
std::string escape_xml(std::string_view text, char quote);

}  // namespace tessera::edit
