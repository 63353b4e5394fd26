#include "proto/wire/scene_codec.h"

#include <fmt/format.h>
#include <google/protobuf/util/message_differencer.h>
#include <gtest/gtest.h>
#include <rapidcheck/gtest.h>

#include <cmath>
#include <filesystem>
#include <fstream>
#include <sstream>

#include "tests/unit/scenes/scene_testing.h"

namespace tessera {
namespace {

using google::protobuf::util::MessageDifferencer;

constexpr SceneEncoding kEncodings[] = {SceneEncoding::text, SceneEncoding::binary,
                                        SceneEncoding::json};

std::string error(const std::string& text, SceneEncoding encoding) {
  return error_of([&] { decode_scene(text, encoding, "s"); });
}
std::string text_error(const std::string& text) { return error(text, SceneEncoding::text); }
std::string json_error(const std::string& text) { return error(text, SceneEncoding::json); }

/// A scene with a mesh whose blob holds `bytes`.
SceneWithBlobs with_blob(const std::string& bytes) {
  SceneWithBlobs made;
  const auto view = std::as_bytes(std::span(bytes));
  const Digest digest = made.blobs.put({view.begin(), view.end()});
  v1::BlobRef& ref = *made.scene.add_nodes()->mutable_shape()->mutable_mesh()->mutable_positions();
  ref.set_digest(digest.hex());
  ref.set_size(bytes.size());
  return made;
}

TEST(SceneCodec, SkipsAByteOrderMark) {
  const std::string mark = "\xEF\xBB\xBF";
  for (const SceneEncoding encoding : {SceneEncoding::text, SceneEncoding::json}) {
    const std::string text =
        encoding == SceneEncoding::text ? "settings { width: 7 }" : R"({"settings": {"width": 7}})";
    EXPECT_EQ(decode_scene(mark + text, encoding, "s").scene.settings().width(), 7u);
  }
}

RC_GTEST_PROP(SceneCodec, GivesBackEveryBitInEveryEncoding, ()) {
  v1::Scene scene;
  const auto finite =
      rc::gen::suchThat(rc::gen::map(rc::gen::arbitrary<uint64_t>(),
                                     [](uint64_t b) { return std::bit_cast<double>(b); }),
                        [](double d) { return std::isfinite(d); });
  v1::Vec3& eye =
      *scene.add_cameras()->mutable_world_from_camera()->add_steps()->mutable_translate();
  eye.set_x(*finite);
  eye.set_y(*finite);
  eye.set_z(*finite);
  scene.mutable_settings()->set_time(*finite);
  scene.mutable_settings()->set_width(*rc::gen::arbitrary<uint32_t>());
  const auto single =
      *rc::gen::suchThat(rc::gen::arbitrary<float>(), [](float f) { return std::isfinite(f); });
  scene.add_nodes()->mutable_shape()->mutable_mesh()->add_inline_positions(single);
  scene.mutable_metadata()->set_title(
      *rc::gen::container<std::string>(rc::gen::inRange<char>(1, 127)));
  const SceneWithBlobs blob = with_blob(*rc::gen::arbitrary<std::string>());
  scene.MergeFrom(blob.scene);
  for (const SceneEncoding encoding : kEncodings) {
    const std::string bytes = encode_scene(scene, blob.blobs, encoding);
    const SceneWithBlobs back = decode_scene(bytes, encoding, "s");
    RC_ASSERT(serialize_scene(back.scene) == serialize_scene(scene));
    RC_ASSERT(back.blobs.size() == 1u);
    RC_ASSERT(*back.blobs.all().begin()->second == *blob.blobs.all().begin()->second);
  }
}

TEST(SceneCodec, KnowsItsEndings) {
  EXPECT_EQ(scene_encoding_of("a/b.tessera"), SceneEncoding::text);
  EXPECT_EQ(scene_encoding_of("b.TesseraB"), SceneEncoding::binary);
  EXPECT_EQ(scene_encoding_of("b.json"), SceneEncoding::json);
  EXPECT_EQ(scene_encoding_of("b.obj"), std::nullopt);
}

TEST(SceneCodec, SaysWhereTextIsWrong) {
  EXPECT_EQ(text_error("cameras {\n  lens { radius: 1 } }\n"),
            "s:2:10: 'radius' is no field of Lens; expected one of radius_x, radius_y, "
            "focal_distance, shape, blades, focal_surface, samples, radius_unit; did you mean "
            "'radius_x'?");
  EXPECT_EQ(text_error("cameras { lens { shape: CIRCEL } }"),
            "s:1:25: 'CIRCEL' is no value of shape; expected one of CIRCLE, POLYGON, "
            "SQUARE_UNIFORM, GAUSSIAN, LINE; did you mean 'CIRCLE'?");
  EXPECT_EQ(text_error("nodes: 3"), "s:1:8: '3'; expected '{'");
  EXPECT_EQ(text_error("settings {\n\ttime: abc }"), "s:2:8: 'abc'; expected a number");
  EXPECT_EQ(text_error("settings { width: -1 }"),
            "s:1:19: '-'; expected an integer in the field's range");
  EXPECT_EQ(text_error("nodes { hidden: maybe }"), "s:1:17: 'maybe'; expected true or false");
  EXPECT_EQ(text_error("nodes {"), "s:1:8: the text ends here; expected a field's name");
  EXPECT_EQ(text_error("nodes { shape { sphere {} box{} } }"),
            "s:1:27: 'box' beside 'sphere'; expected only one kind");
  EXPECT_EQ(text_error("settings { time:1 time: 2 }"),
            "s:1:19: 'time' a second time; expected it once");
  EXPECT_EQ(text_error("settings {\n time: nan }"),
            "s:2:2: settings.time is not finite; expected a finite number");
  EXPECT_EQ(text_error("nodes {\n name: \"\\377\" }"),
            "s:2:2: nodes[0].name is not UTF-8; expected text");
  EXPECT_EQ(text_error("metadata {\n properties { key: \"a\" value: \"\\377\" } }"),
            "s:2:24: metadata.properties[0].value is not UTF-8; expected text");
  EXPECT_EQ(text_error("nodes {} [a.b]: 3"), "s:1:10: '['; expected a field's name");
  EXPECT_EQ(text_error("# x\n\xff"), "s:2:1: a byte that is not UTF-8; expected text");
}

/// The lines of a message up to the first semicolon of each.
std::vector<std::string> beginnings(const std::string& message) {
  std::vector<std::string> lines;
  std::istringstream in(message);
  for (std::string line; std::getline(in, line);) lines.push_back(line.substr(0, line.find(';')));
  return lines;
}

TEST(SceneCodec, TellsAllUnknownFieldsOfATextAndWhatEndsIt) {
  EXPECT_EQ(beginnings(text_error("cameras { lens { radius: 1 } }\nnodes { shap { box {} } }\n"
                                  "settings { heigth: [1, 2] time: abc width: x }")),
            (std::vector<std::string>{
                "s:1:18: 'radius' is no field of Lens", "s:2:9: 'shap' is no field of Node",
                "s:3:12: 'heigth' is no field of Settings", "s:3:33: 'abc'"}));
  // A name that is half typed is one fault.
  EXPECT_EQ(beginnings(text_error("came\ncameras { }\nnodes { }")).size(), 1u);
  std::string many;
  for (int i = 0; i < 100; ++i) many += "wrong" + std::to_string(i) + ": 1\n";
  const std::vector<std::string> told = beginnings(text_error(many));
  EXPECT_EQ(told.size(), 21u);
  EXPECT_EQ(told.back(), "20 errors");
}

TEST(SceneCodec, TellsAllWrongNamesAndValuesOfJsonAndWhatEndsIt) {
  EXPECT_EQ(beginnings(json_error(
                "{\"nodes\": [{\"shap\": {\"box\": [1]}, \"hidden\": 3}],\n"
                "\"settings\": {\"sampling\": {\"filter\": \"BOXX\"}, \"time\": 1e999},\n]")),
            (std::vector<std::string>{"s:1:13: 'shap' is no field of Node", "s:1:45: 3",
                                      "s:2:37: 'BOXX' is no value of filter", "s:2:54: 1e999",
                                      "s:3:1: ']'"}));
}

TEST(SceneCodec, SaysWhereJsonIsWrong) {
  EXPECT_EQ(json_error("{\n \"cameras\":[{\"lens\":{\"radius\":1}}]}").substr(0, 66),
            "s:2:22: 'radius' is no field of Lens; expected one of radius_x, ra");
  EXPECT_EQ(json_error("{"), "s:1:2: the text ends here; expected a text in double quotes");
  EXPECT_EQ(json_error("{\"nodes\":[{\"name\":\"a\" 1}]}"), "s:1:23: '1'; expected ',' or '}'");
  EXPECT_EQ(json_error("{\"settings\":\n{\"width\":-1}}"),
            "s:2:10: -1; expected an integer in the field's range");
  EXPECT_EQ(json_error("{\"nodes\":[{\"hidden\":\"yes\"}]}"),
            "s:1:21: \"yes\"; expected true or false");
  EXPECT_EQ(json_error("{\"settings\":{\"time\":1e999}}"),
            "s:1:21: 1e999; expected a number that double precision can hold");
  EXPECT_EQ(json_error("{\"settings\":{\"time\":\"NaN\"}}").substr(0, 35),
            "s:1:21: settings.time is not finite");
  EXPECT_EQ(json_error("{\"nodes\":[{\"shape\":{\"rectangle\":\n{\"edgeU\":{\"x\":\"NaN\"}}}}]}"),
            "s:2:15: nodes[0].shape.rectangle.edge_u.x is not finite; expected a finite number");
  EXPECT_EQ(json_error("{\"nodes\":[{},\nnull,{}]}"), "s:2:1: null; expected a value");
  EXPECT_EQ(json_error("{\"nodes\":[],\n\"nodes\":[{}]}"),
            "s:2:1: 'nodes' is given twice; expected each field once");
  EXPECT_EQ(json_error("{} {}"), "s:1:4: text after the scene's end; expected nothing more");
}

TEST(SceneCodec, SaysWhereValuesOfJsonAreOfAnotherType) {
  const auto of_sphere = [](const std::string& fields) {
    return json_error("{\"nodes\":[{\"shape\":{\"sphere\":\n{" + fields + "}}}]}");
  };
  for (const char* wrong : {"NaN", ".5", "5.", "0x10", "01", "+1", "\"abc\"", "true"}) {
    EXPECT_EQ(of_sphere(fmt::format("\"radius\":{}", wrong)),
              fmt::format("s:2:11: {}; expected a number", wrong));
  }
  EXPECT_EQ(of_sphere("\"radius\":{}"), "s:2:11: an object; expected a number");
  EXPECT_EQ(of_sphere("\"radius\":[1]"), "s:2:11: a list; expected a number");
  EXPECT_EQ(of_sphere("\"center\":1"), "s:2:11: 1; expected the fields of a Vec3 in braces");
  EXPECT_EQ(of_sphere("\"center\":\n{\"\\u0078\":{}}"), "s:3:11: an object; expected a number");
  EXPECT_EQ(of_sphere("\"r\\q\":1"), "s:2:2: \"r\\q\"; expected a text as JSON writes it");
  EXPECT_EQ(json_error("{\"nodes\":[{\"name\":\"\\q\"}]}"),
            "s:1:19: \"\\q\"; expected a text as JSON writes it");
  EXPECT_EQ(of_sphere("\"radius\":\"1e999\""), "s:2:11: \"1e999\"; expected a number");
  EXPECT_EQ(of_sphere("\"radius\":1,\n\"radius\":2"),
            "s:3:1: 'radius' is given twice; expected each field once");
  EXPECT_EQ(json_error("{\"metadata\":{\"properties\":{\"a\":\"1\",\n\"a\":\"2\"}}}"),
            "s:2:1: 'a' is given twice; expected each field once");
  EXPECT_EQ(json_error("{\"nodes\":[{\"shape\":{\"sphere\":{},\n\"sphere\":{}}}]}"),
            "s:2:1: 'sphere' is given twice; expected each field once");
  EXPECT_EQ(json_error("{\"blobs\":[{\"data\":\n\"?\"}]}").substr(0, 7), "s:2:1: ");
  EXPECT_EQ(json_error("{\"nodes\":{}}"), "s:1:10: an object; expected a list in brackets");
  EXPECT_EQ(json_error("{\"nodes\":3}"), "s:1:10: 3; expected a list in brackets");
  EXPECT_EQ(json_error("{\"nodes\":[{\"name\":3}]}"),
            "s:1:19: 3; expected a text in double quotes");
  EXPECT_EQ(json_error("{\"nodes\":[{\"shape\":{\"materials\":[\"a\",\n3]}}]}"),
            "s:2:1: 3; expected a text in double quotes");
  EXPECT_EQ(json_error("{\"metadata\":{\"properties\":[1]}}"),
            "s:1:27: a list; expected names and values in braces");
  EXPECT_EQ(json_error("{\"metadata\":{\"properties\":{\"a\":\n1}}}"),
            "s:2:1: 1; expected a text in double quotes");
  EXPECT_EQ(json_error("{\"nodes\":[{\"shape\":{\"sphere\":{},\n\"box\":{}}}]}"),
            "s:2:1: 'box' beside another of its kind; expected only one of them");
  for (const char* width : {"4294967296", "-1", "1.5", "\"1e1\"", "\"64.0\""}) {
    EXPECT_EQ(json_error(fmt::format("{{\"settings\":{{\"width\":{}}}}}", width)),
              fmt::format("s:1:22: {}; expected an integer in the field's range", width));
  }
  EXPECT_EQ(json_error("{\"settings\":{\"width\":\"64\",\"height\":6.4e1,\"time\":null}}"),
            "no error");
}

TEST(SceneCodec, BoundsNesting) {
  std::string text, json;
  for (int i = 0; i < 200; ++i) text += "nodes { children {", json += "{\"children\":[";
  EXPECT_NE(text_error("nodes {" + text), "no error");
  const std::string found = json_error("{\"nodes\":[" + json);
  EXPECT_NE(found.find("nested too deep"), std::string::npos) << found;
  v1::Scene deep;
  v1::Node* node = deep.add_nodes();
  for (int i = 0; i < 200; ++i) node = node->add_children();
  EXPECT_EQ(parse_scene(serialize_scene(deep)), std::nullopt);
}

v1::Scene nested(int nodes) {
  v1::Scene scene;
  v1::Node* node = scene.add_nodes();
  for (int i = 1; i < nodes; ++i) node = node->add_children();
  node->set_name("innermost");
  return scene;
}

TEST(SceneCodec, HasTheSameDepthInEveryEncoding) {
  for (const SceneEncoding encoding : kEncodings) {
    const v1::Scene deepest = nested(kMaxSceneDepth);
    const SceneWithBlobs back = decode_scene(encode_scene(deepest, {}, encoding), encoding, "s");
    EXPECT_TRUE(MessageDifferencer::Equals(back.scene, deepest));
    const std::string found =
        error_of([&] { encode_scene(nested(kMaxSceneDepth + 1), {}, encoding); });
    EXPECT_NE(found.find("nested too deep; expected at most 64 levels"), std::string::npos);
    EXPECT_LT(found.size(), 200u);
  }
  EXPECT_EQ(parse_scene(serialize_scene(nested(kMaxSceneDepth + 1))), std::nullopt);
  EXPECT_TRUE(parse_scene(serialize_scene(nested(kMaxSceneDepth))).has_value());
  std::string text = "nodes {", json = "{\"nodes\": [{";
  for (int i = 1; i <= kMaxSceneDepth; ++i) text += "children {", json += "\"children\": [{";
  for (int i = 0; i <= kMaxSceneDepth; ++i) text += "}", json += "}]";
  // What our walk finds, and what the parser does not even read.
  std::string deeper = "nodes {";
  for (int i = 0; i < 1000; ++i) deeper += "children {";
  for (const std::string& deep : {text, deeper}) {
    EXPECT_NE(text_error(deep).find("nested too deep; expected at most 64 levels"),
              std::string::npos)
        << text_error(deep);
  }
  EXPECT_NE(json_error(json + "}").find("nested too deep"), std::string::npos);
  EXPECT_EQ(json_error("{\"nodes\": [[[]]]}"), "s:1:12: a list in a list; expected a value");
}

TEST(SceneCodec, RefusesNumbersThatAnEnumerationDoesNotHave) {
  const std::string expected =
      "settings.integrator.shadows is 7; expected one of SHADOWS_ON, SHADOWS_BY_LIGHT, SHADOWS_OFF";
  EXPECT_EQ(text_error("settings {\n integrator { shadows: 7 } }"), "s:2:15: " + expected);
  EXPECT_EQ(json_error("{\"settings\":\n{\"integrator\":{\"shadows\":7}}}"), "s:2:26: " + expected);
  v1::Scene scene;
  scene.mutable_settings()->mutable_integrator()->set_shadows(
      static_cast<v1::IntegratorSettings::Shadows>(7));
  EXPECT_EQ(error(serialize_scene(scene), SceneEncoding::binary), "s: " + expected);
  EXPECT_EQ(parse_scene(serialize_scene(scene)), std::nullopt);
  EXPECT_EQ(error_of([&] { encode_scene(scene, {}, SceneEncoding::text); }),
            "the scene: " + expected);
}

TEST(SceneCodec, RefusesHostileBytesWithoutThrowing) {
  EXPECT_EQ(parse_scene("\x0a\xff\xff\xff\xff\x0f"), std::nullopt);
  v1::Scene scene;
  scene.mutable_settings()->set_time(std::nan(""));
  EXPECT_EQ(parse_scene(serialize_scene(scene)), std::nullopt);
  EXPECT_TRUE(parse_scene("").has_value());
}

TEST(SceneCodec, ChecksTheDigestOfABlob) {
  const SceneWithBlobs made = with_blob("abc");
  std::string text = encode_scene(made.scene, made.blobs, SceneEncoding::text);
  const size_t at = text.find("\"abc\"");
  ASSERT_NE(at, std::string::npos);
  text.replace(at, 5, "\"abd\"");
  EXPECT_NE(text_error(text).find("does not have that digest"), std::string::npos);
}

TEST(SceneCodec, KeepsLargeBlobsBesideTheFile) {
  namespace fs = std::filesystem;
  const fs::path folder = fs::path(testing::TempDir()) / "tessera_scene_codec_test";
  fs::remove_all(folder);
  fs::create_directories(folder);
  const std::string path = (folder / "s.tessera").string();
  const SceneWithBlobs made = with_blob(std::string(kMaxEmbeddedBlobBytes + 1, 'x'));
  write_scene_file(path, made.scene, made.blobs);
  EXPECT_LT(fs::file_size(path), 1000u);
  const SceneWithBlobs back = read_scene_file(path, SceneEncoding::text);
  EXPECT_TRUE(MessageDifferencer::Equals(back.scene, made.scene));
  EXPECT_EQ(back.blobs.size(), 1u);
  const fs::path blob = folder / "s.tessera.blobs" / made.blobs.all().begin()->first.hex();
  // By a link it is found where that leads to a place inside.
  fs::create_directory(folder / "pool");
  fs::rename(blob, folder / "pool/blob");
  fs::create_symlink(folder / "pool/blob", blob);
  EXPECT_EQ(read_scene_file(path, SceneEncoding::text).blobs.size(), 1u);
  fs::create_directory(folder / "scenes");
  const std::string deeper = (folder / "scenes/s.tessera").string();
  fs::copy(path, deeper);
  fs::create_directory_symlink("../s.tessera.blobs", deeper + ".blobs");
  EXPECT_NE(error_of([&] {
              read_scene_file(deeper, SceneEncoding::text);
            }).find("a blob that is not inside '" + (folder / "scenes").string() + "'"),
            std::string::npos);
  EXPECT_EQ(read_scene_file(deeper, SceneEncoding::text, folder).blobs.size(), 1u);
  fs::remove(blob);
  fs::rename(folder / "pool/blob", blob);
  std::ofstream(blob, std::ios::in) << 'y';
  EXPECT_NE(error_of([&] { read_scene_file(path, SceneEncoding::text); }).find("do not have"),
            std::string::npos);
  std::ofstream(blob, std::ios::app) << 'y';
  EXPECT_NE(error_of([&] { read_scene_file(path, SceneEncoding::text); })
                .find(fmt::format("{} bytes; expected {}", kMaxEmbeddedBlobBytes + 2,
                                  kMaxEmbeddedBlobBytes + 1)),
            std::string::npos);
  fs::remove(blob);
  EXPECT_NE(error_of([&] { read_scene_file(path, SceneEncoding::text); }).find("no such file"),
            std::string::npos);
  fs::remove_all(folder);
}

TEST(SceneCodec, AFieldOfALaterVersionIsRefusedWhereverItIs) {
  v1::Scene scene;
  EXPECT_TRUE(parse_scene(serialize_scene(scene)));
  google::protobuf::Message* const shape = scene.add_nodes()->mutable_shape();
  shape->GetReflection()->MutableUnknownFields(shape)->AddVarint(999, 1);
  EXPECT_EQ(parse_scene(serialize_scene(scene)), std::nullopt);
  EXPECT_EQ(error_of([&] { decode_scene(serialize_scene(scene), SceneEncoding::binary, "s"); }),
            "s: nodes[0].shape has a field 999; expected none of a later version");
  scene.clear_nodes();
  scene.GetReflection()->MutableUnknownFields(&scene)->AddVarint(998, 1);
  EXPECT_EQ(error_of([&] { decode_scene(serialize_scene(scene), SceneEncoding::binary, "s"); }),
            "s: the scene has a field 998; expected none of a later version");
}

TEST(SceneCodec, ListsEachReferencedBlobOnce) {
  v1::Scene scene = with_blob("abc").scene;
  *scene.add_nodes() = scene.nodes(0);
  ASSERT_TRUE(referenced_blobs(scene).has_value());
  EXPECT_EQ(referenced_blobs(scene)->size(), 1u);
  scene.mutable_nodes(0)->mutable_shape()->mutable_mesh()->mutable_positions()->set_digest("x/..");
  EXPECT_EQ(referenced_blobs(scene), std::nullopt);
}

}  // namespace
}  // namespace tessera
