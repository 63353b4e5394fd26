// Whatever the text: its outline's ranges lie inside of it, and edits give it back by their
// inverse. The first byte is the language, the second the entity, the third the field.
#include <cstddef>
#include <cstdint>
#include <cstdlib>
#include <string>

#include "scenes/edit/edit.h"
#include "scenes/edit/vocabulary.h"

namespace {

using namespace tessera::edit;

void check(const Outline& outline, const Change& change) {
  if (!change.is_made()) return;
  uint32_t last = 0;
  for (const TextEdit& edit : change.edits) {
    if (edit.range.begin < last || edit.range.end < edit.range.begin) std::abort();
    if (edit.range.end > outline.text().size()) std::abort();
    last = edit.range.end;
  }
  const std::string made = apply_edits(outline.text(), change.edits);
  if (apply_edits(made, inverse_edits(outline.text(), change.edits)) != outline.text())
    std::abort();
}

}  // namespace

extern "C" int LLVMFuzzerTestOneInput(const uint8_t* data, size_t size) {
  constexpr size_t kHead = 3, kLanguages = 8;
  if (size < kHead) return 0;
  const auto language = static_cast<Language>(data[0] % kLanguages);
  const Outline made =
      outline(language, std::string(reinterpret_cast<const char*>(data) + kHead, size - kHead));
  for (const Entity& entity : made.entities())
    if (entity.parent >= 0 &&
        !made.entities()[static_cast<size_t>(entity.parent)].range.contains(entity.range))
      std::abort();
  const int entity = static_cast<int>(data[1] % made.entities().size());
  const auto fields = all_fields(made, entity);
  if (!fields.empty()) {
    const Field& field = fields[data[2] % fields.size()];
    for (const char* const value : {"2", "1 2 3", "true", "a\"b'<&"})
      check(made, set_field(made, entity, field.name, value));
    check(made, reset_field(made, entity, field.name));
  }
  check(made, remove(made, entity));
  check(made, duplicate(made, entity));
  check(made, add_include(made, "a.obj"));
  check(made, write_camera(made, "", {{1, 2, 3}, {0, 0, 0}, {0, 1, 0}, 40.0, "", {}}));
  completions(made, size / 2);
  hover(made, size / 2);
  return 0;
}
