// Fields of nodes, one family after the other: what the other tests of X3D do not show.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <limits>

#include "tests/unit/scenes/formats/x3d/x3d_testing.h"

namespace tessera {
namespace {

v1::Scene scene_of(const std::string& text, const std::string& version = "4.0") {
  return parse_classic(text, version).scene;
}

LoadedScene of_xml(const std::string& scene) {
  return parse_x3d("<X3D version='4.0'><Scene>" + scene + "</Scene></X3D>", "t.x3d", {});
}

/// A box of that appearance, or another geometry.
std::string shown(const std::string& appearance, const std::string& geometry = "Box { }") {
  return "Shape { appearance Appearance { " + appearance + " } geometry " + geometry + " } ";
}

TEST(X3dNodes, KeepTheMetadata) {
  const v1::Metadata metadata =
      scene_of(
          "META \"title\" \"A title\" META \"creator\" \"Somebody\" META \"subject\" \"Boxes\"")
          .metadata();
  EXPECT_EQ(metadata.title(), "A title");
  EXPECT_EQ(metadata.author(), "Somebody");
  EXPECT_EQ(metadata.properties().at("subject"), "Boxes");
}

TEST(X3dNodes, ANameIsWhatWasLastCalledIt) {
  const v1::Scene scene = scene_of(
      "DEF A Group { children Shape { geometry Sphere { } } } USE A "
      "DEF A Group { children Shape { geometry Box { } } } USE A");
  ASSERT_EQ(scene.objects_size(), 2);
  const auto shape_at = [&](int node) {
    const std::string name = scene.nodes(node).instance_of();
    for (const v1::Object& object : scene.objects())
      if (object.name() == name) return object.nodes(0).children(0).shape();
    return v1::Shape();
  };
  EXPECT_TRUE(shape_at(1).has_sphere());
  EXPECT_TRUE(shape_at(3).has_box());
}

TEST(X3dNodes, ValuesAreReadAsLenientlyAsTheyAreWritten) {
  // Numbers as in C, commas anywhere, strings without their quotes, an axis of no length.
  const LoadedScene loaded = of_xml(
      "<Transform translation='1.,.5,,1e-3' rotation='0 0 0 1'/>"
      "<Shape><Appearance><ImageTexture url='a picture.png'/></Appearance><Box/></Shape>");
  const v1::Transform& transform = loaded.scene.nodes(0).transform();
  ASSERT_EQ(transform.steps_size(), 1);
  EXPECT_EQ(transform.steps(0).translate().x(), 1);
  EXPECT_EQ(transform.steps(0).translate().y(), .5);
  EXPECT_EQ(transform.steps(0).translate().z(), .001);
  EXPECT_EQ(loaded.scene.textures(0).image().file(), "a picture.png");
  ASSERT_EQ(loaded.warnings.size(), 1u);
  EXPECT_EQ(loaded.warnings[0],
            "t.x3d:1:74: rotation of Transform: '0 0 0 1'; expected an axis other than 0 0 0; it "
            "is left out");
}

TEST(X3dNodes, ValuesOutOfRangeAreToldWithWhatIsTaken) {
  struct Case {
    std::string scene, warning;
  };
  const std::string range = "; expected a number in the range of single precision; ";
  const std::vector<Case> cases{
      {"<Shape><Sphere radius='1e300'/></Shape>",
       "24: radius of Sphere: '1e300'" + range + "3.40282e+38 is taken"},
      {"<Transform translation='0 -1e999 0'/>",
       "27: translation of Transform: '-1e999'" + range + "-3.40282e+38 is taken"},
      {"<Transform scale='1e300 1 1'/>",
       "19: scale of Transform: '1e300'" + range + "3.40282e+38 is taken"},
      {"<Fog visibilityRange='1e300'/>",
       "23: visibilityRange of Fog: '1e300'" + range + "3.40282e+38 is taken"},
      {"<Fog visibilityRange='-1'/>",
       "23: visibilityRange of Fog: '-1'; expected 0 or more; 0 is taken"},
      {"<Fog visibilityRange='1' fogType='THICK'/>",
       "35: fogType of Fog: 'THICK'; expected one of LINEAR, EXPONENTIAL; LINEAR is taken"},
      {"<SpotLight beamWidth='-1'/>",
       "23: beamWidth of SpotLight: '-1'; expected an angle of 0 to pi; 0 is taken"},
      {"<SpotLight beamWidth='9'/>",
       "23: beamWidth of SpotLight: '9'; expected an angle of 0 to pi; 3.14159 is taken"},
      {"<SpotLight cutOffAngle='-1'/>",
       "25: cutOffAngle of SpotLight: '-1'; expected an angle above 0, up to pi; the light is left "
       "out"},
      {"<PointLight attenuation='0 -1 1'/>",
       "26: attenuation of PointLight: '0 -1 1'; expected 0 or more; 0 is taken for what is less"},
      {"<Background skyColor='0 0 1 1 0 0' skyAngle='9'/>",
       "46: skyAngle of Background: '9'; expected angles of 0 to pi; 3.14159 is taken"},
      {"<Background skyColor='0 0 1 1 0 0' skyAngle='-1'/>",
       "46: skyAngle of Background: '-1'; expected angles of 0 to pi; 0 is taken"},
      {"<Background groundColor='0 0 1 1 0 0' groundAngle='2'/>",
       "52: groundAngle of Background: '2'; expected angles of 0 to pi / 2; 1.5708 is taken"},
      {"<Background skyColor='0 0 1 1 0 0 0 1 0' skyAngle='1 .5'/>",
       "52: skyAngle of Background: '1 .5'; expected angles that do not fall; they are raised to "
       "the last one"},
      {"<Background skyColor='0 0 1 1 0 0' skyAngle='.3 .5 .7'/>",
       "46: skyAngle of Background: 3 angles for 2 colours; expected one angle fewer than colours; "
       "what is left over is left out"},
      {"<Viewpoint nearDistance='5' farDistance='2'/>",
       "42: farDistance of Viewpoint: '2'; expected more than nearDistance; it is left out"},
      {"<OrthoViewpoint fieldOfView='-1 -1 1 1 2 3 4 5'/>",
       "30: fieldOfView of OrthoViewpoint: 8 numbers; expected 4; the first ones are taken"},
      {"<Transform scale='0 1 1'><Viewpoint/></Transform>",
       "27: Viewpoint in a flat frame; expected a frame that can be inverted; it is left out"},
      {"<Transform scale='0 1 1'><Background skyColor='1 0 0' groundColor='0 1 0'/></Transform>",
       "27: Background in a flat frame; expected a frame that can be inverted; it is not turned"},
      {"<Shape><Text string='A'><FontStyle style='BROAD'/></Text></Shape>",
       "43: style of FontStyle: 'BROAD'; expected one of PLAIN, BOLD, ITALIC, BOLDITALIC; PLAIN is "
       "taken"},
      {"<Shape><Text string='A'><FontStyle spacing='-1'/></Text></Shape>",
       "45: spacing of FontStyle: '-1'; expected 0 or more; 0 is taken"},
      {"<Shape><TriangleSet><Coordinate point='0 0 0 1 0 0 0 1 0 1 1 0'/></TriangleSet></Shape>",
       "9: 1 corner after the last face of TriangleSet; expected 3 a face; what is left over is "
       "left out"},
      {"<Shape geometry='ball'/>",
       "18: geometry of Shape: 'ball'; expected a node; it is left out"},
  };
  for (const Case& c : cases) {
    const LoadedScene loaded = of_xml("\n" + c.scene);
    EXPECT_EQ(loaded.warnings, std::vector<std::string>{"t.x3d:2:" + c.warning}) << c.scene;
    EXPECT_EQ(loaded.repairs.size(), 1u) << c.scene;
    EXPECT_EQ(render_loaded(loaded, 4, 4).size(), 48u) << c.scene;
  }
  // Of values inside their range nothing is told, nor of the largest ones that exporters write.
  for (const char* scene :
       {"<PointLight radius='3.4028235e38'/>", "<Fog visibilityRange='3.402823466e+38'/>",
        "<SpotLight beamWidth='3.1416' cutOffAngle='3.142'/>",
        "<Background skyColor='0 0 1 1 0 0' skyAngle='3.1416'/>", "<Transform scale='-1 1 0'/>"})
    EXPECT_EQ(of_xml(scene).warnings, std::vector<std::string>{}) << scene;
}

TEST(X3dNodes, ValuesOutOfRangeAreTheNearestInIt) {
  constexpr double kLargest = std::numeric_limits<float>::max();
  EXPECT_EQ(
      of_xml("<Shape><Sphere radius='1e300'/></Shape>").scene.nodes(0).shape().sphere().radius(),
      kLargest);
  EXPECT_EQ(of_xml("<Fog visibilityRange='1e300'/>").scene.fog().visibility_range(), kLargest);
  EXPECT_FALSE(of_xml("<Fog visibilityRange='-1'/>").scene.has_fog());
  EXPECT_EQ(of_xml("<SpotLight beamWidth='-1'/>").scene.nodes(0).light().spot().beam_width(), 0);
  EXPECT_EQ(of_xml("<SpotLight cutOffAngle='-1'/>").scene.nodes_size(), 0);
  EXPECT_EQ(of_xml("<Background skyColor='0 0 1 1 0 0' skyAngle='9'/>")
                .scene.background()
                .rings()
                .sky_angles(0),
            180);
  EXPECT_EQ(of_xml("<Transform scale='0 1 1'><Viewpoint/></Transform>").scene.cameras(0).name(),
            "default");
  EXPECT_EQ(of_xml("<Viewpoint nearDistance='5' farDistance='2'/>").scene.cameras(0).far_distance(),
            0);
}

TEST(X3dNodes, TheStyleOfAFontIsReadInEveryEncoding) {
  const auto vertices = [](const LoadedScene& loaded) {
    return blob_values<float>(loaded.scene.nodes(0).shape().mesh().positions(), loaded.blobs);
  };
  const auto bold =
      vertices(of_xml("<Shape><Text string='\"A\"'><FontStyle style='BOLD'/></Text></Shape>"));
  EXPECT_NE(bold, vertices(of_xml("<Shape><Text string='\"A\"'/></Shape>")));
  EXPECT_EQ(
      bold,
      vertices(parse_classic(
          "Shape { geometry Text { string \"A\" fontStyle FontStyle { style \"BOLD\" } } }")));
}

TEST(X3dNodes, GroupsThatDoNothingShowTheirChildren) {
  for (const char* type : {"Group", "StaticGroup", "Anchor", "Collision"}) {
    const v1::Scene scene =
        scene_of(std::string(type) + " { children [ Shape { geometry Box { } } Group { } ] }");
    ASSERT_EQ(scene.nodes(0).children_size(), 2) << type;
    EXPECT_TRUE(scene.nodes(0).children(0).shape().has_box()) << type;
    EXPECT_EQ(scene.nodes(0).transform().steps_size(), 0) << type;
  }
  EXPECT_EQ(scene_of("Switch { whichChoice 1 children Group { } }").nodes(0).children_size(), 0);
}

TEST(X3dNodes, WhatIsNotVisibleIsHiddenAndWhatCastsNoShadowSaysSo) {
  const v1::Scene scene = scene_of(
      "Group { visible FALSE } Shape { visible FALSE geometry Box { } } "
      "Shape { castShadow FALSE geometry Box { } } Shape { geometry Box { } }");
  EXPECT_TRUE(scene.nodes(0).hidden());
  EXPECT_TRUE(scene.nodes(1).hidden());
  EXPECT_FALSE(scene.nodes(2).hidden());
  EXPECT_TRUE(scene.nodes(2).casts_no_shadow());
  EXPECT_FALSE(scene.nodes(3).casts_no_shadow());
}

TEST(X3dNodes, ViewpointsHaveNamesBoundsAndWindows) {
  const v1::Scene scene = scene_of(
      "DEF A Viewpoint { description \"first\" nearDistance 2 farDistance 9 } "
      "Viewpoint { description \"second\" viewAll TRUE } "
      "OrthoViewpoint { fieldOfView [ -1 -2 3 4 ] }");
  ASSERT_EQ(scene.cameras_size(), 3);
  EXPECT_EQ(scene.cameras(0).name(), "A");
  EXPECT_EQ(scene.cameras(0).description(), "first");
  EXPECT_EQ(scene.cameras(0).near_distance(), 2);
  EXPECT_EQ(scene.cameras(0).far_distance(), 9);
  EXPECT_FALSE(scene.cameras(0).frame_all());
  EXPECT_EQ(scene.cameras(1).name(), "second");
  EXPECT_EQ(scene.cameras(1).near_distance(), 0);  // -1: no bound
  EXPECT_TRUE(scene.cameras(1).frame_all());
  EXPECT_EQ(scene.cameras(2).orthographic().min_y(), -2);
  EXPECT_EQ(scene.cameras(2).orthographic().max_x(), 3);
  // In the lengths of the frame around it.
  const v1::Camera scaled =
      scene_of(
          "Transform { scale 2 2 2 children [ OrthoViewpoint { nearDistance 1 farDistance 4 } ] }")
          .cameras(0);
  EXPECT_EQ(scaled.orthographic().max_x(), 2);
  EXPECT_EQ(scaled.near_distance(), 2);
  EXPECT_EQ(scaled.far_distance(), 8);
}

TEST(X3dNodes, ViewpointsMayStandInAGroupOfTheirOwn) {
  const v1::Scene scene = scene_of(
      "ViewpointGroup { description \"both\" displayed FALSE children [ "
      "DEF A Viewpoint { } DEF B Viewpoint { } ] } DEF C Viewpoint { }");
  ASSERT_EQ(scene.cameras_size(), 3);
  EXPECT_EQ(scene.cameras(0).name(), "A");
  EXPECT_EQ(scene.cameras(2).name(), "C");
}

size_t lit_pixels(const std::string& scene) {
  const std::vector<float> values = render_loaded(parse_classic(scene), 32, 32);
  size_t lit = 0;
  for (size_t i = 0; i < values.size(); i += 3) lit += values[i] > 0;
  return lit;
}

TEST(X3dNodes, AFileWithoutAViewpointShowsAllOfIt) {
  EXPECT_TRUE(parse_classic("Shape { geometry Box { } }").scene.cameras(0).frame_all());
  const auto box = [](const std::string& move, const std::string& size) {
    return lit_pixels("Transform { translation " + move + " children Shape { geometry Box { size " +
                      size + " } } }");
  };
  const size_t lit = box("0 0 0", "2 2 2");
  EXPECT_GT(lit, 32u * 32 / 4);
  for (const auto& [move, size] :
       {std::pair{"500 0 0", "2 2 2"}, std::pair{"0 0 10", "2 2 2"},
        std::pair{"0 -7 0", ".01 .01 .01"}, std::pair{"0 0 0", "4e4 4e4 4e4"}})
    EXPECT_NEAR(static_cast<double>(box(move, size)), static_cast<double>(lit), 8) << move;
}

TEST(X3dNodes, LinesAreAsWideInAViewOfAllOfIt) {
  const auto line = [](const std::string& half, const std::string& before = "") {
    return static_cast<double>(lit_pixels(
        before +
        "Shape { appearance Appearance { lineProperties LineProperties { linewidthScaleFactor 40 } "
        "material Material { emissiveColor 1 1 1 } } geometry LineSet { vertexCount [ 2 ] coord "
        "Coordinate { point [ -" +
        half + " 0 0, " + half + " 0 0 ] } } }"));
  };
  EXPECT_GT(line("1"), 32);
  const std::string all = "Viewpoint { viewAll TRUE } ";
  for (const std::string half : {"1000", ".001"}) {
    EXPECT_NEAR(line(half), line("1"), 4) << half;
    EXPECT_NEAR(line(half, all), line("1", all), 4) << half;
  }
}

TEST(X3dNodes, LightsSayWhomTheyReach) {
  const auto scoped = [](const std::string& light) {
    return scene_of(light).nodes(0).light().scoped();
  };
  EXPECT_TRUE(scoped("DirectionalLight { }"));
  EXPECT_FALSE(scoped("DirectionalLight { global TRUE }"));
  EXPECT_FALSE(scoped("PointLight { }"));
  EXPECT_TRUE(scoped("PointLight { global FALSE }"));
  EXPECT_FALSE(scoped("SpotLight { }"));
  // Beside the light's group nothing is lit; a light of 9 metres ends there.
  const std::string lit =
      "NavigationInfo { headlight FALSE } Group { children [ DirectionalLight { } ";
  const std::string wall =
      "Shape { geometry Rectangle2D { } appearance Appearance { material Material { } } } ";
  EXPECT_NEAR(render_x3d(lit + wall + "] }", 1, 1)[0], .8, 1e-6);
  EXPECT_EQ(render_x3d(lit + "] } " + wall, 1, 1)[0], 0);
}

TEST(X3dNodes, ShadowsAreCastAlwaysOrAsTheLightsSayOrNever) {
  using Shadows = ReadOptions::Shadows;
  // A board stands between the wall and the light that comes from behind the camera's side.
  const auto level = [](const std::string& fields, Shadows shadows) {
    ReadOptions options;
    options.x3d_shadows = shadows;
    return render_x3d(
        "NavigationInfo { headlight FALSE } DirectionalLight { direction 0 -1 -1 " + fields +
            " } Shape { geometry Rectangle2D { size 8 8 } appearance Appearance { material "
            "Material { diffuseColor 1 1 1 } } } Transform { translation 0 2 2 children Shape { "
            "geometry Rectangle2D { } } }",
        1, 1, "4.0", options)[0];
  };
  const double lit = std::sqrt(.5);
  EXPECT_EQ(level("", Shadows::on), 0);
  EXPECT_NEAR(level("", Shadows::file), lit, 1e-6);
  EXPECT_EQ(level("shadows TRUE", Shadows::file), 0);
  EXPECT_NEAR(level("shadows TRUE shadowIntensity .25", Shadows::file), .75 * lit, 1e-6);
  EXPECT_NEAR(level("shadows TRUE", Shadows::off), lit, 1e-6);
}

TEST(X3dNodes, MaterialsOfVersionFour) {
  const v1::Scene scene = scene_of(
      shown("alphaMode \"MASK\" alphaCutoff .25 material PhysicalMaterial { baseColor .5 0 0 "
            "metallic .25 "
            "roughness .75 emissiveColor 0 0 .5 transparency .5 normalScale 2 normalTexture "
            "PixelTexture { "
            "image 1 1 3 0x8080FF } metallicRoughnessTexture PixelTexture { image 1 1 3 255 } }"));
  const v1::Material& material = scene.materials(0);
  EXPECT_EQ(material.alpha(), v1::Material::ALPHA_MASK);
  EXPECT_EQ(material.alpha_cutoff(), .25);
  EXPECT_EQ(material.physical().base_color().value().r(), .5);
  EXPECT_EQ(material.physical().emission().value().b(), .5);
  EXPECT_EQ(material.physical().transparency().value(), .5);
  EXPECT_EQ(material.physical().metallic().value(), .25);
  EXPECT_EQ(material.physical().metallic().channel(), v1::FloatInput::BLUE);
  EXPECT_EQ(material.physical().roughness().value(), .75);
  EXPECT_EQ(material.physical().roughness().channel(), v1::FloatInput::GREEN);
  EXPECT_EQ(material.physical().roughness().texture(), material.physical().metallic().texture());
  EXPECT_FALSE(material.normal_map().empty());
  EXPECT_EQ(material.normal_scale(), 2);

  const std::string two = "material Material { } backMaterial Material { diffuseColor 0 0 1 }";
  const v1::Scene open = scene_of(shown(two, "Box { solid FALSE }"));
  ASSERT_EQ(open.materials_size(), 2);
  EXPECT_EQ(open.materials(1).sides(), v1::Material::BACK_MATERIAL);
  EXPECT_EQ(open.materials(1).back(), open.materials(0).name());
  EXPECT_EQ(scene_of(shown(two)).materials(0).sides(), v1::Material::FRONT_ONLY);
}

TEST(X3dNodes, BackFacesAreSeenWhereTheReaderIsToldSo) {
  ReadOptions options;
  options.two_sided = true;
  const auto sides = [](const LoadedScene& loaded) { return loaded.scene.materials(0).sides(); };
  EXPECT_EQ(sides(parse_classic(shown(""), "3.3", options)), v1::Material::TWO_SIDED);
  EXPECT_EQ(sides(parse_classic(shown(""), "3.3")), v1::Material::FRONT_ONLY);
}

TEST(X3dNodes, BackgroundsHaveSixPictures) {
  const v1::Scene by_url = scene_of(
      "Transform { translation 5 0 0 rotation 0 1 0 1 children Background { transparency .25 "
      "frontUrl "
      "\"f.png\" backUrl \"b.png\" leftUrl \"l.png\" rightUrl \"r.png\" topUrl \"t.png\" bottomUrl "
      "\"u.png\" } }");
  const v1::Background::Cube& cube = by_url.background().cube();
  const auto file = [&](const std::string& texture) {
    for (const v1::Texture& each : by_url.textures())
      if (each.name() == texture) return each.image().file();
    return std::string();
  };
  EXPECT_EQ(file(cube.front()), "f.png");
  EXPECT_EQ(file(cube.back()), "b.png");
  EXPECT_EQ(file(cube.left()), "l.png");
  EXPECT_EQ(file(cube.right()), "r.png");
  EXPECT_EQ(file(cube.top()), "t.png");
  EXPECT_EQ(file(cube.bottom()), "u.png");
  EXPECT_EQ(by_url.background().transparency(), .25);
  EXPECT_EQ(by_url.background().orientation().steps_size(),
            2);  // of which only the rotation counts
  // Turned by 90 degrees about y, the left picture is ahead.
  const std::string sky =
      "TextureBackground { leftTexture PixelTexture { image 1 1 3 0x00FF00 } frontTexture "
      "PixelTexture { image 1 1 3 0xFF0000 } }";
  EXPECT_EQ(render_x3d(sky, 1, 1), std::vector<float>({1, 0, 0}));
  EXPECT_EQ(render_x3d("Transform { rotation 0 1 0 -1.5707963 children " + sky + " }", 1, 1),
            std::vector<float>({0, 1, 0}));
}

TEST(X3dNodes, SolidsMayBeOpen) {
  const auto shape = [](const std::string& geometry) {
    return scene_of("Shape { geometry " + geometry + " }").nodes(0).shape();
  };
  const v1::Cylinder tube =
      shape("Cylinder { radius 3 height 4 top FALSE bottom FALSE }").cylinder();
  EXPECT_EQ(tube.radius(), 3);
  EXPECT_EQ(tube.height(), 4);
  EXPECT_TRUE(tube.open_top() && tube.open_bottom() && !tube.open_side());
  EXPECT_TRUE(shape("Cylinder { side FALSE }").cylinder().open_side());
  const v1::Cone cone = shape("Cone { bottomRadius 3 height 4 bottom FALSE }").cone();
  EXPECT_EQ(cone.radius(), 3);
  EXPECT_EQ(cone.height(), 4);
  EXPECT_TRUE(cone.open_bottom() && !cone.open_side());
  EXPECT_TRUE(shape("Cone { side FALSE }").cone().open_side());
  const v1::Disc disc = shape("Disk2D { innerRadius 1 outerRadius 3 }").disc();
  EXPECT_EQ(disc.inner_radius(), 1);
  EXPECT_EQ(disc.radius(), 3);
  EXPECT_EQ(scene_of(shown("", "Disk2D { }")).materials(0).sides(), v1::Material::TWO_SIDED);
}

/// A mesh's values of one kind, corner by corner: `width` numbers each.
std::vector<float> corners(const LoadedScene& loaded, const v1::BlobRef& blob, size_t width) {
  const v1::TriangleMesh& mesh = loaded.scene.nodes(0).shape().mesh();
  const auto values = blob_values<float>(blob, loaded.blobs);
  std::vector<float> out;
  for (const uint32_t i : blob_values<uint32_t>(mesh.triangles(), loaded.blobs))
    for (size_t k = 0; k < width; ++k) out.push_back(values[width * i + k]);
  return out;
}

TEST(X3dNodes, NormalsAndTextureCoordinatesHaveIndicesOfTheirOwn) {
  const auto read = [](const std::string& fields) {
    return parse_classic(
        shown("texture PixelTexture { image 1 1 1 255 }",
              "IndexedFaceSet { coordIndex [ 0 1 2 -1 ] coord Coordinate { point [ 0 0 0 1 "
              "0 0 0 1 0 ] } normal Normal { vector [ 1 0 0 0 1 0 0 0 1 ] } texCoord "
              "TextureCoordinate { point [ 0 0 .25 0 .5 0 ] } " +
                  fields + " }"));
  };
  const auto normals = [&](const std::string& fields) {
    const LoadedScene loaded = read(fields);
    return corners(loaded, loaded.scene.nodes(0).shape().mesh().normals(), 3);
  };
  EXPECT_EQ(normals(""), std::vector<float>({1, 0, 0, 0, 1, 0, 0, 0, 1}));
  EXPECT_EQ(normals("normalIndex [ 2 1 1 -1 ]"), std::vector<float>({0, 0, 1, 0, 1, 0, 0, 1, 0}));
  EXPECT_EQ(normals("normalPerVertex FALSE normalIndex [ 1 ]"),
            std::vector<float>({0, 1, 0, 0, 1, 0, 0, 1, 0}));
  const auto uvs = [&](const std::string& fields) {
    const LoadedScene loaded = read(fields);
    return corners(loaded, loaded.scene.nodes(0).shape().mesh().uvs(), 2);
  };
  EXPECT_EQ(uvs(""), std::vector<float>({0, 0, .25, 0, .5, 0}));
  EXPECT_EQ(uvs("texCoordIndex [ 2 2 1 -1 ]"), std::vector<float>({.5, 0, .5, 0, .25, 0}));
}

TEST(X3dNodes, TriangleNodesAreSmoothUnlessToldAndStripsKeepTheirSide) {
  // A fold of 90 degrees; both points of the edge are shared.
  const auto normals = [](const std::string& fields) {
    const LoadedScene loaded = parse_classic(shown(
        "",
        "IndexedTriangleSet { index [ 0 1 2 2 1 3 ] coord Coordinate { point [ 0 0 1 1 0 0 1 1 0 "
        "2 0 1 ] } " +
            fields + " }"));
    return blob_values<float>(loaded.scene.nodes(0).shape().mesh().normals(), loaded.blobs).size();
  };
  EXPECT_EQ(normals(""), 12u);
  EXPECT_EQ(normals("normalPerVertex FALSE"), 0u);
  const LoadedScene strip = parse_classic(shown("",
                                                "TriangleStripSet { stripCount 5 normalPerVertex "
                                                "FALSE coord Coordinate { point [ 0 0 0 1 0 0 "
                                                "0 1 0 1 1 0 0 2 0 ] } }"));
  const auto p = corners(strip, strip.scene.nodes(0).shape().mesh().positions(), 3);
  ASSERT_EQ(p.size(), 27u);
  for (size_t t = 0; t < p.size(); t += 9)
    EXPECT_GT((p[t + 3] - p[t]) * (p[t + 7] - p[t + 1]) - (p[t + 4] - p[t + 1]) * (p[t + 6] - p[t]),
              0);
}

TEST(X3dNodes, FacesWithoutThreePointsAreLeftOutWithACount) {
  const LoadedScene loaded = parse_classic(shown("",
                                                 "IndexedFaceSet { coordIndex [ 0 1 2 -1 0 1 -1 1 "
                                                 "1 2 -1 2 -1 ] coord Coordinate { point [ 0 0 "
                                                 "0 1 0 0 0 1 0 ] } }"));
  EXPECT_EQ(loaded.scene.nodes(0).shape().mesh().triangles().size(), 12u);
  ASSERT_EQ(loaded.warnings.size(), 1u);
  EXPECT_EQ(loaded.warnings[0],
            "t.x3dv:2:84: faces with fewer than 3 different points are left out (3 times)");
}

TEST(X3dNodes, TexturesRepeatOrEnd) {
  using Image = v1::Texture::Image;
  const auto image = [](const std::string& fields) {
    return scene_of(shown("texture ImageTexture { url \"a.png\" " + fields + " }"))
        .textures(0)
        .image();
  };
  EXPECT_EQ(image("").wrap_s(), Image::REPEAT);
  EXPECT_EQ(image("repeatS FALSE").wrap_s(), Image::CLAMP);
  EXPECT_EQ(image("repeatS FALSE").wrap_t(), Image::REPEAT);
  EXPECT_EQ(image("repeatT FALSE").wrap_t(), Image::CLAMP);
  const Image both = image(
      "repeatS FALSE textureProperties TextureProperties { boundaryModeS \"MIRRORED_REPEAT\" "
      "boundaryModeT \"CLAMP_TO_EDGE\" }");
  EXPECT_EQ(both.wrap_s(), Image::MIRROR);
  EXPECT_EQ(both.wrap_t(), Image::CLAMP);
}

TEST(X3dNodes, OfAMultiTextureTheFirstIsRead) {
  const LoadedScene loaded =
      parse_classic(shown("texture MultiTexture { texture [ ImageTexture { url \"a.png\" } "
                          "ImageTexture { url \"b.png\" } ] } "
                          "textureTransform MultiTextureTransform { textureTransform [ "
                          "TextureTransform { scale 2 3 } ] }"));
  ASSERT_EQ(loaded.scene.textures_size(), 1);
  EXPECT_EQ(loaded.scene.textures(0).image().file(), "a.png");
  EXPECT_EQ(loaded.scene.textures(0).transform().steps(0).scale().y(), 3);
  ASSERT_EQ(loaded.warnings.size(), 1u);
  EXPECT_EQ(loaded.warnings[0], "t.x3dv:2:41: of a MultiTexture only the first texture is read");
}

TEST(X3dNodes, TextureTransformsMoveTurnAndScaleAboutTheirCentre) {
  const v1::Transform transform =
      scene_of(shown("texture ImageTexture { url \"a.png\" } textureTransform TextureTransform { "
                     "center .5 .25 "
                     "rotation 1.5707963267948966 scale 2 4 translation 3 5 }"))
          .textures(0)
          .transform();
  // -C S R C T, of which the first step is the last to act.
  ASSERT_EQ(transform.steps_size(), 5);
  EXPECT_EQ(transform.steps(0).translate().x(), -.5);
  EXPECT_EQ(transform.steps(1).scale().y(), 4);
  EXPECT_NEAR(transform.steps(2).rotate().angle(), 90, 1e-12);
  EXPECT_EQ(transform.steps(3).translate().y(), .25);
  EXPECT_EQ(transform.steps(4).translate().x(), 3);
}

TEST(X3dNodes, TextureCoordinatesAreGeneratedByMode) {
  const auto mapping = [](const std::string& mode, size_t warnings) {
    const LoadedScene loaded = parse_classic(
        shown("texture ImageTexture { url \"a.png\" }",
              "TriangleSet { coord Coordinate { point [ 0 0 0 1 0 0 0 1 0 ] } texCoord "
              "TextureCoordinateGenerator { " +
                  mode + " } }"));
    EXPECT_EQ(loaded.warnings.size(), warnings) << mode;
    return loaded.scene.textures(0).mapping();
  };
  EXPECT_EQ(mapping("", 0), v1::Texture::VIEW_NORMAL);
  EXPECT_EQ(mapping("mode \"COORD\"", 0), v1::Texture::OBJECT);
  EXPECT_EQ(mapping("mode \"SPHERE-LOCAL\"", 0), v1::Texture::OBJECT_NORMAL);
  EXPECT_EQ(mapping("mode \"NOISE\"", 1), v1::Texture::VIEW_NORMAL);
}

}  // namespace
}  // namespace tessera
