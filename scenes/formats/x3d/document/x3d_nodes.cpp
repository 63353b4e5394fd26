#include "scenes/formats/x3d/document/x3d_nodes.h"

#include <algorithm>
#include <array>
#include <map>
#include <vector>

namespace tessera {
namespace {

using enum X3dNodeType::Use;

constexpr std::array kTypes = std::to_array<X3dNodeType>({
    // Grouping
    {"Transform", "children", read,
     " translation rotation scale scaleOrientation center bboxCenter bboxSize bboxDisplay visible ",
     " children "},
    {"Group", "children", read, " bboxCenter bboxSize bboxDisplay visible ", " children "},
    {"StaticGroup", "children", read, " bboxCenter bboxSize bboxDisplay visible ", " children "},
    {"Collision", "children", read, " enabled collide bboxCenter bboxSize bboxDisplay visible ",
     " children proxy "},
    {"Anchor", "children", read,
     " url parameter description bboxCenter bboxSize bboxDisplay visible load autoRefresh "
     "autoRefreshTimeLimit ",
     " children "},
    {"Switch", "children", read, " whichChoice bboxCenter bboxSize bboxDisplay visible ",
     " children "},
    {"LOD", "children", read,
     " center range forceTransitions bboxCenter bboxSize bboxDisplay visible ", " children "},
    {"Billboard", "children", read, " axisOfRotation bboxCenter bboxSize bboxDisplay visible ",
     " children "},
    {"Inline", "children", read,
     " url load global bboxCenter bboxSize bboxDisplay visible description autoRefresh "
     "autoRefreshTimeLimit ",
     ""},
    {"HAnimHumanoid", "children", read,
     " translation rotation scale scaleOrientation center bboxCenter bboxSize bboxDisplay visible "
     "info jointBindingPositions jointBindingRotations jointBindingScales loa name "
     "skeletalConfiguration version ",
     " children skeleton skin joints segments sites skinCoord skinNormal skinBindingCoords "
     "skinBindingNormals viewpoints motions "},
    {"HAnimJoint", "children", read,
     " translation rotation scale scaleOrientation center bboxCenter bboxSize bboxDisplay visible "
     "description limitOrientation llimit name skinCoordIndex skinCoordWeight stiffness ulimit ",
     " children displacers "},
    {"HAnimSegment", "children", read,
     " bboxCenter bboxSize bboxDisplay visible centerOfMass description mass momentsOfInertia "
     "name ",
     " children coord displacers "},
    {"HAnimSite", "children", read,
     " translation rotation scale scaleOrientation center bboxCenter bboxSize bboxDisplay visible "
     "description name ",
     " children "},
    // Viewing, lights, surroundings
    {"Viewpoint", "children", read,
     " position orientation fieldOfView centerOfRotation description jump retainUserOffsets "
     "nearDistance farDistance viewAll navigationInfo ",
     " navigationInfo "},
    {"OrthoViewpoint", "children", read,
     " position orientation fieldOfView centerOfRotation description jump retainUserOffsets "
     "nearDistance farDistance viewAll navigationInfo ",
     " navigationInfo "},
    {"ViewpointGroup", "children", read, " center description displayed retainUserOffsets size ",
     " children "},
    {"NavigationInfo", "children", read,
     " headlight type speed avatarSize visibilityLimit transitionTime transitionType ", ""},
    {"DirectionalLight", "children", read,
     " on intensity color ambientIntensity direction global shadows shadowIntensity ", ""},
    {"PointLight", "children", read,
     " on intensity color ambientIntensity location attenuation radius global shadows "
     "shadowIntensity ",
     ""},
    {"SpotLight", "children", read,
     " on intensity color ambientIntensity location direction attenuation radius beamWidth "
     "cutOffAngle global shadows shadowIntensity ",
     ""},
    {"Background", "children", read,
     " skyColor skyAngle groundColor groundAngle frontUrl backUrl leftUrl rightUrl topUrl "
     "bottomUrl transparency ",
     ""},
    {"TextureBackground", "children", read,
     " skyColor skyAngle groundColor groundAngle transparency ",
     " frontTexture backTexture leftTexture rightTexture topTexture bottomTexture "},
    {"Fog", "children", read, " color fogType visibilityRange ", ""},
    // Shapes
    {"Shape", "children", read, " bboxCenter bboxSize bboxDisplay visible castShadow ",
     " appearance geometry "},
    {"Appearance", "appearance", read, " alphaMode alphaCutoff shadowCaster ",
     " material backMaterial texture textureTransform lineProperties pointProperties "
     "fillProperties shaders acousticProperties "},
    {"Material", "material", read,
     " diffuseColor ambientIntensity specularColor emissiveColor shininess transparency mirror "
     "normalScale occlusionStrength ambientTextureMapping diffuseTextureMapping "
     "emissiveTextureMapping normalTextureMapping occlusionTextureMapping "
     "shininessTextureMapping specularTextureMapping ",
     " ambientTexture diffuseTexture emissiveTexture normalTexture occlusionTexture "
     "shininessTexture specularTexture "},
    {"TwoSidedMaterial", "material", read,
     " diffuseColor ambientIntensity specularColor emissiveColor shininess transparency "
     "separateBackColor backDiffuseColor backAmbientIntensity backSpecularColor "
     "backEmissiveColor backShininess backTransparency ",
     ""},
    {"UnlitMaterial", "material", read,
     " emissiveColor transparency normalScale emissiveTextureMapping normalTextureMapping ",
     " emissiveTexture normalTexture "},
    {"PhysicalMaterial", "material", read,
     " baseColor metallic roughness emissiveColor transparency normalScale occlusionStrength "
     "baseTextureMapping emissiveTextureMapping metallicRoughnessTextureMapping "
     "normalTextureMapping occlusionTextureMapping ",
     " baseTexture emissiveTexture metallicRoughnessTexture normalTexture occlusionTexture "},
    {"ImageTexture", "texture", read,
     " url repeatS repeatT load description flipVertically autoRefresh autoRefreshTimeLimit ",
     " textureProperties "},
    {"PixelTexture", "texture", read, " image repeatS repeatT ", " textureProperties "},
    {"MultiTexture", "texture", read, " alpha color function mode source ", " texture "},
    {"TextureTransform", "textureTransform", read, " center rotation scale translation mapping ",
     ""},
    {"MultiTextureTransform", "textureTransform", read, "", " textureTransform "},
    {"TextureProperties", "textureProperties", read,
     " anisotropicDegree borderColor borderWidth boundaryModeS boundaryModeT boundaryModeR "
     "magnificationFilter minificationFilter textureCompression texturePriority "
     "generateMipMaps ",
     ""},
    {"Box", "geometry", read, " size solid ", ""},
    {"Sphere", "geometry", read, " radius solid subdivision ", ""},
    {"Cylinder", "geometry", read, " radius height side top bottom solid subdivision ", ""},
    {"Cone", "geometry", read, " bottomRadius height side bottom solid subdivision ", ""},
    {"Rectangle2D", "geometry", read, " size solid ", ""},
    {"Disk2D", "geometry", read, " innerRadius outerRadius solid subdivision ", ""},
    {"IndexedFaceSet", "geometry", read,
     " coordIndex colorIndex normalIndex texCoordIndex colorPerVertex normalPerVertex ccw convex "
     "solid creaseAngle ",
     " coord color normal texCoord attrib fogCoord "},
    {"IndexedTriangleSet", "geometry", read, " index colorPerVertex normalPerVertex ccw solid ",
     " coord color normal texCoord attrib fogCoord "},
    {"IndexedTriangleStripSet", "geometry", read,
     " index colorPerVertex normalPerVertex ccw solid creaseAngle ",
     " coord color normal texCoord attrib fogCoord "},
    {"IndexedTriangleFanSet", "geometry", read,
     " index colorPerVertex normalPerVertex ccw solid creaseAngle ",
     " coord color normal texCoord attrib fogCoord "},
    {"IndexedQuadSet", "geometry", read, " index colorPerVertex normalPerVertex ccw solid ",
     " coord color normal texCoord attrib fogCoord "},
    {"TriangleSet", "geometry", read, " colorPerVertex normalPerVertex ccw solid ",
     " coord color normal texCoord attrib fogCoord "},
    {"TriangleStripSet", "geometry", read,
     " stripCount colorPerVertex normalPerVertex ccw solid creaseAngle ",
     " coord color normal texCoord attrib fogCoord "},
    {"TriangleFanSet", "geometry", read,
     " fanCount colorPerVertex normalPerVertex ccw solid creaseAngle ",
     " coord color normal texCoord attrib fogCoord "},
    {"QuadSet", "geometry", read, " colorPerVertex normalPerVertex ccw solid ",
     " coord color normal texCoord attrib fogCoord "},
    {"ElevationGrid", "geometry", read,
     " height xDimension xSpacing zDimension zSpacing colorPerVertex normalPerVertex ccw solid "
     "creaseAngle ",
     " color normal texCoord attrib fogCoord "},
    {"Extrusion", "geometry", read,
     " beginCap endCap ccw convex creaseAngle crossSection orientation scale solid spine ", ""},
    {"Text", "geometry", read, " string length maxExtent solid ", " fontStyle "},
    {"FontStyle", "fontStyle", read,
     " family horizontal justify language leftToRight size spacing style topToBottom ", ""},
    {"IndexedLineSet", "geometry", read, " coordIndex colorIndex colorPerVertex ",
     " coord color attrib fogCoord normal "},
    {"LineSet", "geometry", read, " vertexCount ", " coord color attrib fogCoord normal "},
    {"PointSet", "geometry", read, "", " coord color attrib fogCoord normal "},
    {"LineProperties", "lineProperties", read, " applied linetype linewidthScaleFactor ", ""},
    {"Coordinate", "coord", read, " point ", ""},
    {"CoordinateDouble", "coord", read, " point ", ""},
    {"Normal", "normal", read, " vector ", ""},
    {"Color", "color", read, " color ", ""},
    {"ColorRGBA", "color", read, " color ", ""},
    {"TextureCoordinate", "texCoord", read, " point mapping ", ""},
    {"TextureCoordinateGenerator", "texCoord", read, " mode parameter mapping ", ""},
    {"MultiTextureCoordinate", "texCoord", read, "", " texCoord "},
    // What has no part in a still picture, or is not read.
    {"WorldInfo", "children", ignored, "", ""},
    {"MovieTexture", "texture", ignored, "", ""},
    {"RenderedTexture", "texture", ignored, "", ""},
    {"GeneratedShadowMap", "texture", ignored, "", ""},
    {"PointProperties", "pointProperties", ignored, "", ""},
    {"FillProperties", "fillProperties", ignored, "", ""},
    {"ComposedShader", "shaders", ignored, "", ""},
    {"ProgramShader", "shaders", ignored, "", ""},
    {"CommonSurfaceShader", "shaders", ignored, "", ""},
    {"ShaderPart", "parts", ignored, "", ""},
    {"Polyline2D", "geometry", ignored, "", ""},
    {"Polypoint2D", "geometry", ignored, "", ""},
    {"TriangleSet2D", "geometry", ignored, "", ""},
    {"Circle2D", "geometry", ignored, "", ""},
    {"Arc2D", "geometry", ignored, "", ""},
    {"ArcClose2D", "geometry", ignored, "", ""},
    {"LocalFog", "children", ignored, "", ""},
    {"FogCoordinate", "fogCoord", ignored, "", ""},
    {"ClipPlane", "children", ignored, "", ""},
    {"EnvironmentLight", "children", ignored, "", ""},
    {"TextureProjector", "children", ignored, "", ""},
    {"TextureProjectorParallel", "children", ignored, "", ""},
    {"TimeSensor", "children", ignored, "", ""},
    {"TouchSensor", "children", ignored, "", ""},
    {"PlaneSensor", "children", ignored, "", ""},
    {"SphereSensor", "children", ignored, "", ""},
    {"CylinderSensor", "children", ignored, "", ""},
    {"ProximitySensor", "children", ignored, "", ""},
    {"VisibilitySensor", "children", ignored, "", ""},
    {"TransformSensor", "children", ignored, "", ""},
    {"KeySensor", "children", ignored, "", ""},
    {"StringSensor", "children", ignored, "", ""},
    {"LoadSensor", "children", ignored, "", ""},
    {"ROUTE", "children", ignored, "", ""},
    {"Script", "children", ignored, "", ""},
    {"field", "field", ignored, "", ""},
    {"fieldValue", "fieldValue", ignored, "", ""},
    {"IMPORT", "children", ignored, "", ""},
    {"EXPORT", "children", ignored, "", ""},
    {"ExternProtoDeclare", "children", ignored, "", ""},
    {"ProtoInstance", "children", ignored, "", ""},
    {"ColorInterpolator", "children", ignored, "", ""},
    {"CoordinateInterpolator", "children", ignored, "", ""},
    {"NormalInterpolator", "children", ignored, "", ""},
    {"OrientationInterpolator", "children", ignored, "", ""},
    {"PositionInterpolator", "children", ignored, "", ""},
    {"PositionInterpolator2D", "children", ignored, "", ""},
    {"ScalarInterpolator", "children", ignored, "", ""},
    {"SplinePositionInterpolator", "children", ignored, "", ""},
    {"BooleanFilter", "children", ignored, "", ""},
    {"BooleanSequencer", "children", ignored, "", ""},
    {"BooleanToggle", "children", ignored, "", ""},
    {"BooleanTrigger", "children", ignored, "", ""},
    {"IntegerSequencer", "children", ignored, "", ""},
    {"IntegerTrigger", "children", ignored, "", ""},
    {"TimeTrigger", "children", ignored, "", ""},
    {"Sound", "children", ignored, "", ""},
    {"AudioClip", "source", ignored, "", ""},
    {"MetadataString", "metadata", ignored, "", ""},
    {"MetadataInteger", "metadata", ignored, "", ""},
    {"MetadataFloat", "metadata", ignored, "", ""},
    {"MetadataDouble", "metadata", ignored, "", ""},
    {"MetadataBoolean", "metadata", ignored, "", ""},
    {"MetadataSet", "metadata", ignored, "", ""},
    {"HAnimMotion", "motions", ignored, "", ""},
    {"HAnimDisplacer", "displacers", ignored, "", ""},
    {"NurbsPatchSurface", "geometry", ignored, "", ""},
    {"NurbsCurve", "geometry", ignored, "", ""},
});

/// Whether `word` stands in a list whose words are between spaces.
bool contains(std::string_view list, std::string_view word) {
  for (size_t at = list.find(word); at != std::string_view::npos; at = list.find(word, at + 1))
    if (!word.empty() && list[at - 1] == ' ' && list[at + word.size()] == ' ') return true;
  return false;
}

}  // namespace

const X3dNodeType* find_x3d_node_type(std::string_view name) {
  static const std::map<std::string_view, const X3dNodeType*> by_name = [] {
    std::map<std::string_view, const X3dNodeType*> all;
    for (const X3dNodeType& type : kTypes) all.emplace(type.name, &type);
    return all;
  }();
  const auto at = by_name.find(name);
  return at == by_name.end() ? nullptr : at->second;
}

bool has_x3d_transform(std::string_view name) {
  return name == "Transform" || name.starts_with("HAnim");
}

std::span<const std::string> x3d_node_names() {
  static const std::vector<std::string> names = [] {
    std::vector<std::string> all;
    for (const X3dNodeType& type : kTypes) all.emplace_back(type.name);
    return all;
  }();
  return names;
}

bool X3dNodeType::has_field(std::string_view field) const {
  return use == Use::ignored || field == "metadata" || contains(fields, field);
}

bool X3dNodeType::has_node_field(std::string_view field) const {
  return use == Use::ignored || field == "metadata" || contains(node_fields, field);
}

std::vector<std::string> X3dNodeType::field_names() const {
  std::vector<std::string> names;
  for (std::string_view rest : {fields, node_fields})
    for (size_t end; (end = rest.find(' ', 1)) != std::string_view::npos; rest.remove_prefix(end))
      names.emplace_back(rest.substr(1, end - 1));
  return names;
}

}  // namespace tessera
