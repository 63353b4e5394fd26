#include "scenes/generate/generate_forest.h"

#include <fmt/format.h>

#include <array>
#include <cmath>

#include "renderer/math/elementary.h"
#include "scenes/generate/put.h"
#include "scenes/generate/random.h"

namespace tessera {
namespace {

std::string add_material(v1::Scene& scene, const char* name, double r, double g, double b) {
  v1::Material& material = *scene.add_materials();
  material.set_name(name);
  put(r, g, b, material.mutable_classic()->mutable_diffuse()->mutable_value());
  return name;
}

void add_vertex(MeshData& mesh, const Vec3& p) {
  for (int a = 0; a < 3; ++a) mesh.positions.push_back(static_cast<float>(p[a]));
}

/// A prism without ends.
void add_trunk(MeshData& mesh, uint32_t sides) {
  for (uint32_t s = 0; s < sides; ++s) {
    const double turn = 2 * portable::kPi * s / sides;
    const Vec3 out{portable::cos(turn), 0, portable::sin(turn)};
    add_vertex(mesh, out * 0.03);
    add_vertex(mesh, out * 0.015 + Vec3{0, 0.6, 0});
  }
  for (uint32_t s = 0; s < sides; ++s) {
    const uint32_t a = 2 * s, b = 2 * ((s + 1) % sides);
    mesh.triangles.insert(mesh.triangles.end(), {a, a + 1, b, b, a + 1, b + 1});
    mesh.face_materials.insert(mesh.face_materials.end(), {0, 0});
  }
}

/// Somewhere on the hull of a crown that is widest at a third of its height.
Vec3 place_of_leaf(Random& random) {
  const double up = random.uniform(), turn = 2 * portable::kPi * random.uniform();
  const double wide = up < 1.0 / 3 ? std::sqrt(3 * up) : 1.5 * (1 - up);
  const double r = 0.3 * wide * std::sqrt(0.4 + 0.6 * random.uniform());
  return {r * portable::cos(turn), 0.2 + 0.8 * up, r * portable::sin(turn)};
}

void add_object(LoadedScene& out, const std::string& name, const std::string& leaves,
                uint64_t seed) {
  v1::Object& object = *out.scene.add_objects();
  object.set_name(name);
  v1::Shape& shape = *object.add_nodes()->mutable_shape();
  shape.add_materials("bark");
  shape.add_materials(leaves);
  *shape.mutable_mesh() = store_mesh(tree_mesh(seed), out.blobs);
}

void add_ground_and_light(LoadedScene& out, double half) {
  v1::Shape& ground = *out.scene.add_nodes()->mutable_shape();
  ground.add_materials(add_material(out.scene, "ground", .25, .2, .12));
  put(-2 * half, 0, 2 * half, ground.mutable_rectangle()->mutable_corner());
  put(4 * half, 0, 0, ground.mutable_rectangle()->mutable_edge_u());
  put(0, 0, -4 * half, ground.mutable_rectangle()->mutable_edge_v());
  put(-1, -1.5, -.6,
      out.scene.add_nodes()->mutable_light()->mutable_directional()->mutable_direction());
  v1::Background::Gradient& gradient = *out.scene.mutable_background()->mutable_gradient();
  gradient.mutable_sky()->set_r(.35);
  gradient.mutable_sky()->set_g(.5);
  gradient.mutable_sky()->set_b(.75);
  gradient.mutable_ground()->set_r(.6);
  gradient.mutable_ground()->set_g(.65);
  gradient.mutable_ground()->set_b(.7);
  v1::LookAt& look =
      *out.scene.add_cameras()->mutable_world_from_camera()->add_steps()->mutable_look_at();
  put(0, 2 + 0.15 * half, 1.1 * half + 1, look.mutable_eye());
  put(0, 0, 0.3 * half, look.mutable_target());
  out.scene.mutable_cameras(0)->mutable_perspective()->set_field_of_view(45);
}

}  // namespace

MeshData tree_mesh(uint64_t seed) {
  Random random(seed);
  MeshData mesh;
  add_trunk(mesh, 16);
  while (mesh.triangle_count() < kTreeTriangles) {
    const Vec3 at = place_of_leaf(random);
    const auto first = static_cast<uint32_t>(mesh.vertex_count());
    for (int k = 0; k < 3; ++k) add_vertex(mesh, at + random.in_cube() * 0.006);
    mesh.triangles.insert(mesh.triangles.end(), {first, first + 1, first + 2});
    mesh.face_materials.push_back(1);
  }
  return mesh;
}

LoadedScene forest(uint32_t trees) {
  LoadedScene out;
  add_material(out.scene, "bark", .3, .2, .12);
  const std::array names{std::string("fir"), std::string("birch")};
  add_object(out, names[0], add_material(out.scene, "needles", .12, .3, .1), 1);
  add_object(out, names[1], add_material(out.scene, "leaves", .35, .5, .12), 2);
  Random random(trees);
  const auto side = static_cast<uint32_t>(std::ceil(std::sqrt(static_cast<double>(trees))));
  for (uint32_t i = 0; i < trees; ++i) {
    v1::Node& node = *out.scene.add_nodes();
    node.set_instance_of(names[random.bits() % names.size()]);
    const Vec3 off = random.in_cube() * 0.3;
    auto& steps = *node.mutable_transform()->mutable_steps();
    const uint32_t row = i / side, column = i % side;
    put(column + .5 - .5 * side + off.x, 0, row + .5 - .5 * side + off.z,
        steps.Add()->mutable_translate());
    v1::AxisAngle& turn = *steps.Add()->mutable_rotate();
    put(0, 1, 0, turn.mutable_axis());
    turn.set_angle(360 * random.uniform());
    const double size = 1 + off.y;
    put(size, size * (1 + .3 * random.uniform()), size, steps.Add()->mutable_scale());
  }
  add_ground_and_light(out, .5 * side);
  return out;
}

}  // namespace tessera
