#include "scenes/edit/crt_words.h"

#include <array>

namespace tessera::edit {
namespace {

using W = CrtAttributeWord;
constexpr ValueKind kNumber = ValueKind::number, kInteger = ValueKind::integer,
                    kVector = ValueKind::vector, kColor = ValueKind::color, kText = ValueKind::text,
                    kReference = ValueKind::reference;
constexpr FieldLimits kAny{};
constexpr FieldLimits kNotNegative{.least = 0, .most = {}};
constexpr FieldLimits kPositive{.least = 0, .most = {}, .above_least = true};
constexpr FieldLimits kShare{.least = 0, .most = 1};
constexpr FieldLimits kAngle{.least = 0, .most = 180, .above_least = true};

constexpr FieldLimits whole(double least, double most) { return {.least = least, .most = most}; }

constexpr W kMaterial{"material", kReference, "", "what the surface is made of", "", kAny, ""};
constexpr W kCenter{"center", kVector, "", "", "", kAny, ""};
constexpr W kRadius{"radius", kNumber, "", "", "", kPositive, ""};
constexpr W kUp{"normal", kVector, "0 1 0", "the direction of its axis", "", kAny, ""};
constexpr W kLightColor{"color", kColor, "", "of the light", "", kAny, ""};
constexpr W kFalloff{"falloff", kNumber, "-1", "light fades with falloff / d^2; -1: not",
                     "",        kAny,    ""};
constexpr W kAmbient{"ambient", kNumber,      "0", "light that reaches every point",
                     "",        kNotNegative, ""};
constexpr W kOrigin{"origin", kVector, "", "where the light is", "", kAny, ""};
constexpr W kPointing{"pointing", kVector, "", "a point that it lights", "", kAny, ""};

constexpr std::array kSettings{
    W{"title", kText, "Unnamed Scene", "", "", kAny, ""},
    W{"author", kText, "Unknown Author", "", "", kAny, ""},
    W{"date", kText, "Unknown Date", "", "", kAny, ""},
    W{"notes", kText, "", "may be left out", "", kAny, ""},
    W{"width", kInteger, "960", "of the picture", "px", whole(1, 65536), ""},
    W{"height", kInteger, "540", "of the picture", "px", whole(1, 65536), ""},
    W{"camera", kReference, "", "a Camera", "", kAny, ""},
    W{"lights", ValueKind::list, "[]", "a list of lights, or one; several add up", "", kAny, ""},
    W{"background", kReference, "white", "a Background", "", kAny, ""},
    W{"supersampling", kInteger, "1", "n x n samples a pixel", "", whole(1, 1024), ""},
    W{"dofsamples", kInteger, "1", "rays through the lens a sample", "", whole(1, 1 << 20), ""},
    W{"recursiondepth", kInteger, "3", "reflections in a row", "", whole(0, 10000), ""},
    W{"gamma", kNumber, "1", "has no effect, as in the original", "", kAny, ""}};
constexpr std::array kCamera{
    W{"position", kVector, "", "where the eye is", "", kAny, ""},
    W{"pointing", kVector, "", "a point that it looks at", "", kAny, ""},
    W{"fov", kNumber, "", "vertical field of view", "deg", whole(0, 360), ""},
    W{"aperture", kNumber, "3", "radius of the lens; counts where dofsamples is over 1", "",
      kNotNegative, ""},
    W{"focaldistance", kNumber, "0.5", "where the picture is sharp", "", kPositive, ""},
    W{"apertureshape", ValueKind::choice, "circle", "shape of the lens", "", kAny,
      "circle line triangle square pentagon hexagon uniform gaussian"},
    W{"projection", ValueKind::choice, "pinhole", "", "", kAny, "pinhole spherical cylindrical"}};
constexpr std::array kPointLight{kOrigin, kLightColor, kFalloff, kAmbient};
constexpr std::array kParallelLight{
    W{"from", kVector, "", "light travels from there", "", kAny, ""}, kPointing, kLightColor,
    kAmbient};
constexpr std::array kSpotLight{
    kOrigin,
    kPointing,
    kLightColor,
    W{"angle", kNumber, "", "off the axis, no light from there on", "deg", kAngle, ""},
    W{"beam", kNumber, "angle", "full strength up to there", "deg", whole(0, 180), ""},
    kFalloff,
    kAmbient};
constexpr std::array kCylinderLight{kOrigin, kPointing, kLightColor, kRadius, kFalloff, kAmbient};
constexpr std::array kBackground{W{"image", ValueKind::file, "none", "a panorama", "", kAny, ""},
                                 W{"angle", kNumber, "0", "turn of the panorama", "rad", kAny, ""},
                                 W{"horizon", kColor, "none", "with sky, a gradient", "", kAny, ""},
                                 W{"sky", kColor, "none", "with horizon, a gradient", "", kAny, ""},
                                 W{"color", kColor, "none", "one colour all over", "", kAny, ""}};
constexpr std::array kMaterialWords{
    W{"color", kColor, "", "a colour or a texture", "", kAny, ""},
    W{"reflectivity", kNumber, "0", "share that is mirrored", "", kShare, ""},
    W{"specular", kNumber, "0", "strength of highlights", "", kNotNegative, ""},
    W{"shininess", kNumber, "3", "exponent of highlights", "", kNotNegative, ""},
    W{"transparency", kNumber, "0", "share that goes through", "", kShare, ""},
    W{"refractIndex", kNumber, "1", "inside over outside", "", kPositive, ""},
    W{"absorption", kColor, "0 0 0", "per unit inside (Beer-Lambert)", "", kAny, ""},
    W{"bump", kReference, "none", "a texture of heights", "", kAny, ""},
    W{"bumpheight", kNumber, "0.1", "height of the bumps", "", kAny, ""}};
constexpr std::array kChecker{W{"odd", kColor, "0 0 0", "", "", kAny, ""},
                              W{"even", kColor, "1 1 1", "", "", kAny, ""},
                              W{"size", kNumber, "1", "side of a cell", "", kPositive, ""}};
constexpr std::array kNoise{W{"low", kColor, "0 0 0", "", "", kAny, ""},
                            W{"high", kColor, "1 1 1", "", "", kAny, ""},
                            W{"frequency", kNumber, "1", "", "", kPositive, ""},
                            W{"octaves", kInteger, "1", "", "", whole(1, 16), ""},
                            W{"strength", kNumber, "1", "", "", kNotNegative, ""}};
constexpr std::array kSphere{
    kCenter, W{"radius", kNumber, "", "0: it is not there", "", kNotNegative, ""}, kMaterial};
constexpr std::array kBox{W{"cornerA", kVector, "", "", "", kAny, ""},
                          W{"cornerB", kVector, "", "", "", kAny, ""}, kMaterial};
constexpr W kNormal{"normal", kVector, "", "the side that it is seen from", "", kAny, ""};
constexpr W kPosition{"position", kVector, "", "a point on it", "", kAny, ""};
constexpr std::array kPlane{kNormal, kPosition, kMaterial};
constexpr std::array kHalfPlane{kNormal, W{"position", kVector, "", "on its edge", "", kAny, ""},
                                W{"edge", kVector, "", "from the edge into it", "", kAny, ""},
                                kMaterial};
constexpr std::array kDisc{kCenter, kRadius, kMaterial, kUp,
                           W{"hole", kNumber, "0", "radius of the hole", "", kNotNegative, ""}};
constexpr std::array kTriangle{W{"a", kVector, "", "", "", kAny, ""},
                               W{"b", kVector, "", "", "", kAny, ""},
                               W{"c", kVector, "", "", "", kAny, ""}, kMaterial};
constexpr W kBase{"base", kVector, "", "the middle of its base", "", kAny, ""};
constexpr W kTop{"top", kVector, "", "the other end of its axis", "", kAny, ""};
constexpr std::array kCylinder{
    kBase, kTop, kRadius, kMaterial,
    W{"open", ValueKind::boolean, "false", "without its discs", "", kAny, "false true"}};
constexpr std::array kCone{
    kBase,
    kTop,
    kRadius,
    kMaterial,
    W{"topradius", kNumber, "0", "", "", kNotNegative, ""},
    W{"open", ValueKind::boolean, "false", "without the disc of its base", "", kAny, "false true"}};
constexpr std::array kTorus{kCenter, kRadius,
                            W{"thickness", kNumber, "", "radius of the tube", "", kPositive, ""},
                            kMaterial, kUp};
constexpr std::array kMesh{W{"file", ValueKind::file, "", "any model that is read", "", kAny, ""},
                           W{"material", kReference, "the file's own", "", "", kAny, ""}};

constexpr std::array kWords{
    CrtObjectWord{"Settings", EntityKind::settings, "what is rendered", kSettings},
    CrtObjectWord{"Camera", EntityKind::camera, "", kCamera},
    CrtObjectWord{"PointLight", EntityKind::light, "light to all sides", kPointLight},
    CrtObjectWord{"ParallelLight", EntityKind::light, "light from far away", kParallelLight},
    CrtObjectWord{"SpotLight", EntityKind::light, "light into a cone", kSpotLight},
    CrtObjectWord{"CylinderLight", EntityKind::light, "parallel light inside a round beam",
                  kCylinderLight},
    CrtObjectWord{"Background", EntityKind::background, "a panorama, a gradient or a colour",
                  kBackground},
    CrtObjectWord{"Material", EntityKind::material, "", kMaterialWords},
    CrtObjectWord{"Checker", EntityKind::texture, "cells of two colours", kChecker},
    CrtObjectWord{"Noise", EntityKind::texture, "Perlin noise", kNoise},
    CrtObjectWord{"Turbulence", EntityKind::texture, "octaves of noise added up", kNoise},
    CrtObjectWord{"Marble", EntityKind::texture, "veins", kNoise},
    CrtObjectWord{"Wood", EntityKind::texture, "rings", kNoise},
    CrtObjectWord{"Sphere", EntityKind::shape, "", kSphere},
    CrtObjectWord{"Box", EntityKind::shape, "", kBox},
    CrtObjectWord{"Plane", EntityKind::shape, "endless", kPlane},
    CrtObjectWord{"HalfPlane", EntityKind::shape, "", kHalfPlane},
    CrtObjectWord{"Disc", EntityKind::shape, "", kDisc},
    CrtObjectWord{"Triangle", EntityKind::shape, "", kTriangle},
    CrtObjectWord{"Cylinder", EntityKind::shape, "", kCylinder},
    CrtObjectWord{"Cone", EntityKind::shape, "", kCone},
    CrtObjectWord{"Torus", EntityKind::shape, "", kTorus},
    CrtObjectWord{"Mesh", EntityKind::include, "a model in a file", kMesh},
    CrtObjectWord{"Union", EntityKind::group, "all of its parts", {}},
    CrtObjectWord{"Intersection", EntityKind::group, "what is in all of its parts", {}},
    CrtObjectWord{"Difference", EntityKind::group, "the first without all others", {}}};

}  // namespace

std::span<const CrtObjectWord> crt_words() { return kWords; }

const CrtObjectWord* find_crt_word(std::string_view name) {
  for (const CrtObjectWord& word : kWords)
    if (word.name == name) return &word;
  return nullptr;
}

const CrtAttributeWord* find_crt_attribute(const CrtObjectWord* object, std::string_view name) {
  if (!object) return nullptr;
  for (const CrtAttributeWord& attribute : object->attributes)
    if (attribute.name == name) return &attribute;
  return nullptr;
}

Field describe(const CrtAttributeWord& attribute) {
  Field made;
  made.name = attribute.name;
  made.kind = attribute.kind;
  made.is_present = false;
  made.fallback = made.text = attribute.fallback;
  made.help = attribute.help;
  made.unit = attribute.unit;
  made.limits = attribute.limits;
  std::string_view rest = attribute.choices;
  while (!rest.empty()) {
    const size_t blank = rest.find(' ');
    made.choices.emplace_back(rest.substr(0, blank));
    rest.remove_prefix(blank == std::string_view::npos ? rest.size() : blank + 1);
  }
  return made;
}

}  // namespace tessera::edit
