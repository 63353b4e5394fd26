#include <fmt/format.h>

#include "bench/skip.h"
#include "proto/wire/scene_codec.h"
#include "scenes/generate/generate_scene.h"
#include "scenes/mesh/mesh_data.h"

namespace tessera {
namespace {

constexpr int kUnneeded = 1000;

constexpr char kBase[] =
    "settings { width: 640 height: 480 }\n"
    "cameras { world_from_camera { steps { look_at { eye { x: 2 y: 1.5 z: 3 } } } } }\n"
    "nodes { light { directional { direction { x: -1 y: -2 z: -1 } } } }\n"
    "nodes { light { intensity: .3 point { position { x: 3 y: 3 z: 3 } } } }\n"
    "nodes { light { intensity: .3 point { position { x: -3 y: 3 z: 3 } } } }\n"
    "materials { name: 'ground' sides: FRONT_ONLY classic { } }\n"
    "materials { name: 'bare' unlit { color { value { r: .5 } } } }\n"
    "nodes { shape { materials: 'ground' plane { offset: -1 } } }\n";

/// A mesh beside the spheres, whose material reads none of its attributes.
MeshData bare_mesh() {
  MeshData mesh = icosphere(4, false);
  for (float& coordinate : mesh.positions) coordinate *= .4F;
  return mesh;
}

void set_mesh(v1::Shape& shape, MeshData mesh, BlobStore& blobs) {
  *shape.mutable_mesh() = store_mesh(std::move(mesh), blobs);
}

v1::Node& add_sphere(LoadedScene& scene, double x, double y, double z, double radius) {
  v1::Node& node = *scene.scene.add_nodes();
  v1::Sphere& sphere = *node.mutable_shape()->mutable_sphere();
  sphere.mutable_center()->set_x(x);
  sphere.mutable_center()->set_y(y);
  sphere.mutable_center()->set_z(z);
  sphere.set_radius(radius);
  return node;
}

v1::Light& add_light(LoadedScene& scene, int number) {
  v1::Light& light = *scene.scene.add_nodes()->mutable_light();
  v1::Vec3& position = *light.mutable_point()->mutable_position();
  position.set_x(.01 * number - 5);
  position.set_y(1);
  position.set_z(60);
  return light;
}

void add_materials(LoadedScene& scene) {
  for (int i = 0; i < kUnneeded; ++i) {
    v1::Material& material = *scene.scene.add_materials();
    material.set_name(fmt::format("unused{}", i));
    material.mutable_classic()->mutable_reflectivity()->mutable_value()->set_r(.5);
  }
}

void add_textures(LoadedScene& scene) {
  for (int i = 0; i < kUnneeded; ++i) {
    v1::Texture& texture = *scene.scene.add_textures();
    texture.set_name(fmt::format("unused{}", i));
    texture.mutable_noise()->set_octaves(4);
  }
}

void add_cameras(LoadedScene& scene) {
  for (int i = 0; i < kUnneeded; ++i) {
    v1::Camera& camera = *scene.scene.add_cameras();
    camera.set_name(fmt::format("unused{}", i));
    camera.mutable_lens()->set_radius_x(.1);
  }
}

void add_objects(LoadedScene& scene) {
  for (int i = 0; i < kUnneeded; ++i) {
    v1::Object& object = *scene.scene.add_objects();
    object.set_name(fmt::format("unused{}", i));
    object.add_nodes()->mutable_shape()->mutable_sphere()->set_radius(9);
  }
}

void add_black_lights(LoadedScene& scene) {
  for (int i = 0; i < kUnneeded; ++i) add_light(scene, i).set_intensity(0);
}

void add_distant_lights(LoadedScene& scene) {
  for (int i = 0; i < kUnneeded; ++i) add_light(scene, i).set_radius(.5);
}

void add_hidden_nodes(LoadedScene& scene) {
  for (int i = 0; i < kUnneeded; ++i) add_sphere(scene, 0, 0, 0, 2).set_hidden(true);
}

void add_shapes_behind_the_camera(LoadedScene& scene) {
  for (int i = 0; i < kUnneeded; ++i) add_sphere(scene, .02 * i - 10, 0, 60 + i % 7, .2);
}

void add_meshes_behind_the_camera(LoadedScene& scene) {
  for (int i = 0; i < kUnneeded; ++i) {
    v1::Node& node = *scene.scene.add_nodes();
    v1::Vec3& step = *node.mutable_transform()->add_steps()->mutable_translate();
    step.set_x(.02 * i - 10);
    step.set_z(60 + i % 7);
    set_mesh(*node.mutable_shape(), bare_mesh(), scene.blobs);
  }
}

void add_attributes(LoadedScene& scene) {
  MeshData mesh = bare_mesh();
  mesh.normals = mesh.positions;
  mesh.uvs.assign(2 * mesh.vertex_count(), .5F);
  for (v1::Node& node : *scene.scene.mutable_nodes()) {
    if (node.shape().has_mesh()) set_mesh(*node.mutable_shape(), mesh, scene.blobs);
  }
}

}  // namespace

LoadedScene skip_bench_scene() {
  SceneWithBlobs read = decode_scene(kBase, SceneEncoding::text, "bench skip");
  LoadedScene scene{std::move(read.scene), std::move(read.blobs)};
  for (int z = 0; z < 6; ++z)
    for (int y = 0; y < 6; ++y)
      for (int x = 0; x < 6; ++x) add_sphere(scene, -1 + .4 * x, -1 + .4 * y, -1 + .4 * z, .15);
  v1::Node& node = *scene.scene.add_nodes();
  node.mutable_transform()->add_steps()->mutable_translate()->set_x(1.7);
  node.mutable_shape()->add_materials("bare");
  set_mesh(*node.mutable_shape(), bare_mesh(), scene.blobs);
  return scene;
}

const std::vector<UnneededKind>& unneeded_kinds() {
  static const std::vector<UnneededKind> kinds{
      {"materials",
       "materials that no shape names",
       add_materials,
       {"materials_total", "-materials_used"}},
      {"textures", "textures that no material names", add_textures, {"textures_skipped"}},
      {"cameras", "cameras that do not take the picture", add_cameras},
      {"objects", "objects without an instance", add_objects},
      {"black-lights", "lights of intensity 0", add_black_lights, {"lights_dark"}},
      {"distant-lights",
       "lights that do not reach the scene",
       add_distant_lights,
       {"lights_culled"}},
      {"hidden-nodes", "nodes that are hidden", add_hidden_nodes},
      {"shapes-behind", "spheres behind the camera", add_shapes_behind_the_camera},
      {"meshes-behind",
       "meshes behind the camera",
       add_meshes_behind_the_camera,
       {"mesh_builds_deferred", "-meshes_built_when_hit"}},
      {"attributes",
       "vertices with normals and texture coordinates",
       add_attributes,
       {"attributes_dropped"}},
  };
  return kinds;
}

}  // namespace tessera
