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
  std::vector<std::string>
      materials;  ///< names in the order of use; "" where no usemtl came before
  std::vector<std::string> libraries;  ///< the text after each mtllib
};

/// Throws scene_error with the place of what cannot be read.
class ObjParser {
 public:
  ObjParser(LineReader& reader, Warnings& warnings) : in_(reader), warnings_(warnings) {}
  ObjFile parse();

 private:
  void statement(std::string_view keyword);
  /// A number, or `instead` of one that is not finite, with a warning that says so.
  float finite(const char* what, float instead, std::string_view taken);
  float checked(float value, const char* what, float instead, std::string_view taken);
  bool is_placed() const;
  void vertex();
  void texture_coordinate();
  void normal();
  void face();
  void smoothing();
  void use_material();
  void skip(std::string_view keyword);
  MeshCorner corner();
  uint32_t reference(const char* what, size_t count);
  void add_polygon();
  uint32_t current_material();

  LineReader& in_;
  Warnings& warnings_;
  ObjFile file_;
  std::map<std::string, uint32_t, std::less<>> material_index_;
  uint32_t material_ = kNoIndex;
  uint32_t smoothing_group_ = 0;   ///< 0: off
  std::optional<Error> unplaced_;  ///< of the first vertex that is nowhere
  std::vector<MeshCorner> polygon_;
  std::vector<Vec3> points_;
  std::vector<CornerTriple> triples_;
};

}  // namespace tessera
