#pragma once

#include <array>
#include <string>
#include <string_view>

#include "scenes/edit/edit_sequence.h"
#include "scenes/edit/placement.h"

namespace tessera::edit {

/// Three numbers as they are typed.
using TypedTriple = std::array<std::string, 3>;

bool is_same(const TypedTriple& one, const TypedTriple& other);
/// `wanted` between blanks, with the numbers of `there` that are equal as they are spelled there,
/// so that their literals stay.
std::string respelled(const TypedTriple& there, const TypedTriple& wanted);

/// The scale with the signs that mirror.
TypedTriple signed_scale(const Placement& placement);
void set_signed_scale(Placement& placement, const TypedTriple& scale);

/// The last field of that name, which is the one that counts; null: the text has none.
const Field* written_field(const Entity& entity, std::string_view name);
/// Its text.
std::string written_text(const Entity& entity, std::string_view name,
                         std::string_view otherwise = "");

// What depends on a language. Reading adds to a placement with the file and the material what the
// text says of the rest, and why the placement is locked; setting changes the rest from `there`,
// which was read, to `wanted`.
void read_message_placement(const Outline& outline, int entity, WrittenPlacement& read);
void set_message_placement(EditSequence& sequence, int entity, const Placement& there,
                           const Placement& wanted);
void read_crt_placement(const Outline& outline, int entity, WrittenPlacement& read);
void set_crt_placement(EditSequence& sequence, int entity, const Placement& there,
                       const Placement& wanted);
void read_x3d_placement(const Outline& outline, int entity, WrittenPlacement& read);
void set_x3d_placement(EditSequence& sequence, int entity, const Placement& there,
                       const Placement& wanted);

}  // namespace tessera::edit
