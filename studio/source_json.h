#pragma once

#include <nlohmann/json.hpp>
#include <string>
#include <unordered_map>
#include <vector>

#include "scenes/edit/edit.h"
#include "scenes/edit/placement.h"
#include "scenes/edit/vocabulary.h"
#include "studio/files/document.h"

namespace tessera {

// What scenes/edit tells of a text, as pages are told. The outline must be that of
// document.text().

/// What pages call the entities of an outline: their paths, with a number behind those that are
/// there twice. Stays the same while texts change elsewhere.
class EntityIds {
 public:
  explicit EntityIds(const edit::Outline& outline);
  const std::string& of(int entity) const { return ids_[static_cast<size_t>(entity)]; }
  /// -1: there is no such entity.
  int find(const std::string& id) const;

 private:
  std::vector<std::string> ids_;
  std::unordered_map<std::string, int> entities_;
};

/// Without the fields of the entities, and of the first 50,000 entities alone: all would be many
/// megabytes for a large scene.
nlohmann::json outline_json(const edit::Outline& outline, const EntityIds& ids);
nlohmann::json field_json(const edit::Field& field, const Document& document);
/// With the names of the materials that it can have, where the language lets it have one.
nlohmann::json placement_json(const edit::WrittenPlacement& read, const edit::Outline& outline);
/// [[from, to, text], ...]
nlohmann::json changes_json(const std::vector<edit::TextEdit>& edits, const Document& document);
nlohmann::json completions_json(const edit::Completions& completions, const Document& document);
nlohmann::json hover_json(const edit::Hover& hover, const Document& document);

}  // namespace tessera
