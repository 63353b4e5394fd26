#include "query/geometry_only.h"

#include "renderer/scene/scene_graph.h"

namespace tessera {
namespace {

/// Deeper nodes are left as they are: build_scene() refuses them.
void darken(google::protobuf::RepeatedPtrField<v1::Node>& nodes, int depth) {
  if (depth > kMaxNodeDepth) return;
  for (v1::Node& node : nodes) {
    node.clear_light();
    node.clear_casts_no_shadow();
    darken(*node.mutable_children(), depth + 1);
  }
}

}  // namespace

v1::Scene geometry_only(const v1::Scene& scene) {
  v1::Scene out = scene;
  out.clear_metadata();
  out.mutable_settings()->clear_sampling();
  out.mutable_settings()->clear_integrator();
  out.mutable_settings()->clear_output();
  out.clear_background();
  out.clear_fog();
  out.clear_textures();
  for (v1::Material& material : *out.mutable_materials()) {
    const std::string name = material.name();
    material.Clear();
    material.set_name(name);
  }
  for (v1::Camera& camera : *out.mutable_cameras()) camera.clear_headlight();
  for (v1::Object& object : *out.mutable_objects()) darken(*object.mutable_nodes(), 0);
  darken(*out.mutable_nodes(), 0);
  return out;
}

v1::FrameSettings geometry_only(const v1::FrameSettings& frame) {
  v1::FrameSettings out;
  out.set_width(frame.width());
  out.set_height(frame.height());
  out.set_camera(frame.camera());
  out.set_time(frame.time());
  out.set_accelerator(frame.accelerator());
  out.set_integrator("whitted");
  return out;
}

}  // namespace tessera
