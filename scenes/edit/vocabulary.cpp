#include "scenes/edit/vocabulary.h"

#include "scenes/edit/message_vocabulary.h"
#include "scenes/edit/statement_edit.h"
#include "scenes/edit/word_vocabulary.h"

namespace tessera::edit {
namespace {

/// What a language knows of its words.
struct Vocabulary {
  Completions (*completions)(const Outline& outline, size_t offset);
  std::optional<Hover> (*hover)(const Outline& outline, size_t offset);
};

std::optional<Vocabulary> vocabulary_of(Language language) {
  switch (language) {
    case Language::tessera:
    case Language::json:
      return Vocabulary{message_completions, message_hover};
    case Language::crt:
      return Vocabulary{crt_completions, crt_hover};
    case Language::x3d:
      return Vocabulary{xml_completions, x3d_hover};
    case Language::classic_x3d:
      return Vocabulary{classic_completions, x3d_hover};
    case Language::obj:
    case Language::mtl:
      return Vocabulary{statement_completions, statement_hover};
    case Language::gltf:
      break;
  }
  return {};
}

}  // namespace

Completions completions(const Outline& outline, size_t offset) {
  const auto vocabulary = vocabulary_of(outline.language());
  return vocabulary ? vocabulary->completions(outline, offset) : Completions{};
}

std::optional<Hover> hover(const Outline& outline, size_t offset) {
  const auto vocabulary = vocabulary_of(outline.language());
  return vocabulary ? vocabulary->hover(outline, offset) : std::nullopt;
}

}  // namespace tessera::edit
