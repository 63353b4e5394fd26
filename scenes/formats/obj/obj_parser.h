#pragma once

#include <cstdint>
#include <map>
#include <optional>
#include <string>
#include <vector>

#include "renderer/math/vec.h"
#include "scenes/formats/obj/line_reader.h"
#include "scenes/formats/obj/obj_mesh.h"
#include "scenes/import/warnings.h"
#include "scenes/mesh/triangulate.h"

namespace tessera {

/// What the statements of an OBJ file say (Wavefront's format, appendix B of the Advanced
/// Visualizer manual), polygons only. One pass; the mesh refers to materials by their place in
/// `materials`.
struct ObjFile {
  ObjMesh mesh;
  /// A name, and where the file first says it.
  struct Reference {
    std::string name;
    SourcePlace place{};
  };
  std::vector<Reference> materials;  ///< in the order of use; "" where no usemtl came before
  std::vector<Reference> libraries;  ///< the text after each mtllib
};

/// What cannot be read is left out with a warning. Throws scene_error with the place of the first
/// such part where no triangle is left, of a file without vertices that has unknown statements, and
/// of a file beyond our bounds. A file of nothing but other statements is an empty mesh.
class ObjParser {
 public:
  ObjParser(LineReader& reader, Warnings& warnings) : in_(reader), warnings_(warnings) {}
  ObjFile parse();

 private:
  void statement(std::string_view keyword);
  /// A number, or `instead` of one that is not finite, with a warning that says so.
  float finite(const char* what, float instead, std::string_view taken);
  float checked(float value, const char* what, float instead, std::string_view taken);
  /// Warns of what breaks a rule where the reader is, and of what is taken for it.
  void repair(std::string_view found, std::string_view expected, std::string_view taken);
  /// The same of a part that faces are lost with.
  void leave_out(std::string_view found, std::string_view expected, std::string_view taken);
  bool is_placed() const;
  void vertex();
  void texture_coordinate();
  void normal();
  void face();
  void smoothing();
  void use_material();
  void skip(std::string_view keyword);
  /// Adds a corner to polygon_. False where it cannot be read.
  bool corner();
  /// kNoIndex where the index refers to nothing.
  uint32_t reference(const char* what, size_t count, std::string_view taken);
  void add_polygon();
  uint32_t current_material();

  LineReader& in_;
  Warnings& warnings_;
  ObjFile file_;
  std::map<std::string, uint32_t, std::less<>> material_index_;
  uint32_t material_ = kNoIndex;
  uint32_t smoothing_group_ = 0;            ///< 0: off
  std::optional<Error> problem_;            ///< what is wrong with the first part that was left out
  std::optional<Error> unknown_statement_;  ///< what the first one means in a file without vertices
  std::vector<MeshCorner> polygon_;
  std::vector<Vec3> points_;
  std::vector<CornerTriple> triples_;
};

}  // namespace tessera
