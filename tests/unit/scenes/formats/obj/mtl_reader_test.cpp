#include "scenes/formats/obj/mtl_reader.h"

#include <gtest/gtest.h>

#include "tests/unit/scenes/scene_testing.h"

namespace tessera {
namespace {

MtlLibrary read_library(const std::string& text, Warnings& warnings) {
  MtlLibrary library;
  LineReader reader(text, "t.mtl");
  read_mtl(reader, {}, library, warnings);
  return library;
}

std::map<std::string, v1::Material> read(const std::string& text, Warnings& warnings) {
  return read_library(text, warnings).materials;
}

v1::Classic classic(const std::string& body) {
  Warnings warnings;
  return read("newmtl m\n" + body, warnings).at("m").classic();
}

/// What is said of the one statement that is left out.
std::string mtl_error(const std::string& text) {
  Warnings warnings;
  read(text, warnings);
  const std::vector<std::string> list = warnings.list("t.mtl");
  const std::string all = list.size() == 1 ? list[0] : testing::PrintToString(list);
  const std::string end = "; the statement is left out";
  return all.ends_with(end) ? all.substr(0, all.size() - end.size()) : all;
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

TEST(Mtl, WhollyTransparentByTrAloneIsOpaque) {
  Warnings warnings;
  const auto materials = read(
      "newmtl a\nKd 1 0 0\nTr 1.000000\nnewmtl b\nPm 0\nTr 1\nnewmtl clear\nd 0\nTr 1\n"
      "newmtl glass\nTr 1\nillum 7\n",
      warnings);
  EXPECT_FALSE(materials.at("a").classic().has_transparency());
  EXPECT_FALSE(materials.at("b").physical().has_transparency());
  EXPECT_EQ(materials.at("clear").classic().transparency().value(), 1);
  EXPECT_EQ(materials.at("glass").classic().transparency().value(), 1);
  EXPECT_EQ(warnings.list("t.mtl"),
            std::vector<std::string>{"t.mtl:3:4: Tr: 1, so that nothing would be seen; expected a "
                                     "share below 1, or d; 0 is taken (2 times)"});
}

TEST(Mtl, AnExponentOfZeroIsARoughSurfaceWithoutHighlight) {
  const v1::Classic rough = classic("Ks .9 .9 .9\nNs 0.0\nmap_Ns s.png\nillum 3\n");
  EXPECT_FALSE(rough.has_specular()) << "its highlight would cover the whole surface";
  EXPECT_FALSE(rough.has_shininess());
  EXPECT_FLOAT_EQ(rough.reflectivity().value().r(), .9f);
  EXPECT_TRUE(classic("Ks .9 .9 .9\nNs 1\n").has_specular());
  Warnings warnings;
  const auto materials = read("newmtl a\nPm 0\nNs 0\n", warnings);
  EXPECT_EQ(materials.at("a").physical().roughness().value(), 1);
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
  read("newmtl a b\nrefl x.png\nPs .5\nfoo\nmap_Ka -t 1 2 x.png\nnewmtl a b\n", warnings);
  EXPECT_EQ(warnings.list("t.mtl"),
            (std::vector<std::string>{
                "t.mtl:2:1: texture (refl) is not read", "t.mtl:3:1: parameter 'Ps' is not read",
                "t.mtl:4:1: unknown statement 'foo' is left out",
                "t.mtl: option -t of map_Ka is not read",
                "t.mtl: material 'a b' comes twice; the first one is taken"}));
}

TEST(Mtl, ANumberOutsideItsRangeIsTheNearest) {
  Warnings warnings;
  const auto library = read("newmtl a\nd 5\nNs -1\nnewmtl b\nPr -1\nPm 7\n", warnings);
  EXPECT_EQ(library.at("b").physical().metallic().value(), 1);
  EXPECT_EQ(library.at("b").physical().roughness().value(), 0);
  EXPECT_EQ(warnings.list("t.mtl"),
            (std::vector<std::string>{
                "t.mtl:2:3: d: '5'; expected a share of 0 to 1; 1 is taken",
                "t.mtl:3:4: Ns: '-1'; expected an exponent of 0 or more; 0 is taken",
                "t.mtl:5:4: Pr: '-1'; expected a share of 0 to 1; 0 is taken",
                "t.mtl:6:4: Pm: '7'; expected a share of 0 to 1; 1 is taken"}));
}

using Image = v1::Texture::Image;

TEST(Mtl, MakesOneTextureOfEachPictureAndItsOptions) {
  Warnings warnings;
  const MtlLibrary library = read_library(
      "newmtl a\nKd .5 .5 .5\nKs 1 1 1\nmap_Kd a b.png\nmap_Ks -s 2 3 -o .1 -clamp on sub\\c.png\n"
      "map_Ns c.png\nnewmtl b\nKd 0 0 0\nKa 1 1 1\nmap_kd \"a b.png\"\nmap_Ks -o 1 2 3 c.png\n",
      warnings);
  const v1::Classic& a = library.materials.at("a").classic();
  const v1::Classic& b = library.materials.at("b").classic();
  EXPECT_EQ(a.diffuse().texture(), "a b.png");
  EXPECT_FLOAT_EQ(a.diffuse().value().r(), .5f);
  EXPECT_EQ(b.diffuse().texture(), "a b.png");
  EXPECT_EQ(b.diffuse().value().r(), 1) << "black beneath a map would hide it";
  EXPECT_EQ(b.ambient().texture(), "a b.png") << "ambient light meets the same picture";
  EXPECT_EQ(a.specular().texture(), "sub/c.png");
  EXPECT_EQ(a.shininess().texture(), "c.png (luminance)");
  EXPECT_EQ(b.specular().texture(), "c.png");
  ASSERT_EQ(library.textures.all().size(), 4u);
  const v1::Texture& scaled = library.textures.all()[1];
  EXPECT_EQ(scaled.image().wrap_s(), Image::CLAMP);
  EXPECT_EQ(scaled.transform().steps(0).translate().x(), double{.1f});
  EXPECT_EQ(scaled.transform().steps(0).translate().y(), 0);
  EXPECT_EQ(scaled.transform().steps(1).scale().y(), 3);
  EXPECT_EQ(scaled.transform().steps(1).scale().z(), 1);
  EXPECT_EQ(scaled.image().encoding(), Image::ENCODING_SRGB);
  EXPECT_EQ(library.textures.all()[2].image().encoding(), Image::ENCODING_LINEAR);
}

TEST(Mtl, ReadsReliefAndCoverage) {
  Warnings warnings;
  const MtlLibrary library = read_library(
      "newmtl a\nmap_Bump -bm .25 -imfchan g h.png\nnorm -bm 2 n.png\nmap_d -imfchan m d.png\n"
      "newmtl b\nmap_Kd c.png\nmap_d c.png\nnewmtl c\nmap_Kd -colorspace linear c.png\n",
      warnings);
  const v1::Material& a = library.materials.at("a");
  EXPECT_EQ(a.bump().value(), .25);
  EXPECT_EQ(a.bump().channel(), v1::FloatInput::GREEN);
  EXPECT_EQ(a.normal_map(), "n.png");
  EXPECT_EQ(a.normal_scale(), 2);
  EXPECT_EQ(a.opacity().texture(), "d.png");
  EXPECT_EQ(a.opacity().channel(), v1::FloatInput::ALPHA);
  const v1::Material& b = library.materials.at("b");
  EXPECT_FALSE(b.has_opacity()) << "the picture's own alpha";
  EXPECT_EQ(b.alpha(), v1::Material::ALPHA_AUTO);
  EXPECT_EQ(library.materials.at("c").alpha(), v1::Material::ALPHA_OPAQUE);
  EXPECT_EQ(library.textures.all().back().image().encoding(), Image::ENCODING_LINEAR);
}

TEST(Mtl, TakesTheLuminanceOfAPictureForANumber) {
  Warnings warnings;
  const MtlLibrary library = read_library(
      "newmtl a\nmap_d -imfchan l c.png\nbump -imfchan r c.png\nmap_Ns c.png\nmap_Kd c.png\n"
      "newmtl b\nmap_d c.png\nbump -imfchan z c.png\n",
      warnings);
  const v1::Material& a = library.materials.at("a");
  EXPECT_EQ(a.opacity().texture(), "c.png (luminance)") << "though it is the colour's picture";
  EXPECT_EQ(a.classic().shininess().texture(), "c.png (luminance)");
  EXPECT_EQ(a.bump().texture(), "c.png#2");
  EXPECT_EQ(a.bump().channel(), v1::FloatInput::RED);
  const v1::Material& b = library.materials.at("b");
  EXPECT_EQ(b.opacity().texture(), "c.png (alpha, luminance)");
  EXPECT_EQ(b.bump().texture(), "c.png (luminance)");
  EXPECT_EQ(library.picture_channels,
            (std::map<std::string, PictureChannel>{
                {"c.png (luminance)", PictureChannel::luminance},
                {"c.png (alpha, luminance)", PictureChannel::alpha_or_luminance}}));
  EXPECT_EQ(warnings.list("t.mtl"),
            std::vector<std::string>{"t.mtl:8:6: bump -imfchan z asks for depths, which no "
                                     "picture holds; luminance is taken"});
}

TEST(Mtl, MakesAPhysicalMaterialOfPhysicalNumbers) {
  Warnings warnings;
  const MtlLibrary library = read_library(
      "newmtl a\nKd .1 .2 .3\nPr .4\nPm 1\nPc .5\nPcr .1\nKe 2 2 2\nd .5\n"
      "newmtl b\nmap_Pr r.png\nNs 98\nnewmtl c\nPm .5\nNs 30\nnewmtl d\nmap_ORM o.png\n"
      "newmtl e\nPr 0\nillum 7\nTf 1 1 1\nNi 1.3\n",
      warnings);
  const v1::Physical& a = library.materials.at("a").physical();
  EXPECT_FLOAT_EQ(a.base_color().value().b(), .3f);
  EXPECT_FLOAT_EQ(a.roughness().value(), .4f);
  EXPECT_FLOAT_EQ(a.metallic().value(), 1);
  EXPECT_FLOAT_EQ(a.clearcoat().value(), .5f);
  EXPECT_FLOAT_EQ(a.clearcoat_roughness().value(), .1f);
  EXPECT_FLOAT_EQ(a.emission().value().r(), 2);
  EXPECT_FLOAT_EQ(a.transparency().value(), .5f);
  const v1::Physical& b = library.materials.at("b").physical();
  EXPECT_EQ(b.roughness().texture(), "r.png (luminance)");
  EXPECT_EQ(b.roughness().value(), 1);
  EXPECT_EQ(b.metallic().value(), 0);
  EXPECT_NEAR(library.materials.at("c").physical().roughness().value(), .5, 1e-12);
  const v1::Physical& d = library.materials.at("d").physical();
  EXPECT_EQ(d.roughness().channel(), v1::FloatInput::GREEN);
  EXPECT_EQ(d.metallic().channel(), v1::FloatInput::BLUE);
  EXPECT_EQ(d.occlusion().channel(), v1::FloatInput::RED);
  EXPECT_EQ(library.materials.at("e").physical().transmission().value(), 1);
}

TEST(Mtl, ReadsNoPictureThatTheFinderRefuses) {
  Warnings warnings;
  MtlLibrary library;
  LineReader reader("newmtl m\nmap_Kd ../secret.png\nmap_Ks ok.png\nKs 1\n", "t.mtl");
  const MtlPictureFinder finder = [](const std::string& written, const std::string& material) {
    EXPECT_EQ(material, "m");
    return written == "ok.png" ? std::optional<std::string>("below/ok.png") : std::nullopt;
  };
  read_mtl(reader, finder, library, warnings);
  EXPECT_EQ(library.materials.at("m").classic().diffuse().texture(), "");
  ASSERT_EQ(library.textures.all().size(), 1u);
  EXPECT_EQ(library.textures.all()[0].image().file(), "below/ok.png");
}

TEST(Mtl, SaysWhereAndWhatIsWrong) {
  EXPECT_EQ(mtl_error("Kd 1 1 1\n"), "t.mtl:1:1: 'Kd'; expected newmtl before it");
  EXPECT_EQ(mtl_error("newmtl\n"), "t.mtl:1:7: newmtl without a name; expected a material's name");
  EXPECT_EQ(mtl_error("newmtl a\nKd 1 x 1\n"), "t.mtl:2:6: 'x'; expected a colour component");
  EXPECT_EQ(mtl_error("newmtl a\nillum 11\n"),
            "t.mtl:2:7: '11'; expected an illumination model of 0 to 10");
  EXPECT_EQ(mtl_error("newmtl a\nillum 3e30\n"),
            "t.mtl:2:7: '3e30'; expected an illumination model of 0 to 10");
  EXPECT_EQ(mtl_error("map_Kd x.png\n"), "t.mtl:1:1: 'map_Kd'; expected newmtl before it");
  EXPECT_EQ(mtl_error("newmtl a\nmap_Kd \n"),
            "t.mtl:2:8: map_Kd without a file; expected a picture");
  EXPECT_EQ(mtl_error("newmtl a\nmap_Kd -s x a.png\n"),
            "t.mtl:2:11: 'x'; expected a finite number");
  EXPECT_EQ(mtl_error("newmtl a\nbump -bm 1e99 a.png\n"),
            "t.mtl:2:10: '1e99'; expected a finite number");
  EXPECT_EQ(mtl_error("newmtl a\nmap_d -imfchan q a.png\n"),
            "t.mtl:2:16: 'q'; expected a channel: r, g, b, m, l or z");
  EXPECT_EQ(mtl_error("newmtl a\nNs nan\n"),
            "t.mtl:2:4: 'nan'; expected an exponent of 0 or more that is finite");
}

TEST(Mtl, WhatIsNotReadOfAStatementIsTold) {
  const auto told = [](const std::string& statement) {
    Warnings warnings;
    read("newmtl a\n" + statement, warnings);
    return warnings.list("t.mtl");
  };
  using Told = std::vector<std::string>;
  EXPECT_FLOAT_EQ(classic("d -halo .25\n").transparency().value(), .75f);
  EXPECT_EQ(told("d -halo .25\n"), Told{"t.mtl:2:3: d -halo is read as plain d"});
  EXPECT_FLOAT_EQ(classic("d -1\n").transparency().value(), 1);
  EXPECT_EQ(told("d -1\n"), Told{"t.mtl:2:3: d: '-1'; expected a share of 0 to 1; 0 is taken"});
  EXPECT_EQ(told("illum 10\n"),
            Told{"t.mtl:2:7: illum 10: shadows that fall on something invisible are not read"});
}

TEST(Mtl, AStatementThatCannotBeReadCostsNoOther) {
  Warnings warnings;
  const auto materials = read("newmtl a\nKd 0,5 1 1\nKs .1 .2 .3\nnewmtl b\nKd 1 0 0\n", warnings);
  EXPECT_FLOAT_EQ(materials.at("a").classic().specular().value().g(), .2f);
  EXPECT_FLOAT_EQ(materials.at("a").classic().diffuse().value().g(), .8f);
  EXPECT_EQ(materials.at("b").classic().diffuse().value().r(), 1);
  EXPECT_EQ(warnings.list("t.mtl").size(), 1u);
}

TEST(Mtl, NumbersThatPrintingRoundedMeanTheSame) {
  const auto material = [](const std::string& body) {
    Warnings warnings;
    return read("newmtl m\n" + body, warnings).at("m");
  };
  // Without transparency the picture's alpha means nothing.
  EXPECT_EQ(material("d 0.9999999\nmap_Kd a.png\n").alpha(), v1::Material::ALPHA_OPAQUE);
  EXPECT_FALSE(material("Tr 0.0000001\n").classic().has_transparency());
  EXPECT_EQ(material("Kd 0.0000001 0 0\nmap_Kd a.png\n").classic().diffuse().value().r(), 1);
  EXPECT_EQ(material("Pr .5\nNi 1.0000001\n").physical().refractive_index(),
            material("Pr .5\nNi 1\n").physical().refractive_index());
  EXPECT_EQ(material("illum 5.0000001\nKs 1 1 1\n").classic().reflectivity().value().r(), 1);
}

}  // namespace
}  // namespace tessera
