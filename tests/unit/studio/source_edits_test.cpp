#include "studio/source_edits.h"

#include <gtest/gtest.h>

#include <nlohmann/json.hpp>

#include "studio/page_message.h"
#include "studio/source_reader.h"

namespace tessera {
namespace {

using Json = nlohmann::json;
using What = page::Source::What;

constexpr const char* kScene =
    "# é 🙂\nmaterials { name: \"red\" classic { } }\n"
    "nodes { name: \"ball\" shape { materials: \"red\" sphere { radius: 1.25 } } }\n";

/// Documents of which outlines are made when the test says so.
class SourceEditsTest : public testing::Test {
 protected:
  void open(ClientId client, const std::string& file = "a.tessera",
            const std::string& text = kScene) {
    documents_.open(client, file);
    documents_.take({.client = client, .file = file, .document = Document(text), .version = {}});
    act();
  }
  void edit(ClientId client, uint64_t base, std::vector<TextChange> changes) {
    documents_.edit(client, {"a.tessera", base, std::move(changes)}, Time{});
    act();
  }
  void act() {
    edits_.tick();
    for (StudioOrder& order : std::exchange(orders_, {})) {
      if (auto* const text = std::get_if<SendText>(&order)) {
        const Json message = Json::parse(text->text);
        told_[text->client][message.begin().key()].push_back(message.begin().value());
      } else if (auto* const outline = std::get_if<OutlineOrder>(&order)) {
        outlines_.push_back(std::move(*outline));
      } else if (auto* const source = std::get_if<SourceOrder>(&order)) {
        orders_.push_back(reader_.answer(*source));
        requests_.take({{source->client, page::name_of(source->request.what)}});
      }
    }
    if (!orders_.empty()) act();
  }
  /// Makes the outline that was ordered first.
  void make_outline() {
    ASSERT_FALSE(outlines_.empty());
    edits_.take(std::make_shared<const FileOutline>(reader_.outline(outlines_.front())));
    outlines_.erase(outlines_.begin());
    act();
  }
  /// What the page was told, which is forgotten.
  std::vector<Json> heard(ClientId client, const std::string& kind) {
    return std::exchange(told_[client][kind], {});
  }
  Json ask(page::Source request, const std::string& kind) {
    edits_.ask(1, request);
    act();
    const std::vector<Json> answers = heard(1, kind);
    return answers.size() == 1 ? answers[0] : Json();
  }
  /// The text after the change that answers the request.
  std::string changed(page::Source request) {
    const Json change = ask(std::move(request), "change");
    if (change.is_null()) return "";
    Document after(kScene);
    std::vector<TextChange> changes;
    for (const Json& each : change["changes"])
      changes.push_back({each[0].get<size_t>(), each[1].get<size_t>(), each[2]});
    EXPECT_EQ(after.apply(changes), std::nullopt);
    return after.text();
  }

