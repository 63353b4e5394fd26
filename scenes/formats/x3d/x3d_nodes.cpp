#include "scenes/formats/x3d/x3d_nodes.h"

#include <algorithm>
#include <array>
#include <vector>

namespace tessera {
namespace {

using enum X3dNodeType::Use;

constexpr std::array kTypes = std::to_array<X3dNodeType>({
    // Grouping
    {"Transform", "children", read,
     " translation rotation scale scaleOrientation center bboxCenter bboxSize visible "},
    {"Group", "children", read, " bboxCenter bboxSize visible "},
    {"StaticGroup", "children", read, " bboxCenter bboxSize visible "},
    {"Collision", "children", read, " enabled bboxCenter bboxSize visible "},
    {"Anchor", "children", read, " url parameter description bboxCenter bboxSize visible "},
    {"Switch", "children", read, " whichChoice bboxCenter bboxSize visible "},
    {"LOD", "children", read, " center range forceTransitions bboxCenter bboxSize visible "},
    {"Billboard", "children", read, " axisOfRotation bboxCenter bboxSize visible "},
    // Viewing, lights, surroundings
    {"Viewpoint", "children", read,
     " position orientation fieldOfView centerOfRotation description jump retainUserOffsets "
     "nearDistance farDistance viewAll navigationInfo "},
    {"OrthoViewpoint", "children", read,
     " position orientation fieldOfView centerOfRotation description jump retainUserOffsets "
     "nearDistance farDistance viewAll "},
    {"NavigationInfo", "children", read,
     " headlight type speed avatarSize visibilityLimit transitionTime transitionType "},
    {"DirectionalLight", "children", read,
     " on intensity color ambientIntensity direction global shadows shadowIntensity "},
    {"PointLight", "children", read,
     " on intensity color ambientIntensity location attenuation radius global shadows "
     "shadowIntensity "},
    {"SpotLight", "children", read,
     " on intensity color ambientIntensity location direction attenuation radius beamWidth "
     "cutOffAngle global shadows shadowIntensity "},
    {"Background", "children", read,
     " skyColor skyAngle groundColor groundAngle frontUrl backUrl leftUrl rightUrl topUrl "
     "bottomUrl transparency "},
    {"Fog", "children", read, " color fogType visibilityRange "},
    // Shapes
    {"Shape", "children", read, " bboxCenter bboxSize visible castShadow "},
    {"Appearance", "appearance", read, " alphaMode alphaCutoff "},
    {"Material", "material", read,
     " diffuseColor ambientIntensity specularColor emissiveColor shininess transparency mirror "},
    {"UnlitMaterial", "material", read, " emissiveColor transparency "},
    {"PhysicalMaterial", "material", read,
     " baseColor metallic roughness emissiveColor transparency "},
    {"Box", "geometry", read, " size solid "},
    {"Sphere", "geometry", read, " radius solid subdivision "},
    {"Cylinder", "geometry", read, " radius height side top bottom solid subdivision "},
    {"Cone", "geometry", read, " bottomRadius height side bottom solid subdivision "},
    {"Rectangle2D", "geometry", read, " size solid "},
    {"Disk2D", "geometry", read, " innerRadius outerRadius solid subdivision "},
    {"IndexedFaceSet", "geometry", read,
     " coordIndex colorIndex normalIndex texCoordIndex colorPerVertex normalPerVertex ccw convex "
     "solid creaseAngle "},
    {"IndexedTriangleSet", "geometry", read, " index colorPerVertex normalPerVertex ccw solid "},
    {"IndexedTriangleStripSet", "geometry", read,
     " index colorPerVertex normalPerVertex ccw solid creaseAngle "},
    {"IndexedTriangleFanSet", "geometry", read,
     " index colorPerVertex normalPerVertex ccw solid creaseAngle "},
    {"IndexedQuadSet", "geometry", read, " index colorPerVertex normalPerVertex ccw solid "},
    {"TriangleSet", "geometry", read, " colorPerVertex normalPerVertex ccw solid "},
    {"TriangleStripSet", "geometry", read,
     " stripCount colorPerVertex normalPerVertex ccw solid creaseAngle "},
    {"TriangleFanSet", "geometry", read,
     " fanCount colorPerVertex normalPerVertex ccw solid creaseAngle "},
    {"QuadSet", "geometry", read, " colorPerVertex normalPerVertex ccw solid "},
    {"Coordinate", "coord", read, " point "},
    {"CoordinateDouble", "coord", read, " point "},
    {"Normal", "normal", read, " vector "},
    {"Color", "color", read, " color "},
    {"ColorRGBA", "color", read, " color "},
    {"TextureCoordinate", "texCoord", read, " point mapping "},
    // What has no part in a still picture, or is not read yet.
    {"WorldInfo", "children", ignored, ""},
    {"Inline", "children", ignored, ""},
    {"ImageTexture", "texture", ignored, ""},
    {"MovieTexture", "texture", ignored, ""},
    {"PixelTexture", "texture", ignored, ""},
    {"MultiTexture", "texture", ignored, ""},
    {"RenderedTexture", "texture", ignored, ""},
    {"GeneratedShadowMap", "texture", ignored, ""},
    {"TextureTransform", "textureTransform", ignored, ""},
    {"TextureProperties", "textureProperties", ignored, ""},
    {"MultiTextureCoordinate", "texCoord", ignored, ""},
    {"MultiTextureTransform", "textureTransform", ignored, ""},
    {"TextureCoordinateGenerator", "texCoord", ignored, ""},
    {"TwoSidedMaterial", "material", ignored, ""},
    {"LineProperties", "lineProperties", ignored, ""},
    {"PointProperties", "pointProperties", ignored, ""},
    {"FillProperties", "fillProperties", ignored, ""},
    {"ComposedShader", "shaders", ignored, ""},
    {"ProgramShader", "shaders", ignored, ""},
    {"CommonSurfaceShader", "shaders", ignored, ""},
    {"ShaderPart", "parts", ignored, ""},
    {"ElevationGrid", "geometry", ignored, ""},
    {"Extrusion", "geometry", ignored, ""},
    {"Text", "geometry", ignored, ""},
    {"FontStyle", "fontStyle", ignored, ""},
    {"IndexedLineSet", "geometry", ignored, ""},
    {"LineSet", "geometry", ignored, ""},
    {"PointSet", "geometry", ignored, ""},
    {"Polyline2D", "geometry", ignored, ""},
    {"Polypoint2D", "geometry", ignored, ""},
    {"TriangleSet2D", "geometry", ignored, ""},
    {"Circle2D", "geometry", ignored, ""},
    {"Arc2D", "geometry", ignored, ""},
    {"ArcClose2D", "geometry", ignored, ""},
    {"TextureBackground", "children", ignored, ""},
    {"LocalFog", "children", ignored, ""},
    {"FogCoordinate", "fogCoord", ignored, ""},
    {"ClipPlane", "children", ignored, ""},
    {"EnvironmentLight", "children", ignored, ""},
    {"TextureProjector", "children", ignored, ""},
    {"TextureProjectorParallel", "children", ignored, ""},
    {"ViewpointGroup", "children", ignored, ""},
    {"TimeSensor", "children", ignored, ""},
    {"TouchSensor", "children", ignored, ""},
    {"PlaneSensor", "children", ignored, ""},
    {"SphereSensor", "children", ignored, ""},
    {"CylinderSensor", "children", ignored, ""},
    {"ProximitySensor", "children", ignored, ""},
    {"VisibilitySensor", "children", ignored, ""},
    {"TransformSensor", "children", ignored, ""},
    {"KeySensor", "children", ignored, ""},
    {"StringSensor", "children", ignored, ""},
    {"LoadSensor", "children", ignored, ""},
    {"ROUTE", "children", ignored, ""},
    {"Script", "children", ignored, ""},
    {"field", "field", ignored, ""},
    {"fieldValue", "fieldValue", ignored, ""},
    {"IMPORT", "children", ignored, ""},
    {"EXPORT", "children", ignored, ""},
    {"ProtoDeclare", "children", ignored, ""},
    {"ExternProtoDeclare", "children", ignored, ""},
    {"ProtoInstance", "children", ignored, ""},
    {"ColorInterpolator", "children", ignored, ""},
    {"CoordinateInterpolator", "children", ignored, ""},
    {"NormalInterpolator", "children", ignored, ""},
    {"OrientationInterpolator", "children", ignored, ""},
    {"PositionInterpolator", "children", ignored, ""},
    {"PositionInterpolator2D", "children", ignored, ""},
    {"ScalarInterpolator", "children", ignored, ""},
    {"SplinePositionInterpolator", "children", ignored, ""},
    {"BooleanFilter", "children", ignored, ""},
    {"BooleanSequencer", "children", ignored, ""},
    {"BooleanToggle", "children", ignored, ""},
    {"BooleanTrigger", "children", ignored, ""},
    {"IntegerSequencer", "children", ignored, ""},
    {"IntegerTrigger", "children", ignored, ""},
    {"TimeTrigger", "children", ignored, ""},
    {"Sound", "children", ignored, ""},
    {"AudioClip", "source", ignored, ""},
    {"MetadataString", "metadata", ignored, ""},
    {"MetadataInteger", "metadata", ignored, ""},
    {"MetadataFloat", "metadata", ignored, ""},
    {"MetadataDouble", "metadata", ignored, ""},
    {"MetadataBoolean", "metadata", ignored, ""},
    {"MetadataSet", "metadata", ignored, ""},
    {"HAnimHumanoid", "children", ignored, ""},
    {"HAnimJoint", "children", ignored, ""},
    {"HAnimSegment", "children", ignored, ""},
    {"HAnimSite", "viewpoints", ignored, ""},
    {"HAnimMotion", "motions", ignored, ""},
    {"HAnimDisplacer", "displacers", ignored, ""},
    {"NurbsPatchSurface", "geometry", ignored, ""},
    {"NurbsCurve", "geometry", ignored, ""},
});

}  // namespace

const X3dNodeType* find_x3d_node_type(std::string_view name) {
  const auto at = std::find_if(kTypes.begin(), kTypes.end(),
                               [&](const X3dNodeType& type) { return type.name == name; });
  return at == kTypes.end() ? nullptr : &*at;
}

std::span<const std::string> x3d_node_names() {
  static const std::vector<std::string> names = [] {
    std::vector<std::string> all;
    for (const X3dNodeType& type : kTypes) all.emplace_back(type.name);
    return all;
  }();
  return names;
}

bool has_x3d_field(const X3dNodeType& type, std::string_view field) {
  if (type.fields.empty()) return true;
  for (size_t at = type.fields.find(field); at != std::string_view::npos;
       at = type.fields.find(field, at + 1))
    if (type.fields[at - 1] == ' ' && type.fields[at + field.size()] == ' ') return true;
  return false;
}

}  // namespace tessera
