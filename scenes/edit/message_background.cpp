#include <string>

#include "scenes/edit/edit_sequence.h"
#include "scenes/edit/message_edit.h"

namespace tessera::edit {
namespace {

/// The name of the texture that stands last in the text.
std::string name_of_last_texture(const Outline& outline) {
  std::string name;
  for (const Entity& entity : outline.entities())
    if (entity.kind == EntityKind::texture && entity.parent == 0) name = entity.name;
  return name;
}

}  // namespace

Change set_message_panorama(const Outline& outline, std::string_view file) {
  EditSequence sequence(outline);
  for (const char* const other :
       {"background.solid", "background.gradient", "background.rings", "background.sun_and_sky"})
    sequence.then([&](const Outline& now) { return reset_message_field(now, 0, other); });
  sequence.then([&](const Outline& now) {
    return add_message(
        now, 0,
        {"panorama", "textures", {{"name", "panorama"}, {"image.file", std::string(file)}}});
  });
  sequence.then([&](const Outline& now) {
    return set_message_field(now, 0, "background.panorama.texture", name_of_last_texture(now));
  });
  return sequence.finish();
}

}  // namespace tessera::edit
