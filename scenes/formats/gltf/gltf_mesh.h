#pragma once

#include <map>
#include <string>
#include <utility>
#include <vector>

#include "renderer/math/bounds.h"
#include "scenes/formats/gltf/gltf_accessor.h"
#include "scenes/formats/gltf/gltf_material.h"
#include "scenes/formats/gltf/gltf_skin.h"
#include "scenes/import/loaded_scene.h"
#include "scenes/import/warnings.h"
#include "scenes/mesh/pen.h"

namespace tessera {

/// Turns meshes of a glTF file into shapes. Primitives over the same vertices become one shape with
/// a material for each of its triangles; points and lines are drawn by a pen.
class GltfMeshes {
 public:
  GltfMeshes(GltfFile& file, GltfMaterials& materials, LoadedScene& out, Warnings& warnings)
      : file_(file), materials_(materials), out_(out), warnings_(warnings) {}

  /// How much of each morph target is added; empty: nothing of any.
  using Weights = std::vector<double>;
  /// A number for those of a node that shows mesh `index`, else the mesh's own: the same for equal
  /// ones. The mesh's are read once, however many nodes show it.
  size_t weights(const GltfValue& node, size_t index);
  /// Warns of the attributes that no primitive so far was read with.
  void list_unused_attributes();
  /// Whether any primitive of mesh `index` is points or lines, which need a pen.
  bool has_strokes(size_t index);
  /// Of the positions of mesh `index` as they stand in its accessors.
  Bounds3 bounds(size_t index);
  /// A node for each shape of mesh `index` by the weights of that number, with their data among the
  /// scene's blobs: in the mesh's frame, or bent by a skin in the world's.
  std::vector<v1::Node> read(size_t index, size_t weights, const GltfSkin* skin, const Pen& pen);

 private:
  /// Where the numbers of a primitive's vertices stand: accessors' values, empty where there is
  /// none.
  struct Attributes {
    GltfValue position, normal, uv, second_uv, color, tangent;
    std::vector<std::pair<GltfValue, double>> targets;        ///< with their weights
    std::vector<std::pair<GltfValue, GltfValue>> influences;  ///< joints with their weights
    std::string key() const;                                  ///< equal for equal accessors
  };
  struct Group;

  /// Whether the primitive's accessors have something to read: unpacks it where it is compressed.
  bool unpack(const GltfValue& primitive);
  uint64_t mode_of(const GltfValue& primitive);
  size_t number_of(const GltfValue& weights);
  Attributes attributes_of(const GltfValue& primitive, const GltfMaterialUse& material,
                           const Weights& weights, bool is_bent);
  void add(const GltfValue& primitive, const GltfMaterialUse& material, Group& group);
  /// Nothing where no triangle is left.
  std::optional<v1::Node> finish(Group& group, const GltfSkin* skin, const Pen& pen);
  /// Of an attribute; empty where there is none, or not one row of at least `least` numbers for
  /// each vertex. A colour may be without alpha.
  std::vector<float> rows(const GltfValue& reference, size_t width, const Group& group,
                          size_t least = 3);
  /// The same with `instead` for rows that are not finite.
  std::vector<float> finite_rows(const GltfValue& reference, size_t width, float instead,
                                 const Group& group, size_t least = 3);
  /// Of those that can be read, without the weights of joints that are not there.
  std::vector<GltfInfluences> influences(const Group& group, size_t joint_count);
  /// The first three of each `width` numbers are what the targets move.
  void add_targets(const char* attribute, const Group& group, std::vector<float>& to,
                   size_t width = 3);

  GltfFile& file_;
  GltfMaterials& materials_;
  LoadedScene& out_;
  Warnings& warnings_;
  std::map<std::string, bool> attributes_;  ///< whether it was ever used
  std::map<Weights, size_t> weights_;       ///< their numbers
  std::vector<const Weights*> by_number_;
  std::map<size_t, size_t> own_weights_;  ///< numbers by mesh
  std::map<size_t, Bounds3> boxes_;       ///< by accessor
  std::map<std::string, bool> unpacked_;  ///< primitives by path, whether that could be done
};

}  // namespace tessera
