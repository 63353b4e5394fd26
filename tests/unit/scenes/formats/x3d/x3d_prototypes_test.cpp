#include <gtest/gtest.h>

#include "tests/unit/scenes/formats/x3d/x3d_testing.h"

namespace tessera {
namespace {

constexpr const char* kBallProto =
    "PROTO Ball [ inputOutput SFColor color 1 0 0 initializeOnly SFFloat size 1 inputOutput MFNode "
    "extra [ ] inputOnly SFTime now ] { Transform { children [ Shape { appearance Appearance { "
    "material Material { diffuseColor IS color } } geometry Sphere { radius IS size } } Group { "
    "children IS extra } ] } TimeSensor { startTime IS now } } ";

TEST(X3dPrototypes, TakeTheInstancesValuesElseTheInterfaces) {
  const auto loaded = parse_classic(std::string(kBallProto) +
                                    "Ball { } DEF B Ball { color 0 0 1 size 3 extra [ Shape { "
                                    "geometry Box { } } Shape { geometry Cone { } } ] }");
  EXPECT_EQ(loaded.warnings, std::vector<std::string>{});
  ASSERT_EQ(loaded.scene.nodes_size(), 2);
  const v1::Node& plain = loaded.scene.nodes(0);
  const v1::Node& given = loaded.scene.nodes(1);
  EXPECT_EQ(plain.children(0).shape().sphere().radius(), 1);
  EXPECT_EQ(plain.children(1).children_size(), 0);
  EXPECT_EQ(given.name(), "B");
  EXPECT_EQ(given.children(0).shape().sphere().radius(), 3);
  EXPECT_EQ(given.children(1).children_size(), 2);
  EXPECT_EQ(loaded.scene.materials(0).classic().diffuse().value().r(), 1);
  EXPECT_EQ(loaded.scene.materials(1).classic().diffuse().value().b(), 1);
}

TEST(X3dPrototypes, PassValuesOnThroughOthers) {
  const auto loaded = parse_classic(std::string(kBallProto) +
                                    "PROTO Two [ inputOutput SFColor tint 0 1 0 ] { Group { "
                                    "children [ Ball { color IS tint } Ball { size 2 } ] } } "
                                    "Two { } Two { tint 0 0 .5 }");
  EXPECT_EQ(loaded.scene.materials(0).classic().diffuse().value().g(), 1);
  EXPECT_EQ(loaded.scene.materials(1).classic().diffuse().value().r(), 1);
  EXPECT_EQ(loaded.scene.materials(2).classic().diffuse().value().b(), .5);
}

TEST(X3dPrototypes, AreTheSameInXml) {
  const auto loaded = parse_x3d(
      "<X3D version='3.3'><Scene><ProtoDeclare name='Ball'><ProtoInterface><field name='size' "
      "accessType='inputOutput' type='SFFloat' value='1'/><field name='look' type='SFNode' "
      "accessType='inputOutput'><Appearance/></field></ProtoInterface><ProtoBody><Shape><IS>"
      "<connect nodeField='appearance' protoField='look'/></IS><Sphere><IS><connect "
      "nodeField='radius' protoField='size'/></IS></Sphere></Shape></ProtoBody></ProtoDeclare>"
      "<ProtoInstance name='Ball' DEF='A'><fieldValue name='size' value='4'/></ProtoInstance>"
      "<Group><ProtoInstance name='Ball'><fieldValue name='look'><Appearance><Material/>"
      "</Appearance></fieldValue></ProtoInstance><ProtoInstance USE='A'/></Group></Scene></X3D>",
      "t.x3d", {});
  ASSERT_EQ(loaded.scene.objects_size(), 1);
  EXPECT_EQ(loaded.scene.objects(0).nodes(0).shape().sphere().radius(), 4);
  EXPECT_EQ(loaded.scene.nodes(1).children(0).shape().sphere().radius(), 1);
  EXPECT_TRUE(loaded.scene.materials(1).has_classic());
  EXPECT_EQ(loaded.scene.nodes(1).children(1).instance_of(), "A");
}

TEST(X3dPrototypes, EndWhereTheyWouldGrowWithoutEnd) {
  std::string text = "#X3D V3.3 utf8\nPROTO P0 [ ] { Group { } } ";
  for (int i = 1; i < 30; ++i) {
    const std::string inner = "P" + std::to_string(i - 1) + " { } ";
    text += "PROTO P" + std::to_string(i) + " [ ] { Group { children [ " + inner + inner + inner +
            inner + "] } } ";
  }
  EXPECT_NE(x3d_error(text).find("prototypes that become too many nodes; expected at most 200000"),
            std::string::npos);
}

TEST(X3dPrototypes, EndWhereTheyAreNestedTooDeep) {
  const std::string limit = "nodes nested too deep; expected at most 80 levels";
  std::string instances, declarations, classic = "#X3D V3.3 utf8\nPROTO P [ ] { Group { } } ";
  for (int i = 0; i < 50000; ++i) {
    instances += "<ProtoInstance name='P'><fieldValue name='x'>";
    declarations += "<ProtoDeclare name='P'><ProtoInterface><field name='x'>";
    classic += "PROTO Q [ ] { ";
  }
  const std::string xml =
      "<X3D><Scene><ProtoDeclare name='P'><ProtoBody><Group/></ProtoBody>"
      "</ProtoDeclare>";
  const auto close = [](const std::string& open) {
    std::string out;
    for (size_t at = open.size(); (at = open.rfind('<', at - 1)) != std::string::npos;) {
      out += "</" + open.substr(at + 1, open.find_first_of(" >", at) - at - 1) + ">";
      if (at == 0) break;
    }
    return out;
  };
  for (const std::string& open : {instances, declarations})
    EXPECT_NE(x3d_error(xml + open + close(open) + "</Scene></X3D>").find(limit),
              std::string::npos);
  EXPECT_NE(x3d_error(classic).find(limit), std::string::npos);
}

}  // namespace
}  // namespace tessera
