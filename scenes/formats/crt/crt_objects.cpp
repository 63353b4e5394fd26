#include "scenes/formats/crt/crt_objects.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>

#include "renderer/math/elementary.h"

namespace tessera {
namespace {

CrtValue make_material(CrtAttributes& in, CrtHeap& heap) {
  CrtMaterial made;
  v1::Classic& classic = *made.message.mutable_classic();
  Color color = kWhite;
  const CrtAttribute* given = in.find("color");
  if (given && holds<const CrtTexture*>(given->value))
    made.color = std::get<const CrtTexture*>(given->value);
  else
    color = in.color("color");
  const double reflectivity = in.number("reflectivity", kCrtShare, 0);
  const double specular = in.number("specular", kCrtNotNegative, 0);
  const double transparency = in.number("transparency", kCrtShare, 0);
  put(kWhite * (1 - reflectivity), classic.mutable_ambient()->mutable_value());
  put(color * (1 - reflectivity), classic.mutable_diffuse()->mutable_value());
  classic.set_diffuse_model(v1::Classic::SIGNED);
  if (specular > 0) {
    put(color * specular, classic.mutable_specular()->mutable_value());
    classic.set_specular_model(v1::Classic::PHONG);
  }
  classic.mutable_shininess()->set_value(in.number("shininess", kCrtNotNegative, 3));
  if (reflectivity > 0) put(kWhite * reflectivity, classic.mutable_reflectivity()->mutable_value());
  const double index = in.number("refractIndex", kCrtPositive, 1);
  if (transparency > 0) {
    classic.mutable_transparency()->set_value(transparency);
    classic.set_refractive_index(index);
  }
  const Color absorption = in.color("absorption", kBlack);
  if (std::min({absorption.r, absorption.g, absorption.b}) < 0)
    in.wrong(*in.find("absorption"), "a colour without negative parts");
  if (!is_black(absorption)) put(absorption, classic.mutable_absorption());
  made.bump = in.thing<CrtTexture>("bump", "a texture", false);
  made.bump_height = in.number("bumpheight", {}, 0.1);
  if (!in.finish()) return CrtFailed{};
  return heap.add(std::move(made), in.where());
}

CrtValue make_background(CrtAttributes& in, CrtHeap& heap) {
  CrtBackground made;
  const double angle = in.number("angle", {}, 0);
  if (in.has("image")) {
    made.image = in.text("image", "");
    made.image_span = in.find("image")->value_span;
    v1::Background::Panorama& panorama = *made.message.mutable_panorama();
    panorama.set_mapping(v1::Background::Panorama::CYLINDRICAL_EQUAL_AREA);
    // The description turns by the right-hand rule, before the world is mirrored.
    panorama.set_angle(-portable::degrees(angle));
    in.find("horizon"), in.find("sky"), in.find("color");
  } else if (in.has("horizon") && in.has("sky")) {
    v1::Background::Gradient& gradient = *made.message.mutable_gradient();
    gradient.set_model(v1::Background::Gradient::ABSOLUTE_Y);
    put(in.color("sky"), gradient.mutable_sky());
    put(in.color("horizon"), gradient.mutable_ground());
    in.find("color");
  } else {
    put(in.color("color"), made.message.mutable_solid());
  }
  if (!in.finish()) return CrtFailed{};
  return heap.add(std::move(made), in.where());
}

CrtValue make_checker(CrtAttributes& in, CrtHeap& heap) {
  CrtTexture made;
  v1::Texture& texture = made.message;
  texture.set_mapping(v1::Texture::OBJECT);
  put(in.color("odd", kBlack), texture.mutable_checker()->mutable_odd()->mutable_value());
  put(in.color("even", kWhite), texture.mutable_checker()->mutable_even()->mutable_value());
  const double size = in.number("size", kCrtPositive, 1);
  put(Vec3{1, 1, 1} * (1 / size), texture.mutable_transform()->add_steps()->mutable_scale());
  if (!in.finish()) return CrtFailed{};
  return heap.add(std::move(made), in.where());
}

CrtValue make_noise(v1::Texture::Noise::Kind kind, CrtAttributes& in, CrtHeap& heap) {
  CrtTexture made;
  v1::Texture& texture = made.message;
  texture.set_mapping(v1::Texture::OBJECT);
  v1::Texture::Noise& noise = *texture.mutable_noise();
  noise.set_kind(kind);
  put(in.color("low", kBlack), noise.mutable_low());
  put(in.color("high", kWhite), noise.mutable_high());
  noise.set_frequency(in.number("frequency", kCrtPositive, 1));
  noise.set_strength(in.number("strength", kCrtNotNegative, 1));
  constexpr int32_t kMostOctaves = 16;
  const int32_t octaves = in.integer("octaves", 1);
  if (octaves < 1 || octaves > kMostOctaves)
    in.wrong(*in.find("octaves"), fmt::format("1 to {}", kMostOctaves));
  noise.set_octaves(static_cast<uint32_t>(std::clamp(octaves, 1, kMostOctaves)));
  if (!in.finish()) return CrtFailed{};
  return heap.add(std::move(made), in.where());
}

constexpr std::array<std::string_view, 25> kObjects{
    "Camera",    "PointLight", "ParallelLight", "SpotLight",    "CylinderLight",
    "Material",  "Background", "Sphere",        "Box",          "Plane",
    "HalfPlane", "Disc",       "Triangle",      "Cylinder",     "Cone",
    "Torus",     "Mesh",       "Checker",       "Noise",        "Turbulence",
    "Marble",    "Wood",       "Union",         "Intersection", "Difference"};

}  // namespace

void put(const Vec3& from, v1::Vec3* to) {
  to->set_x(from.x);
  to->set_y(from.y);
  to->set_z(from.z);
}

void put(const Color& from, v1::Color* to) {
  to->set_r(from.r);
  to->set_g(from.g);
  to->set_b(from.b);
}

bool is_crt_object(std::string_view name) {
  return std::find(kObjects.begin(), kObjects.end(), name) != kObjects.end();
}

std::vector<std::string> crt_object_names() { return {kObjects.begin(), kObjects.end()}; }

CrtValue make_crt_object(std::string_view name, CrtAttributes& attributes, CrtHeap& heap) {
  if (name == "Camera") return make_crt_camera(attributes, heap);
  if (name.ends_with("Light")) return make_crt_light(name, attributes, heap);
  if (name == "Material") return make_material(attributes, heap);
  if (name == "Background") return make_background(attributes, heap);
  if (name == "Checker") return make_checker(attributes, heap);
  if (name == "Noise") return make_noise(v1::Texture::Noise::PERLIN, attributes, heap);
  if (name == "Turbulence") return make_noise(v1::Texture::Noise::TURBULENCE, attributes, heap);
  if (name == "Marble") return make_noise(v1::Texture::Noise::MARBLE, attributes, heap);
  if (name == "Wood") return make_noise(v1::Texture::Noise::WOOD, attributes, heap);
  return make_crt_shape(name, attributes, heap);
}

}  // namespace tessera
