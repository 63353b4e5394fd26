#include "scenes/edit/placement.h"

#include <fmt/format.h>

#include <algorithm>
#include <optional>

#include "scenes/edit/language_placement.h"
#include "scenes/edit/literal.h"

namespace tessera::edit {
namespace {

bool places_by_inline(Language language) {
  return language == Language::x3d || language == Language::classic_x3d;
}

/// The field of an include that names its file.
std::string_view file_field(Language language) {
  return places_by_inline(language) ? "url" : "file";
}

bool is_include(const Outline& outline, int entity) {
  return entity >= 0 && static_cast<size_t>(entity) < outline.entities().size() &&
         outline.entities()[static_cast<size_t>(entity)].kind == EntityKind::include;
}

std::optional<Refusal> fault_of(const Placement& placement) {
  for (const TypedTriple* const triple :
       {&placement.position, &placement.rotation, &placement.scale}) {
    for (const std::string& text : *triple)
      if (!typed_number(text)) return Refusal{fmt::format("'{}'", text), "a finite number", {}};
  }
  for (const std::string& text : placement.scale)
    if (*typed_number(text) <= 0)
      return Refusal{fmt::format("a scale of {}", text), "one above 0", {}};
  if (placement.file.empty()) return Refusal{"no file", "the name of one", {}};
  return {};
}

Change refused(Refusal refusal) {
  Change change;
  change.refusal = std::move(refusal);
  return change;
}

void set_file(EditSequence& sequence, int entity, const std::string& file) {
  sequence.then([&](const Outline& now) {
    // A name from a variable, or a node that is used again, names the file of other models, too.
    for (const Field& field : now.entities()[static_cast<size_t>(entity)].fields)
      if (field.uses > 1)
        return refused({fmt::format("'{}', which other models have, too", field.text),
                        "a file of this model alone", field.value});
    return set_field(now, entity, file_field(now.language()), file);
  });
}

void set_material(EditSequence& sequence, int entity, const std::string& material) {
  const Field* const there =
      written_field(sequence.now().entities()[static_cast<size_t>(entity)], "material");
  // One that is written in place gives way to the name of another.
  if (material.empty() || (there && !there->locked.empty()))
    sequence.then([&](const Outline& now) { return reset_field(now, entity, "material"); });
  if (!material.empty())
    sequence.then([&](const Outline& now) { return set_field(now, entity, "material", material); });
}

void set_all(EditSequence& sequence, int entity, const Placement& wanted) {
  sequence.keep(entity);
  const WrittenPlacement read = read_placement(sequence.now(), entity);
  const Placement& there = read.placement;
  if (there.file != wanted.file) set_file(sequence, entity, wanted.file);
  if (there.material != wanted.material) set_material(sequence, entity, wanted.material);
  const Language language = sequence.now().language();
  if (language == Language::crt) {
    set_crt_placement(sequence, entity, there, wanted);
  } else if (places_by_inline(language)) {
    set_x3d_placement(sequence, entity, there, wanted);
  } else {
    set_message_placement(sequence, entity, there, wanted);
  }
}

std::optional<Refusal> fault_here(const WrittenPlacement& there, const Placement& wanted) {
  if (!there.locked.empty()) return Refusal{there.locked, "a placement", {}};
  if (!there.has_material && !wanted.material.empty())
    return Refusal{fmt::format("the material '{}'", wanted.material),
                   "none, as the language has none for a model",
                   {}};
  return {};
}

}  // namespace

bool is_same(const TypedTriple& one, const TypedTriple& other) {
  return std::equal(one.begin(), one.end(), other.begin(),
                    [](const std::string& a, const std::string& b) {
                      return typed_number(a) && typed_number(a) == typed_number(b);
                    });
}

std::string respelled(const TypedTriple& there, const TypedTriple& wanted) {
  TypedTriple spelled = wanted;
  for (size_t i = 0; i < 3; ++i)
    if (typed_number(there[i]) == typed_number(wanted[i])) spelled[i] = there[i];
  return fmt::format("{}", fmt::join(spelled, " "));
}

TypedTriple signed_scale(const Placement& placement) {
  TypedTriple scale = placement.scale;
  for (size_t i = 0; i < 3; ++i) {
    if (scale[i].starts_with('+')) scale[i].erase(0, 1);
    if (placement.flip[i]) scale[i].insert(0, "-");
  }
  return scale;
}

void set_signed_scale(Placement& placement, const TypedTriple& scale) {
  placement.scale = scale;
  for (size_t i = 0; i < 3; ++i) {
    placement.flip[i] = scale[i].starts_with('-');
    if (placement.flip[i]) placement.scale[i].erase(0, 1);
  }
}

const Field* written_field(const Entity& entity, std::string_view name) {
  const Field* found = nullptr;
  for (const Field& field : entity.fields)
    if (field.name == name) found = &field;
  return found;
}

std::string written_text(const Entity& entity, std::string_view name, std::string_view otherwise) {
  const Field* const field = written_field(entity, name);
  return field ? field->text : std::string(otherwise);
}

WrittenPlacement read_placement(const Outline& outline, int entity) {
  const Language language = outline.language();
  const bool is_message = language == Language::tessera || language == Language::json;
  WrittenPlacement read;
  read.has_material = is_message || language == Language::crt;
  if (!read.has_material && !places_by_inline(language))
    read.locked = "a text of this language places no models";
  if (!read.locked.empty() || !is_include(outline, entity)) return read;
  const Entity& asked = outline.entities()[static_cast<size_t>(entity)];
  read.placement.file = written_text(asked, file_field(language));
  if (read.has_material) read.placement.material = written_text(asked, "material");
  if (is_message) {
    read_message_placement(outline, entity, read);
  } else if (language == Language::crt) {
    read_crt_placement(outline, entity, read);
  } else {
    read_x3d_placement(outline, entity, read);
  }
  if (const Field* const file = written_field(asked, file_field(language));
      file && !file->locked.empty())
    read.locked = fmt::format("its file is {}", file->locked);
  return read;
}

Change set_placement(const Outline& outline, int entity, const Placement& placement) {
  if (auto fault = fault_of(placement)) return refused(*std::move(fault));
  if (!is_include(outline, entity)) return refused({"what places no file", "an include", {}});
  if (auto fault = fault_here(read_placement(outline, entity), placement))
    return refused(*std::move(fault));
  EditSequence sequence(outline);
  set_all(sequence, entity, placement);
  return sequence.finish();
}

Change add_placement(const Outline& outline, const Placement& placement) {
  if (auto fault = fault_of(placement)) return refused(*std::move(fault));
  if (auto fault = fault_here(read_placement(outline, 0), placement))
    return refused(*std::move(fault));
  const Change added = add_include(outline, placement.file);
  if (!added.is_made()) return added;
  EditSequence sequence(outline);
  sequence.apply(added);
  // What is new is the first include from there on: nothing before it has changed.
  const auto& entities = sequence.now().entities();
  const uint32_t begin = added.edits.front().range.begin;
  const auto made = std::find_if(entities.begin(), entities.end(), [&](const Entity& each) {
    return each.kind == EntityKind::include && each.range.begin >= begin;
  });
  if (made != entities.end())
    set_all(sequence, static_cast<int>(made - entities.begin()), placement);
  return sequence.finish();
}

}  // namespace tessera::edit
