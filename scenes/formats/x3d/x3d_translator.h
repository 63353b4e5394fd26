#pragma once

#include <map>
#include <set>
#include <string>
#include <tuple>

#include "scenes/formats/x3d/x3d_document.h"
#include "scenes/formats/x3d/x3d_polygons.h"
#include "scenes/formats/x3d/x3d_values.h"
#include "scenes/import/loaded_scene.h"
#include "scenes/import/warnings.h"

namespace tessera {

/// Turns the nodes of an X3D document into a scene.
class X3dTranslator {
 public:
  X3dTranslator(const X3dDocument& document, const ReadOptions& options)
      : document_(document), options_(options), values_(document, warnings_) {}

  LoadedScene translate(const std::string& file);

 private:
  using Nodes = google::protobuf::RepeatedPtrField<v1::Node>;

  // The graph (x3d_graph.cpp). `path` leads from the frame of the children to the world.
  void add_children(const X3dNode& parent, const v1::Transform& path, Nodes& out);
  void add_node(const X3dNode& node, const v1::Transform& path, Nodes& out);
  void add_instance(const X3dNode& node, const v1::Transform& path, Nodes& out);
  void fill_node(const X3dNode& node, const v1::Transform& path, v1::Node& out);
  v1::Transform transform(const X3dNode& node) const;
  void check_names();
  void list_ignored();

  // Cameras, lights and what surrounds the scene (x3d_view.cpp).
  void add_camera(const X3dNode& node, const v1::Transform& path);
  void add_light(const X3dNode& node, Nodes& out);
  void set_background(const X3dNode& node, const v1::Transform& path);
  void set_fog(const X3dNode& node);
  void finish_cameras();
  void set_settings();
  void set_metadata(const std::string& file);

  // Shapes and materials (x3d_shapes.cpp).
  void add_shape(const X3dNode& node, v1::Node& out);
  bool set_geometry(const X3dNode& geometry, v1::Shape& shape);
  std::string material(const X3dNode* appearance, bool two_sided, bool vertex_colors);
  v1::Material make_material(const X3dNode* node, bool vertex_colors);
  v1::Material make_unlit(const X3dNode& node);
  v1::Material make_physical(const X3dNode& node);
  const X3dMesh& mesh(const X3dNode& geometry);

  std::string unique(std::set<std::string>& taken, const std::string& wish);
  void put(const Color& color, v1::Color* out) const;

  const X3dDocument& document_;
  const ReadOptions& options_;
  Warnings warnings_;
  X3dValues values_;
  LoadedScene out_;

  std::map<const X3dNode*, std::string> objects_;  ///< by what is used more than once
  std::map<const X3dNode*, X3dMesh> meshes_;
  std::map<std::tuple<const X3dNode*, bool, bool>, std::string> materials_;
  std::set<std::string> object_names_, material_names_, camera_names_;
  const X3dNode* navigation_ = nullptr;
};

}  // namespace tessera
