#include "scenes/edit/vocabulary.h"

#include "scenes/edit/message_vocabulary.h"
#include "scenes/edit/statement_edit.h"
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
    case Language::classic_x3d:
      return classic_completions(outline, offset);
    case Language::obj:
    case Language::mtl:
      return statement_completions(outline, offset);
    case Language::gltf:
      break;
  }
  return {};
}

std::optional<Hover> hover(const Outline& outline, size_t offset) {
  switch (outline.language()) {
    case Language::tessera:
    case Language::json:
      return message_hover(outline, offset);
    case Language::crt:
      return crt_hover(outline, offset);
    case Language::x3d:
    case Language::classic_x3d:
      return x3d_hover(outline, offset);
    case Language::obj:
    case Language::mtl:
      return statement_hover(outline, offset);
    case Language::gltf:
      break;
  }
  return {};
}

}  // namespace tessera::edit
