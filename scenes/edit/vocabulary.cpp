#include "scenes/edit/vocabulary.h"

#include "scenes/edit/message_vocabulary.h"
#include "scenes/edit/word_vocabulary.h"

namespace tessera::edit {

Completions completions(const Outline& outline, size_t offset) {
  switch (outline.language()) {
    case Language::tessera:
    case Language::json:
      return message_completions(outline, offset);
    case Language::crt:
      return crt_completions(outline, offset);
    case Language::x3d:
      return xml_completions(outline, offset);
    default:
      return {};
  }
}

std::optional<Hover> hover(const Outline& outline, size_t offset) {
  switch (outline.language()) {
    case Language::tessera:
    case Language::json:
      return message_hover(outline, offset);
    case Language::crt:
      return crt_hover(outline, offset);
    case Language::x3d:
      return xml_hover(outline, offset);
    default:
      return {};
  }
}

}  // namespace tessera::edit
