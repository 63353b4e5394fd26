#include "scenes/formats/obj/mtl_reader.h"

#include <gtest/gtest.h>

#include "tests/unit/scenes/scene_testing.h"

namespace tessera {
namespace {

MtlMaterials read(const std::string& text, Warnings& warnings) {
  MtlMaterials materials;
  LineReader reader(text, "t.mtl");
  read_mtl(reader, materials, warnings);
  return materials;
}

v1::Classic classic(const std::string& body) {
  Warnings warnings;
  return read("newmtl m\n" + body, warnings).at("m").classic();
}

std::string error(const std::string& text) {
  Warnings warnings;
  return error_of([&] { read(text, warnings); });
}

TEST(Mtl, AByteOrderMarkIsNoPartOfTheFirstWord) {
  Warnings warnings;
  EXPECT_EQ(read("\xEF\xBB\xBFnewmtl m\nKd 1 1 1\n", warnings).count("m"), 1u);
}

TEST(Mtl, ReadsTheClassicTerms) {
  const v1::Classic c =
      classic("Ka .1 .2 .3\nKd .4 .5 .6\nKs .7 .8 .9\nKe 1 2 3\nNs 50\nillum 2\n");
  EXPECT_FLOAT_EQ(c.ambient().value().g(), .2f);
  EXPECT_FLOAT_EQ(c.diffuse().value().b(), .6f);
  EXPECT_FLOAT_EQ(c.specular().value().r(), .7f);
  EXPECT_FLOAT_EQ(c.emission().value().b(), 3);
  EXPECT_FLOAT_EQ(c.shininess().value(), 50);
  EXPECT_FALSE(c.has_reflectivity());
  EXPECT_FALSE(c.has_transparency());
  EXPECT_FLOAT_EQ(classic("Kd .5\n").diffuse().value().b(), .5f);
  EXPECT_FLOAT_EQ(classic("").diffuse().value().g(), .8f);
}

TEST(Mtl, TakesDissolveOverItsOpposite) {
  EXPECT_FLOAT_EQ(classic("d .25\n").transparency().value(), .75f);
  EXPECT_FLOAT_EQ(classic("Tr .25\n").transparency().value(), .25f);
  EXPECT_FLOAT_EQ(classic("Tr .25\nd .9\n").transparency().value(), .1f);
  EXPECT_EQ(classic("d .25\n").transmission(), v1::Classic::STRAIGHT);
  EXPECT_FALSE(classic("Tf 1 1 1\n").has_transparency());
}

TEST(Mtl, FollowsTheIlluminationModel) {
  Warnings warnings;
  EXPECT_TRUE(read("newmtl m\nKd 1 0 0\nillum 0\n", warnings).at("m").has_unlit());
  EXPECT_FALSE(classic("Ks 1 1 1\nillum 1\n").has_specular());
  EXPECT_FLOAT_EQ(classic("Ks .5 .5 .5\nillum 3\n").reflectivity().value().r(), .5f);
  const v1::Classic glass = classic("Kd .5 .5 .5\nTf 1 1 1\nNi 1.3\nillum 7\n");
  EXPECT_EQ(glass.transmission(), v1::Classic::REFRACT);
  EXPECT_FLOAT_EQ(glass.transparency().value(), 1);
  EXPECT_FLOAT_EQ(glass.refractive_index(), 1.3f);
  EXPECT_FLOAT_EQ(glass.diffuse().value().r(), 0);
}

TEST(Mtl, NamesWhatItDoesNotRead) {
  Warnings warnings;
  read("newmtl a b\nmap_Kd x.png\nPr .5\nfoo\nnewmtl a b\n", warnings);
  EXPECT_EQ(
      warnings.list("t.mtl"),
      (std::vector<std::string>{"t.mtl: texture (map_Kd) is not read yet",
                                "t.mtl: physical parameter 'Pr' is not read yet",
                                "t.mtl: unknown statement 'foo' is left out",
                                "t.mtl: material 'a b' comes twice; the first one is taken"}));
}

TEST(Mtl, SaysWhereAndWhatIsWrong) {
  EXPECT_EQ(error("Kd 1 1 1\n"), "t.mtl:1:1: 'Kd'; expected newmtl before it");
  EXPECT_EQ(error("newmtl\n"), "t.mtl:1:7: newmtl without a name; expected a material's name");
  EXPECT_EQ(error("newmtl a\nKd 1 x 1\n"), "t.mtl:2:6: 'x'; expected a colour component");
  EXPECT_EQ(error("newmtl a\nillum 11\n"),
            "t.mtl:2:7: '11'; expected an illumination model of 0 to 10");
  EXPECT_EQ(error("newmtl a\nillum 3e30\n"),
            "t.mtl:2:7: '3e30'; expected an illumination model of 0 to 10");
  EXPECT_EQ(error("newmtl a\nNs nan\n"), "t.mtl:2:4: 'nan'; expected an exponent that is finite");
}

}  // namespace
}  // namespace tessera
