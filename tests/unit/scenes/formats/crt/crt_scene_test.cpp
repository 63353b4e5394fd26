#include <fmt/format.h>
#include <gmock/gmock.h>

#include <cmath>

#include "base/file.h"
#include "proto/wire/scene_codec.h"
#include "tests/unit/scenes/formats/crt/crt_support.h"

namespace tessera::crt_test {
namespace {

using testing::ElementsAre;
using testing::HasSubstr;

std::vector<double> frame_of(const std::string& position, const std::string& pointing) {
  const v1::Scene scene = read("cam = Camera { position -> " + position + " pointing -> " +
                               pointing + " fov -> 50 }\nSettings { camera -> cam }\nScene { }")
                              .scene;
  const auto& rows = scene.cameras(0).world_from_camera().steps(0).matrix().rows();
  return {rows.begin(), rows.end()};
}

TEST(CrtScene, TheCameraMirrorsALeftHandedWorld) {
  // Columns: right, up, against the view, position.
  EXPECT_THAT(frame_of("vec3(1, 2, 3)", "vec3(1, 2, 9)"),
              ElementsAre(1, 0, 0, 1, 0, 1, 0, 2, 0, 0, -1, 3));
  EXPECT_THAT(frame_of("vec3(0, 0, 0)", "vec3(2, 0, 0)"),
              ElementsAre(0, 0, -1, 0, 0, 1, 0, 0, -1, 0, 0, 0));
}

TEST(CrtScene, StraightUpAndDownHaveAnUpOfTheirOwn) {
  EXPECT_THAT(frame_of("vec3(0, 0, 0)", "vec3(0, 3, 0)"),
              ElementsAre(0, 1, 0, 0, 0, 0, -1, 0, 1, 0, 0, 0));
  EXPECT_THAT(frame_of("vec3(0, 0, 0)", "vec3(0, -3, 0)"),
              ElementsAre(0, -1, 0, 0, 0, 0, 1, 0, 1, 0, 0, 0));
}

TEST(CrtScene, SettingsHaveTheOriginalsDefaults) {
  const v1::Scene scene = scene_of("", "");
  EXPECT_EQ(scene.metadata().title(), "Unnamed Scene");
  EXPECT_EQ(scene.metadata().author(), "Unknown Author");
  EXPECT_EQ(scene.settings().sampling().samples_per_pixel(), 1u);
  EXPECT_EQ(scene.settings().integrator().max_depth(), 3u);
  EXPECT_EQ(scene.settings().output().transfer(), v1::Output::DISPLAY);
  EXPECT_EQ(scene.settings().output().quantization(), v1::Output::TRUNCATE);
  EXPECT_EQ(scene.background().solid().g(), 1);
  EXPECT_FALSE(scene.cameras(0).has_lens());
  EXPECT_EQ(scene.cameras(0).perspective().axis(), v1::Perspective::VERTICAL);
  EXPECT_EQ(scene.cameras(0).perspective().field_of_view(), 60);
}

TEST(CrtScene, SettingsAreTranslated) {
  const v1::Scene scene = scene_of("", "",
                                   "supersampling -> 4 recursiondepth -> 0 notes -> \"n\" "
                                   "author -> \"a\" width -> 320 height -> 200");
  EXPECT_EQ(scene.settings().sampling().samples_per_pixel(), 16u);
  EXPECT_EQ(scene.settings().sampling().pattern(), v1::Sampling::CORNER_GRID);
  EXPECT_TRUE(scene.settings().integrator().has_max_depth());
  EXPECT_EQ(scene.settings().integrator().max_depth(), 0u);
  EXPECT_EQ(scene.metadata().author(), "a");  // the original lets notes replace it
  EXPECT_EQ(scene.metadata().notes(), "n");
  EXPECT_EQ(scene.settings().width(), 320u);
  EXPECT_EQ(scene_of("", "", "supersampling -> -3").settings().sampling().samples_per_pixel(), 1u);
  EXPECT_THAT(complaint_of("", "", "supersampling -> 5000"), HasSubstr("at most 1024"));
}

TEST(CrtScene, TheLensFollowsTheFramesSize) {
  const std::string camera =
      "c = Camera { position -> vec3(0,0,0) pointing -> vec3(0,0,1) fov -> 40 aperture -> 50 "
      "focaldistance -> 3.7 apertureshape -> \"Hexagon\" }";
  const v1::Lens lens = scene_of(camera, "", "camera -> c dofsamples -> 32").cameras(0).lens();
  EXPECT_EQ(lens.radius_x(), 50);
  EXPECT_EQ(lens.radius_y(), 50);
  EXPECT_EQ(lens.radius_unit(), v1::Lens::METRES_OVER_FRAME);
  EXPECT_EQ(lens.focal_surface(), v1::Lens::SPHERE);
  EXPECT_EQ(lens.focal_distance(), 3.7);
  EXPECT_EQ(lens.shape(), v1::Lens::POLYGON);
  EXPECT_EQ(lens.blades(), 6u);
  EXPECT_EQ(lens.samples(), 32u);
  EXPECT_FALSE(scene_of(camera, "", "camera -> c").cameras(0).has_lens());
}

TEST(CrtScene, LightsReachAllTheWay) {
  const v1::Scene scene = scene_of(
      "l = PointLight { origin -> vec3(1, 2, 3) color -> rgb(.5, .25, 0) falloff -> 15 }\n"
      "s = ParallelLight { from -> vec3(0, 2, 0) pointing -> vec3(0, 0, 0) color -> rgb(1, 1, 1) "
      "ambient -> .3 }",
      "", "lights -> [l] lights -> s");
  ASSERT_EQ(scene.nodes_size(), 2);
  const v1::Light& point = scene.nodes(0).light();
  EXPECT_EQ(point.name(), "l");
  EXPECT_EQ(point.point().position().z(), 3);
  EXPECT_EQ(point.attenuation().scale(), 15);
  EXPECT_EQ(point.attenuation().quadratic(), 1);
  EXPECT_EQ(point.attenuation().distance(), v1::Attenuation::PATH);
  const v1::Light& sun = scene.nodes(1).light();
  EXPECT_EQ(sun.directional().direction().y(), -1);
  EXPECT_EQ(sun.ambient_intensity(), .3);
  EXPECT_EQ(sun.shadow_distance(), 10000);
  EXPECT_FALSE(sun.has_attenuation());
}

TEST(CrtScene, SpotsAndRoundBeams) {
  const v1::Scene scene = scene_of(
      "l = SpotLight { origin -> vec3(1, 2, 3) pointing -> vec3(1, 0, 3) color -> rgb(1, 1, 1) "
      "angle -> 30 beam -> 20 falloff -> 5 }\n"
      "s = CylinderLight { origin -> vec3(0, 2, 0) pointing -> vec3(3, 2, 0) color -> rgb(1, 1, 1) "
      "radius -> .5 ambient -> .1 }",
      "", "lights -> [l, s]");
  ASSERT_EQ(scene.nodes_size(), 2);
  const v1::Light::Spot& spot = scene.nodes(0).light().spot();
  EXPECT_EQ(spot.position().z(), 3);
  EXPECT_EQ(spot.direction().y(), -1);
  EXPECT_EQ(spot.cut_off(), 30);
  EXPECT_EQ(spot.beam_width(), 20);
  EXPECT_EQ(scene.nodes(0).light().attenuation().scale(), 5);
  const v1::Light& beam = scene.nodes(1).light();
  EXPECT_EQ(beam.cylinder().direction().x(), 1);
  EXPECT_EQ(beam.cylinder().beam_radius(), .5);
  EXPECT_EQ(beam.ambient_intensity(), .1);
  EXPECT_THAT(complaint_of("l = SpotLight { origin -> vec3(1, 2, 3) pointing -> vec3(1, 2, 3) "
                           "color -> rgb(1, 1, 1) angle -> 20 }"),
              HasSubstr("a light where it points to"));
  EXPECT_THAT(complaint_of("l = SpotLight { origin -> vec3(1, 2, 3) pointing -> vec3(1, 0, 3) "
                           "color -> rgb(1, 1, 1) angle -> 20 beam -> 21 }"),
              HasSubstr("beam"));
}

TEST(CrtScene, GlassAbsorbsAndReliefBumps) {
  const v1::Scene scene = scene_of(
      "g = Material { color -> rgb(1, 1, 1) transparency -> .9 refractIndex -> 1.5 "
      "absorption -> rgb(.5, 1, 2) bump -> Noise { frequency -> 4 } bumpheight -> .2 }",
      "Sphere { center -> vec3(0,0,0) radius -> 1 material -> g }");
  const v1::Material& glass = scene.materials(0);
  EXPECT_EQ(glass.classic().absorption().b(), 2);
  EXPECT_EQ(glass.classic().refractive_index(), 1.5);
  EXPECT_EQ(glass.bump().value(), .2);
  ASSERT_EQ(scene.textures_size(), 1);
  EXPECT_EQ(glass.bump().texture(), scene.textures(0).name());
  EXPECT_THAT(complaint_of("g = Material { color -> rgb(1, 1, 1) absorption -> rgb(0, -1, 0) }"),
              HasSubstr("absorption"));
}

TEST(CrtScene, MaterialsShareOutTheirLight) {
  const v1::Scene scene = scene_of("r = Material { color -> rgb(1, .5, 1.6) reflectivity -> .25 }",
                                   "Sphere { center -> vec3(0,0,0) radius -> 1 material -> r }");
  ASSERT_EQ(scene.materials_size(), 1);
  const v1::Classic& classic = scene.materials(0).classic();
  EXPECT_EQ(scene.materials(0).name(), "r");
  EXPECT_EQ(classic.diffuse().value().g(), .375);
  EXPECT_EQ(classic.diffuse().value().b(), 1.6 * .75);
  EXPECT_EQ(classic.ambient().value().g(), .75);  // not tinted
  EXPECT_EQ(classic.reflectivity().value().g(), .25);
  EXPECT_EQ(classic.diffuse_model(), v1::Classic::SIGNED);
}

TEST(CrtScene, PlanesAreSeenFromTheFrontWhereTheyStandAlone) {
  const std::string plane =
      "p = Plane { normal -> vec3(0, 2, 0) position -> vec3(5, 3, 1) material -> m }\n"
      "s = " +
      sphere("1");
  const v1::Scene scene = scene_of(plane, "p s s - p");
  EXPECT_EQ(scene.nodes(0).shape().plane().offset(), 3);
  ASSERT_EQ(scene.materials_size(), 2);
  EXPECT_EQ(scene.materials(0).sides(), v1::Material::FRONT_ONLY);
  EXPECT_EQ(scene.materials(1).sides(), v1::Material::TWO_SIDED);
  const v1::Csg& csg = scene.nodes(2).shape().csg();
  EXPECT_EQ(csg.operands(1).shape().materials(0), scene.materials(1).name());
}

TEST(CrtScene, ChainsOfOneOperationJoin) {
  const std::string s = "a = " + sphere("1") + "b = " + sphere("2") + "c = " + sphere("3");
  EXPECT_EQ(scene_of(s, "a + b + c").nodes(0).shape().csg().operands_size(), 3);
  EXPECT_EQ(scene_of(s, "a - b - c").nodes(0).shape().csg().operands_size(), 3);
  EXPECT_EQ(scene_of(s, "a - (b + c)").nodes(0).shape().csg().operands_size(), 3);
  EXPECT_EQ(scene_of(s, "a - (b - c)").nodes(0).shape().csg().operands_size(), 2);
  const v1::Csg mixed = scene_of(s, "a - b ^ c").nodes(0).shape().csg();
  EXPECT_EQ(mixed.operation(), v1::Csg::INTERSECTION);
  EXPECT_EQ(mixed.operands(0).shape().csg().operation(), v1::Csg::DIFFERENCE);
  EXPECT_EQ(mixed.operands(1).shape().sphere().radius(), 3);
  EXPECT_EQ(scene_of(s, "Difference { a b c }").nodes(0).shape().csg().operands_size(), 3);
}

TEST(CrtScene, UnionsFallApartWhereNothingTouches) {
  const auto part = [](int number, const std::string& x, const std::string& radius) {
    return fmt::format("s{} = {}", number, sphere(radius, "vec3(" + x + ", 0, 0)"));
  };
  // The first and the third touch, by way of the fourth; the second is by itself.
  const std::string four = part(1, "0", "1") + part(2, "9", "1") + part(3, "4", "1") +
                           part(4, "2", "1") + "all = s1 + s2 + s3 + s4\n";
  const v1::Node whole = scene_of(four, "all <scale 2>").nodes(0);
  EXPECT_EQ(whole.transform().steps_size(), 1);
  EXPECT_FALSE(whole.has_shape());
  ASSERT_EQ(whole.children_size(), 2);
  ASSERT_EQ(whole.children(0).shape().csg().operands_size(), 3);
  EXPECT_EQ(whole.children(0).shape().csg().operation(), v1::Csg::UNION);
  EXPECT_EQ(whole.children(0).shape().csg().operands(1).name(), "s3");
  EXPECT_EQ(whole.children(1).shape().sphere().center().x(), 9);
  EXPECT_EQ(whole.children(1).name(), "s2");
  // What they are part of needs them whole, and a plane is everywhere.
  EXPECT_EQ(scene_of(four, "all ^ s1").nodes(0).children_size(), 0);
  const std::string plane =
      "Plane { normal -> vec3(0, 1, 0) position -> vec3(0, -5, 0) material -> m }";
  EXPECT_EQ(scene_of(four, "s1 + s2 + " + plane).nodes(0).shape().csg().operands_size(), 3);
  // Of a difference it is the first solid that counts; what is turned is not looked at.
  EXPECT_EQ(scene_of(four, "(s1 - s4) + s2").nodes(0).children_size(), 2);
  EXPECT_EQ(scene_of(four, "s1 <rotate vec3(0, 9, 0)> + s2").nodes(0).children_size(), 0);
}

TEST(CrtScene, ModifiersComposeFromLeftToRight) {
  const v1::Scene scene = scene_of("s = " + sphere("1"),
                                   "s <scale 2, translate vec3(1, 0, 0)>\n"
                                   "Union { s s <rotate vec3(0, 90, 10)> } <scale vec3(1, 2, 3)>");
  const v1::Transform& first = scene.nodes(0).transform();
  ASSERT_EQ(first.steps_size(), 2);  // the description's first step is the outermost
  EXPECT_EQ(first.steps(0).translate().x(), 1);
  EXPECT_EQ(first.steps(1).scale().y(), 2);
  EXPECT_EQ(scene.nodes(1).transform().steps(0).scale().z(), 3);
  const v1::Transform& turned = scene.nodes(1).shape().csg().operands(1).transform();
  ASSERT_EQ(turned.steps_size(), 2);
  EXPECT_EQ(turned.steps(1).rotate().axis().y(), 1);
  EXPECT_EQ(turned.steps(1).rotate().angle(), 90);
  EXPECT_EQ(turned.steps(0).rotate().angle(), 10);
  EXPECT_THAT(complaint_of("s = " + sphere("1"), "s <scale 0>"), HasSubstr("scale by 0"));
}

TEST(CrtScene, ASphereWithoutRadiusIsNotThere) {
  EXPECT_EQ(scene_of("", sphere("0.0 + t * 0.5")).nodes_size(), 0);
  EXPECT_EQ(scene_of("", sphere("0.0 + t * 0.5"), "", 1).nodes_size(), 1);
  const std::string two = "a = " + sphere("0") + "b = " + sphere("1");
  EXPECT_TRUE(scene_of(two, "b - a").nodes(0).shape().has_sphere());
  EXPECT_EQ(scene_of(two, "a - b").nodes_size(), 0);
}

TEST(CrtScene, ConesAndCylindersGoFromBaseToTop) {
  const v1::Scene scene = scene_of(
      "", "Cylinder { base -> vec3(0, 0, 0) top -> vec3(4, 0, 0) radius -> .5 material -> m }");
  const v1::Node& node = scene.nodes(0);
  EXPECT_EQ(node.shape().cylinder().height(), 4);
  const auto& rows = node.transform().steps(0).matrix().rows();
  EXPECT_EQ(rows[1], 1);  // y goes to x
  EXPECT_EQ(rows[3], 2);  // about the middle
}

TEST(CrtScene, BackgroundsByPriority) {
  const auto background = [](const std::string& attributes) {
    return scene_of("b = Background { " + attributes + " }", "", "background -> b").background();
  };
  EXPECT_EQ(background("color -> rgb(.5, 0, 0)").solid().r(), .5);
  const v1::Background gradient =
      background("color -> rgb(0,0,0) horizon -> rgb(1,1,1) sky -> rgb(0,0,1)");
  EXPECT_EQ(gradient.gradient().model(), v1::Background::Gradient::ABSOLUTE_Y);
  EXPECT_EQ(gradient.gradient().ground().r(), 1);
  const v1::Scene panorama = scene_of(
      "b = Background { image -> \"/images/sky.jpg\" angle -> 3.4 }", "", "background -> b");
  EXPECT_EQ(panorama.background().panorama().mapping(),
            v1::Background::Panorama::CYLINDRICAL_EQUAL_AREA);
  EXPECT_NEAR(panorama.background().panorama().angle(), -3.4 * 180 / M_PI, 1e-9);
  EXPECT_EQ(panorama.textures(0).image().file(), "images/sky.jpg");
  EXPECT_TRUE(panorama.textures(0).image().texels_at_corners());
}

TEST(CrtScene, EveryPrimitiveIsTranslated) {
  const auto shape = [](const std::string& object) {
    return scene_of("", object).nodes(0).shape();
  };
  const v1::Box box =
      shape("Box { cornerA -> vec3(1, -2, 3) cornerB -> vec3(-1, 2, -3) material -> m }").box();
  EXPECT_EQ(box.min().x(), -1);
  EXPECT_EQ(box.max().z(), 3);
  const v1::HalfPlane half =
      shape(
          "HalfPlane { normal -> vec3(0, 3, 0) position -> vec3(1, 2, 3) edge -> vec3(0, 0, 2) "
          "material -> m }")
          .half_plane();
  EXPECT_EQ(half.normal().y(), 1);
  EXPECT_EQ(half.point().z(), 3);
  EXPECT_EQ(half.edge_normal().z(), 1);
  const v1::Disc disc =
      shape("Disc { center -> vec3(1, 2, 3) radius -> 2 hole -> .5 material -> m }").disc();
  EXPECT_EQ(disc.center().y(), 2);
  EXPECT_EQ(disc.normal().y(), 1);
  EXPECT_EQ(disc.radius(), 2);
  EXPECT_EQ(disc.inner_radius(), .5);
  const v1::TriangleMesh triangle =
      shape("Triangle { a -> vec3(0, 0, 0) b -> vec3(1, 0, 0) c -> vec3(0, 1, 7) material -> m }")
          .mesh();
  EXPECT_EQ(triangle.inline_triangles_size(), 3);
  EXPECT_EQ(triangle.inline_positions(8), 7);
  const v1::Cone cone =
      shape(
          "Cone { base -> vec3(0, 1, 0) top -> vec3(0, 4, 0) radius -> 2 topradius -> 1 "
          "open -> true material -> m }")
          .cone();
  EXPECT_EQ(cone.height(), 3);
  EXPECT_EQ(cone.radius(), 2);
  EXPECT_EQ(cone.top_radius(), 1);
  EXPECT_TRUE(cone.open_bottom());
  const v1::Cylinder tube =
      shape(
          "Cylinder { base -> vec3(0, 1, 0) top -> vec3(0, 4, 0) radius -> 2 open -> true "
          "material -> m }")
          .cylinder();
  EXPECT_TRUE(tube.open_top() && tube.open_bottom());
  const v1::Torus torus =
      shape("Torus { center -> vec3(0, 0, 0) radius -> 2 thickness -> .5 material -> m }").torus();
  EXPECT_EQ(torus.major_radius(), 2);
  EXPECT_EQ(torus.minor_radius(), .5);
}

TEST(CrtScene, ProceduralTexturesAreTranslated) {
  const auto texture = [](const std::string& object) {
    const v1::Scene scene =
        scene_of("p = Material { color -> " + object + " }",
                 "Sphere { center -> vec3(0, 0, 0) radius -> 1 material -> p }");
    EXPECT_EQ(scene.materials(0).classic().diffuse().texture(), scene.textures(0).name());
    EXPECT_EQ(scene.textures(0).mapping(), v1::Texture::OBJECT);
    return scene.textures(0);
  };
  using Noise = v1::Texture::Noise;
  for (const auto& [name, kind] : {std::pair{"Noise", Noise::PERLIN},
                                   {"Turbulence", Noise::TURBULENCE},
                                   {"Marble", Noise::MARBLE},
                                   {"Wood", Noise::WOOD}}) {
    const Noise noise = texture(std::string(name) +
                                " { low -> rgb(.25, 0, 0) high -> rgb(0, .5, 0) frequency -> 3 "
                                "octaves -> 4 strength -> 2 }")
                            .noise();
    EXPECT_EQ(noise.kind(), kind) << name;
    EXPECT_EQ(noise.low().r(), .25);
    EXPECT_EQ(noise.high().g(), .5);
    EXPECT_EQ(noise.frequency(), 3);
    EXPECT_EQ(noise.octaves(), 4u);
    EXPECT_EQ(noise.strength(), 2);
  }
  const v1::Texture checker = texture("Checker { odd -> rgb(1, 0, 0) size -> 4 }");
  EXPECT_EQ(checker.checker().odd().value().g(), 0);
  EXPECT_EQ(checker.checker().even().value().g(), 1);
  EXPECT_EQ(checker.transform().steps(0).scale().x(), .25);
  EXPECT_THAT(complaint_of("n = Noise { octaves -> 17 }"), HasSubstr("1 to 16"));
}

TEST(CrtScene, MaterialsShineAndAreClear) {
  const v1::Scene scene = scene_of(
      "g = Material { color -> rgb(1, .5, 0) specular -> .5 shininess -> 40 transparency -> .25 "
      "refractIndex -> 1.3 }",
      "Sphere { center -> vec3(0, 0, 0) radius -> 1 material -> g }");
  const v1::Classic& classic = scene.materials(0).classic();
  EXPECT_EQ(classic.specular().value().g(), .25);
  EXPECT_EQ(classic.specular_model(), v1::Classic::PHONG);
  EXPECT_EQ(classic.shininess().value(), 40);
  EXPECT_EQ(classic.transparency().value(), .25);
  EXPECT_EQ(classic.refractive_index(), 1.3);
}

TEST(CrtScene, ProjectionsAndApertures) {
  const auto camera = [](const std::string& fields) {
    return scene_of("c = Camera { position -> vec3(0, 0, 0) pointing -> vec3(0, 0, 1) fov -> 40 " +
                        fields + " }",
                    "", "camera -> c dofsamples -> 2")
        .cameras(0);
  };
  EXPECT_EQ(camera("").perspective().field_of_view(), 40);
  EXPECT_EQ(camera("projection -> \"spherical\"").spherical().field_of_view(), 40);
  EXPECT_EQ(camera("projection -> \"cylindrical\"").cylindrical().field_of_view(), 40);
  const auto lens = [&](const std::string& shape) {
    return camera("apertureshape -> \"" + shape + "\"").lens();
  };
  EXPECT_EQ(camera("").lens().shape(), v1::Lens::CIRCLE);
  EXPECT_EQ(camera("").lens().radius_x(), 3);
  EXPECT_EQ(camera("").lens().focal_distance(), .5);
  EXPECT_EQ(lens("line").shape(), v1::Lens::LINE);
  EXPECT_EQ(lens("uniform").shape(), v1::Lens::SQUARE_UNIFORM);
  EXPECT_EQ(lens("gaussian").shape(), v1::Lens::GAUSSIAN);
  uint32_t blades = 3;
  for (const char* polygon : {"triangle", "square", "pentagon", "hexagon"}) {
    EXPECT_EQ(lens(polygon).shape(), v1::Lens::POLYGON);
    EXPECT_EQ(lens(polygon).blades(), blades++);
  }
}

TEST(CrtScene, MeshesComeFromFiles) {
  const v1::Scene scene = scene_of("", "Mesh { file -> \"a.obj\" material -> m }");
  ASSERT_EQ(scene.includes_size(), 1);
  EXPECT_EQ(scene.includes(0).file(), "a.obj");
  EXPECT_TRUE(scene.includes(0).geometry_only());
  EXPECT_EQ(scene.includes(0).material(), "m");
  // From the right-handed world of models into the left-handed one of scripts.
  bool mirrored = false;
  for (const v1::Transform::Step& step : scene.includes(0).transform().steps())
    mirrored |= step.has_scale() && step.scale().z() == -1;
  EXPECT_TRUE(mirrored);
  EXPECT_THAT(complaint_of("", "Mesh { file -> \"a.obj\" } - " + sphere("1")), HasSubstr("Mesh"));
}

TEST(CrtScene, FilesAreLookedForInsideTheFolderOnly) {
  const auto folder = std::filesystem::temp_directory_path() / "tessera_crt_test";
  std::filesystem::create_directories(folder);
  const std::string path = (folder / "a.crt").string();
  const auto written = [&](const std::string& image) {
    write_output_file(
        path, script("b = Background { image -> \"" + image + "\" }", "", "background -> b"));
    try {
      read_crt(path, {});
    } catch (const Error& error) {
      return std::string(error.what());
    }
    return std::string();
  };
  EXPECT_THAT(written("/images/none.jpg"), HasSubstr("there is no file"));
  EXPECT_THAT(written("../../etc/passwd"), HasSubstr("not inside the scene's folder"));
  EXPECT_THAT(written(""), HasSubstr("a file without a name"));
  write_output_file((folder / "sky.png").string(), "picture");
  EXPECT_EQ(written("/sky.png"), "");
  std::filesystem::remove_all(folder);
}

TEST(CrtScene, EverySceneSurvivesItsTextForm) {
  const LoadedScene loaded = read(
      script("a = " + sphere("1") + "l = PointLight { origin -> vec3(1,2,3) color -> rgb(1,1,1) }",
             "a - (a ^ a) <translate vec3(0.5, 0, 0)>\n"
             "Torus { center -> vec3(0,0,0) radius -> 2 thickness -> .5 material -> m }\n"
             "Triangle { a -> vec3(0,0,0) b -> vec3(1,0,0) c -> vec3(0,1,0) material -> m }",
             "lights -> [l]"));
  const std::string text = encode_scene(loaded.scene, loaded.blobs, SceneEncoding::text);
  const SceneWithBlobs again = decode_scene(text, SceneEncoding::text, "again.tessera");
  EXPECT_EQ(serialize_scene(again.scene), serialize_scene(loaded.scene));
}

}  // namespace
}  // namespace tessera::crt_test
