#pragma once

#include <array>
#include <optional>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "scenes/edit/outline.h"

namespace tessera::edit {

/// Why a change is not made.
struct Refusal {
  std::string found, expected;
  SourceRange range;  ///< what it is about; empty: nothing in the text
};

/// The change of a text, or why there is none.
struct Change {
  std::vector<TextEdit> edits;
  std::optional<Refusal> refusal;
  /// How many entities change; more than one where a variable's or definition's literal is set.
  int changed = 1;
  /// The entity that a change in steps was about, among those of the changed text; 0: none.
  int entity = 0;

  bool is_made() const { return !refusal; }
};

/// Gives one field another value: replaces its literal, or the literals of the parts of a vector
/// that differ; inserts the field beside its siblings where the text does not have it. `value` is
/// what a person types: a text without quotes, the parts of a vector between blanks.
Change set_field(const Outline& outline, int entity, std::string_view field,
                 std::string_view value);

/// Takes the field out of the text, so that it has its default again.
Change reset_field(const Outline& outline, int entity, std::string_view field);

Change remove(const Outline& outline, int entity);

/// A copy behind the entity, with a name that is free where it has one.
Change duplicate(const Outline& outline, int entity);

/// What add() makes: fields with their values, in the language's own names.
struct EntityTemplate {
  std::string name;  ///< as menus show it
  std::string type;  ///< the field of the message that holds it; the object or element elsewhere
  std::vector<std::pair<std::string, std::string>> fields;
  /// Where a shape or a file is placed; nothing: at the origin.
  std::optional<std::array<double, 3>> position{};
};
/// Its position as a person types it: three numbers between blanks, as short as a thousandth of the
/// largest allows.
std::string written_position(const EntityTemplate& made);
std::vector<EntityTemplate> entity_templates(Language language);

/// Adds an entity at the end of its kind in `parent`.
Change add(const Outline& outline, int parent, const EntityTemplate& made);

/// A placement of another file, in the language's own words.
Change add_include(const Outline& outline, std::string_view file,
                   const std::optional<std::array<double, 3>>& position = {});

/// Makes the picture in the file the panorama that is the background, in place of whatever that is.
Change set_panorama(const Outline& outline, std::string_view file);

/// A camera as the studio's view has it. Lengths in metres, angles in degrees.
struct CameraPose {
  std::array<double, 3> eye{}, target{}, up{0, 1, 0};
  std::optional<double> field_of_view;  ///< a panorama keeps its own
  std::string axis;                     ///< smaller, vertical, horizontal, larger; empty: as it is
  std::optional<double> orthographic;   ///< the height of the window in place of an angle
  double aspect = 0;  ///< of the picture, width over height, which says what is smaller; 0: unknown
};

/// Gives the camera called `name`, or without a name the first one, this pose, in the shortest
/// numbers that keep the camera's frame within 1e-6; inserts one where the text has none.
Change write_camera(const Outline& outline, std::string_view name, const CameraPose& pose);

}  // namespace tessera::edit