  StudioOrders orders_;
  OpenDocuments documents_{orders_, [](ClientId) { return true; }};
  LatestRequests requests_{orders_};
  SourceEdits edits_{orders_, requests_, documents_, false};
  SourceReader reader_;
  std::vector<OutlineOrder> outlines_;
  std::map<ClientId, std::map<std::string, std::vector<Json>>> told_;
};

TEST_F(SourceEditsTest, EveryReaderIsToldOnceOfEachOutline) {
  open(1);
  make_outline();
  ASSERT_EQ(heard(1, "outline").size(), 1u);
  act();
  EXPECT_EQ(heard(1, "outline").size(), 0u);
  documents_.open(2, "a.tessera");
  act();
  EXPECT_EQ(heard(2, "outline").size(), 1u) << "one that was made before";
  EXPECT_EQ(heard(1, "outline").size(), 0u);
  EXPECT_TRUE(outlines_.empty()) << "nothing is made twice";
}

TEST_F(SourceEditsTest, WhileOneIsMadeOnlyTheNewestTextWaits) {
  open(1);
  edit(1, 1, {{0, 0, "#\n"}});
  edit(1, 2, {{0, 0, "#\n"}});
  edit(1, 3, {{0, 0, "#\n"}});
  ASSERT_EQ(outlines_.size(), 1u);
  make_outline();
  EXPECT_EQ(heard(1, "outline").at(0)["version"], 1);
  ASSERT_EQ(outlines_.size(), 1u);
  make_outline();
  EXPECT_EQ(heard(1, "outline").at(0)["version"], 4);
  EXPECT_TRUE(outlines_.empty());
}

TEST_F(SourceEditsTest, AnOutlineOfAClosedFileIsNotTold) {
  open(1);
  documents_.close(1, {"a.tessera"});
  act();
  open(1, "a.tessera", "nodes { name: \"other\" }\n");
  ASSERT_EQ(outlines_.size(), 2u);
  make_outline();
  EXPECT_EQ(heard(1, "outline").size(), 0u) << "of the text that was closed";
  make_outline();
  const std::vector<Json> outlines = heard(1, "outline");
  ASSERT_EQ(outlines.size(), 1u);
  EXPECT_EQ(outlines[0]["entities"][1]["name"], "other");
}

TEST_F(SourceEditsTest, PlacesCountInUtf16) {
  open(1);
  make_outline();
  const Json entities = heard(1, "outline").at(0)["entities"];
  const Json& material = entities.at(1);
  EXPECT_EQ(material["id"], "materials[0]");
  EXPECT_EQ(material["parent"], "scene");
  EXPECT_EQ(material["from"], 7) << "# é and two units of one character";
  EXPECT_EQ(material["line"], 2);
  EXPECT_EQ(material["column"], 1);
}

TEST_F(SourceEditsTest, AFieldIsSetInItsLiteral) {
  open(1);
  const page::Source set{.what = What::set,
                         .file = "a.tessera",
                         .base = 1,
                         .entity = "nodes[0].shape",
                         .field = "sphere.radius",
                         .text = "2.5"};
  const Json change = ask(set, "change");
  EXPECT_EQ(change["base"], 1);
  EXPECT_EQ(change["why"], "property sphere.radius");
  std::string expected = kScene;
  expected.replace(expected.find("1.25"), 4, "2.5");
  EXPECT_EQ(changed(set), expected);
}

TEST_F(SourceEditsTest, WrongValuesAreRefusedWithWhatIsExpected) {
  open(1);
  for (const char* const wrong : {"nan", "inf", "", "1,5", "1;2", "x"}) {
    const Json refused = ask({.what = What::set,
                              .file = "a.tessera",
                              .base = 1,
                              .entity = "nodes[0].shape",
                              .field = "sphere.radius",
                              .text = wrong},
                             "refused");
    ASSERT_TRUE(refused.is_object()) << wrong;
    EXPECT_FALSE(refused["expected"].get<std::string>().empty()) << wrong;
    EXPECT_EQ(refused["field"], "sphere.radius");
  }
}

TEST_F(SourceEditsTest, ARequestOfAnotherVersionIsRefused) {
  open(1);
  edit(1, 1, {{0, 0, "#\n"}});
  const Json refused =
      ask({.what = What::remove, .file = "a.tessera", .base = 1, .entity = "nodes[0]"}, "refused");
  EXPECT_EQ(refused["why"], "version 1 of the text; expected version 2");
  EXPECT_EQ(
      ask({.what = What::fields, .file = "a.tessera", .base = 1, .entity = "nodes[0]"}, "fields"),
      Json());
  // A question is waited for.
  EXPECT_EQ(
      ask({.what = What::hover, .file = "a.tessera", .base = 1, .number = 7}, "refused")["number"],
      7);
  EXPECT_EQ(ask({.what = What::remove, .file = "b.tessera", .base = 1}, "refused")["why"],
            "the file is not open");
}

TEST_F(SourceEditsTest, FieldsSayWhatTheTextDoesNot) {
  open(1);
  const Json answer = ask(
      {.what = What::fields, .file = "a.tessera", .base = 1, .entity = "nodes[0].shape"}, "fields");
  bool has_radius = false, has_default = false;
  for (const Json& field : answer["fields"]) {
    if (field["name"] == "sphere.radius") {
      has_radius = true;
      EXPECT_EQ(field["text"], "1.25");
      EXPECT_EQ(field["present"], true);
    }
    if (field["name"] == "flip_normals") has_default = field["present"] == false;
  }
  EXPECT_TRUE(has_radius);
  EXPECT_TRUE(has_default);
}

TEST_F(SourceEditsTest, SettingsOfTheViewAreWritten) {
  open(1);
  page::Source write{.what = What::write_settings, .file = "a.tessera", .base = 1};
  write.options = {{"spp", "64"},      {"integrator", "path"}, {"pattern", "owen-sobol"},
                   {"max-depth", "3"}, {"min-spp", "7"},       {"shadows", "by-light"}};
  const std::string text = changed(write);
  EXPECT_NE(text.find("samples_per_pixel: 64"), std::string::npos) << text;
  EXPECT_NE(text.find("kind: \"path\""), std::string::npos) << text;
  EXPECT_NE(text.find("pattern: OWEN_SOBOL"), std::string::npos) << text;
  EXPECT_NE(text.find("max_depth: 3"), std::string::npos) << text;
  EXPECT_NE(text.find("min_samples: 7"), std::string::npos) << text;
  EXPECT_NE(text.find("shadows: SHADOWS_BY_LIGHT"), std::string::npos) << text;
  write.options = {{"pinhole", "true"}};
  EXPECT_EQ(ask(write, "refused")["found"], "pinhole");
}

TEST_F(SourceEditsTest, APlacementHasTheMaterialsOfLanguagesThatChooseOne) {
  open(1);
  Json told = ask({.what = What::placement, .file = "a.tessera", .base = 1}, "placement");
  EXPECT_EQ(told["materials"], Json::array({"red"}));
  EXPECT_EQ(told["placement"]["scale"], Json::array({"1", "1", "1"}));
  EXPECT_FALSE(told.contains("locked"));
  open(1, "a.x3d", "<X3D><Scene><Material DEF='red'/></Scene></X3D>");
  told = ask({.what = What::placement, .file = "a.x3d", .base = 1}, "placement");
  EXPECT_FALSE(told.contains("materials"));
  EXPECT_FALSE(told.contains("locked"));
}

TEST_F(SourceEditsTest, ModelsAreAddedDoubledAndRemoved) {
  open(1);
  const page::Source add{.what = What::add,
                         .file = "a.tessera",
                         .base = 1,
                         .text = "models/a \"b\".obj",
                         .kind = "include"};
  const std::string with = changed(add);
  const edit::Outline outline = edit::outline(edit::Language::tessera, with);
  EXPECT_TRUE(with.starts_with(kScene));
  ASSERT_EQ(outline.entities().back().kind, edit::EntityKind::include);
  EXPECT_EQ(outline.entities().back().fields.at(0).text, "models/a \"b\".obj");
  const std::string twice =
      changed({.what = What::duplicate, .file = "a.tessera", .base = 1, .entity = "materials[0]"});
  EXPECT_GT(twice.size(), std::string(kScene).size());
  const std::string without =
      changed({.what = What::remove, .file = "a.tessera", .base = 1, .entity = "nodes[0]"});
  EXPECT_EQ(without.find("ball"), std::string::npos);
}

TEST_F(SourceEditsTest, TellTheTextOfACamera) {
  const auto text_of = [this](const std::string& file, const std::string& text, const char* name) {
    open(1, file, text);
    page::Source request{.what = What::camera_text, .file = file, .base = 1, .text = name};
    request.camera = FreeCamera{.eye = {0, 1, 5}, .target = {0, 1, 0}, .fov = 40, .axis = ""};
    return ask(request, "camera_text")["text"].get<std::string>();
  };
  EXPECT_EQ(
      text_of("b.tessera", "# 1\ncameras { name: 'a' } cameras { name: 'b' }\n", "b"),
      "cameras { name: 'b' world_from_camera { steps { look_at { eye { y: 1 z: 5 } target { y: "
      "1 } } } } perspective { field_of_view: 40 } }");
  EXPECT_TRUE(text_of("c.tessera", "nodes { }\n", "").starts_with("cameras { world_from_camera"));
  EXPECT_EQ(text_of("d.gltf", R"({"asset":{"version":"2.0"}})", ""),
            R"({"camera":0,"translation":[0,1,5]})");
  EXPECT_EQ(
      text_of("b.crt",
              "cam = Camera { position -> vec3(0, 1, -5) pointing -> vec3(0, 0, 0) fov -> 50 }",
              ""),
      "cam = Camera { position -> vec3(0, 1, 5) pointing -> vec3(0, 1, 0) fov -> 40 }");
  EXPECT_EQ(text_of("b.x3d", "<X3D><Scene>\n<Viewpoint position='0 1 5'/></Scene></X3D>", ""),
            "<Viewpoint position='0 1 5' fieldOfView='0.6981317'/>");
}

TEST_F(SourceEditsTest, MessagesOfPagesAreRead) {
  const auto message = page::parse_message(
      R"({"set": {"file": "a.crt", "base": 7, "entity": "x", "field": "f", "text": "1"}})");
  ASSERT_TRUE(message);
  const auto& set = std::get<page::Source>(*message);
  EXPECT_EQ(set.what, What::set);
  EXPECT_EQ(set.base, 7u);
  EXPECT_EQ(set.entity, "x");
  for (const auto what :
       {What::set, What::reset, What::add, What::remove, What::duplicate, What::write_camera,
        What::write_settings, What::fields, What::complete, What::hover, What::camera_text}) {
    const Json json{{page::name_of(what), {{"file", "a"}}}};
    EXPECT_EQ(std::get<page::Source>(*page::parse_message(json.dump())).what, what);
  }
}

}  // namespace
}  // namespace tessera
