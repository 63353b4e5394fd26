#pragma once

#include <cstdint>
#include <memory>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "scenes/edit/source_text.h"

namespace tessera::edit {

/// The languages of scenes that are edited as text.
enum class Language : uint8_t { tessera, json, crt, x3d, classic_x3d, obj, mtl, gltf };

/// By the ending of a file's name, in any case; nothing for what is not edited as text.
std::optional<Language> language_of(std::string_view path);

enum class EntityKind : uint8_t {
  scene,
  metadata,
  settings,
  camera,
  background,
  fog,
  light,
  material,
  texture,
  object,
  node,
  shape,
  step,  ///< of a transform, modifier
  key,   ///< of an animation
  include,
  blob,
  variable,
  macro,
  call,
  group,  ///< what holds others and is nothing by itself
  other,
};
std::string_view name_of(EntityKind kind);

enum class ValueKind : uint8_t {
  number,
  integer,
  vector,
  color,
  choice,
  text,
  boolean,
  file,
  reference,   ///< the name of another entity
  list,        ///< several values of one kind
  expression,  ///< computed; not set as it stands
  data,        ///< bytes; shown, never set
};
std::string_view name_of(ValueKind kind);

/// What a number may be. `unit` and `fallback` are also those of other fields.
struct FieldLimits {
  std::optional<double> least, most;
  bool above_least = false, below_most = false;  ///< the limit itself is not allowed

  bool allows(double value) const;
  /// "above 0 and below 180"; empty where everything is allowed.
  std::string str() const;
};

struct Field {
  /// A dotted path within the entity: "sphere.radius", "materials[0]".
  std::string name;
  ValueKind kind = ValueKind::text;
  SourceRange range;  ///< name and value; empty where the text does not have it
  SourceRange value;
  /// The literal that is set in place of `value`, where a variable stands for it; else empty.
  SourceRange literal;
  /// The value for people: without quotes; vectors as numbers between blanks. The default where the
  /// text does not have it.
  std::string text;
  bool is_present = true;
  std::string fallback, unit, help;
  FieldLimits limits;
  std::vector<std::string> choices;
  int32_t syntax = -1;  ///< the node of the value in the syntax tree, where the language has one
  /// How many values come from the literal that is set; more than one of a variable.
  int uses = 1;
  /// Why set_field refuses; empty where it does not.
  std::string locked;
};

/// Something of a scene that its text describes in one piece.
struct Entity {
  int parent = -1;
  EntityKind kind = EntityKind::other;
  std::string name{};  ///< empty where it has none
  std::string type{};  ///< "sphere", "Material", "classic"
  /// Where its message stands in the scene: "nodes[3].shape"; of other languages its place in the
  /// source as indices among siblings: "Scene.Sphere[2]".
  std::string path{};
  SourceRange range{};
  SourceRange body{};           ///< between its brackets
  uint32_t syntax = 0;          ///< the node of the syntax tree
  std::vector<Field> fields{};  ///< those that the text has, in its order
};

class SyntaxTree;

/// What a text describes, as far as it can be told. Entities stand before those inside of them; the
/// first is the scene itself. Never changes.
class Outline {
 public:
  Outline(Language language, std::string text, std::shared_ptr<const SyntaxTree> tree,
          std::vector<Entity> entities);

  Language language() const { return language_; }
  const std::string& text() const { return text_; }
  const SyntaxTree& tree() const { return *tree_; }
  const std::vector<Entity>& entities() const { return entities_; }

  /// The innermost entity that `offset` is in.
  int entity_at(size_t offset) const;
  /// The entity of that path, or the innermost that holds it: "nodes[3].shape.sphere" gives
  /// "nodes[3].shape". Nothing where no entity but the scene does.
  std::optional<int> entity_of_path(std::string_view path) const;
  /// The first of that kind and name.
  std::optional<int> entity_named(EntityKind kind, std::string_view name) const;

 private:
  Language language_;
  std::string text_;
  std::shared_ptr<const SyntaxTree> tree_;
  std::vector<Entity> entities_;
};

/// Longer texts have an outline of the scene alone.
inline constexpr size_t kMaxOutlineBytes = size_t{64} << 20;
/// Nothing deeper than this is told apart.
inline constexpr int kMaxOutlineDepth = 200;

/// Never throws for what is wrong with the text; takes time linear in its length.
Outline outline(Language language, std::string text);

/// All fields that the entity may have, in the order of the schema, those included that the text
/// does not have.
std::vector<Field> all_fields(const Outline& outline, int entity);

}  // namespace tessera::edit
