#include "studio/studio_session.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <nlohmann/json.hpp>
#include <span>

#include "base/digest.h"
#include "studio/reading_log.h"
#include "tests/unit/studio/studio_session_case.h"

namespace tessera {
namespace {

class StudioSessionTest : public StudioSessionCase {};

TEST_F(StudioSessionTest, OnlyATokenLetsIn) {
  connect(1, "wrong");
  EXPECT_EQ(closed_[1], 4401);
  session_.connect(2, now_);
  say(2, {{"list", Json::object()}});
  EXPECT_EQ(closed_[2], 4401);
  session_.connect(3, now_);
  session_.receive(3, "no JSON", now_);
  act();
  EXPECT_EQ(closed_[3], 4401);
  session_.connect(4, now_);
  now_ += seconds(3);
  act();
  EXPECT_EQ(closed_[4], 4401) << "no hello in time";
  connect(5);
  EXPECT_EQ(heard(5, "welcome").size(), 1u);
  EXPECT_FALSE(closed_.contains(5));
}

TEST_F(StudioSessionTest, EditorsAreToldWhatElseWasOpened) {
  StudioSession session({.folder = "/f",
                         .file = "",
                         .version = "1",
                         .settings = "{}",
                         .recent_folders = {"/f", "/it's", "/b"}},
                        [](const std::string& token) {
                          return token == "see" ? StudioRole::viewer : StudioRole::editor;
                        });
  const auto welcomed = [&](ClientId client, const char* token) -> Json {
    session.connect(client, now_);
    session.receive(client, Json{{"hello", {{"token", token}}}}.dump(), now_);
    for (const StudioOrder& order : session.tick(now_)) {
      const auto* const text = std::get_if<SendText>(&order);
      const Json message = text ? Json::parse(text->text) : Json();
      if (message.contains("welcome")) return message["welcome"];
    }
    return Json::object();
  };
  const Json expected{{{"folder", "/it's"}, {"command", R"(tessera studio '/it'\''s')"}},
                      {{"folder", "/b"}, {"command", "tessera studio /b"}}};
  EXPECT_EQ(welcomed(1, "right")["recent"], expected);
  const Json of_viewer = welcomed(2, "see");
  EXPECT_EQ(of_viewer["folder"], "/f");
  EXPECT_FALSE(of_viewer.contains("recent"));
}

TEST_F(StudioSessionTest, AViewerSeesAndDoesNotEdit) {
  connect(1, "see");
  say(1, {{"open", {{"file", "a.tessera"}}}});
  EXPECT_EQ(heard(1, "document").at(0)["text"], "one\ntwo\n");
  say(1, edit(1, {{0, 0, "x"}}));
  EXPECT_EQ(heard(1, "refused").size(), 1u);
  say(1, {{"save", {{"file", "a.tessera"}}}});
  EXPECT_EQ(disk_.files["a.tessera"], "one\ntwo\n");
}

TEST_F(StudioSessionTest, AViewerWhoOpensFirstKeepsNobodyFromEditing) {
  connect(1, "see");
  say(1, {{"open", {{"file", "a.tessera"}}}});
  EXPECT_EQ(heard(1, "document").at(0)["read_only"], true);
  connect(2, "right");
  say(2, {{"open", {{"file", "a.tessera"}}}});
  EXPECT_EQ(heard(2, "document").at(0)["read_only"], false);
  say(2, edit(1, {{0, 0, "x"}}));
  EXPECT_EQ(heard(2, "edited").at(0)["version"], 2);
  EXPECT_EQ(heard(1, "change").size(), 1u);
}

TEST_F(StudioSessionTest, WhoSaysNoHelloTakesLittle) {
  for (ClientId client = 1; client <= 9; ++client) session_.connect(client, now_);
  act();
  EXPECT_EQ(closed_, (std::map<ClientId, uint16_t>{{9, 1013}}));
  session_.receive(1, Json{{"hello", {{"token", "right"}}}}.dump(), now_);
  session_.connect(10, now_);
  session_.receive(2, Json{{"hello", {{"token", "right"}, {"x", std::string(70'000, 'x')}}}}.dump(),
                   now_);
  act();
  EXPECT_EQ(closed_, (std::map<ClientId, uint16_t>{{9, 1013}, {2, 4401}}));
  EXPECT_EQ(heard(1, "welcome").size(), 1u);
}

TEST_F(StudioSessionTest, AViewIsNoLargerThanTheLimit) {
  connect(1, "see");
  const int most = heard(1, "welcome").at(0)["limits"].value("view_side", 0);
  const auto view = [](int width, int height) -> Json {
    return {{"view", {{"pane", 0}, {"file", "a.tessera"}, {"size", {width, height}}}}};
  };
  say(1, view(7680, 4320));
  EXPECT_TRUE(heard(1, "refused").empty());
  say(1, view(7681, 4320));
  EXPECT_EQ(heard(1, "refused").size(), 1u);
  say(1, view(16384, 16384));
  EXPECT_EQ(heard(1, "refused").size(), 1u);
  say(1, view(most, 1));
  EXPECT_TRUE(heard(1, "refused").empty());
  say(1, view(1, most + 1));
  EXPECT_EQ(heard(1, "refused").size(), 1u);
}

TEST_F(StudioSessionTest, TheWorkspaceIsKeptForTheFolderAndTold) {
  const Json workspace{{"open", {"a.tessera"}}, {"active", "a.tessera"}};
  connect(1);
  session_.receive(1, Json{{"workspace", workspace}}.dump(), now_);
  std::vector<std::string> kept;
  for (const StudioOrder& order : session_.tick(now_)) {
    const auto* const task = std::get_if<FileTask>(&order);
    const auto* const keep = task ? std::get_if<KeepWorkspace>(task) : nullptr;
    if (keep) kept.push_back(keep->json);
  }
  EXPECT_EQ(kept, std::vector<std::string>{workspace.dump()});
  connect(2);
  EXPECT_EQ(heard(2, "welcome").at(0)["workspace"], workspace);
}

TEST_F(StudioSessionTest, APageIsToldWhatOptionsTake) {
  connect(1);
  const Json welcome = heard(1, "welcome").at(0);
  EXPECT_EQ(welcome["choices"]["shadows"], (Json{"on", "by-light", "off"}));
  for (const char* name :
       {"integrator", "pattern", "filter", "tone-map", "transfer", "aovs", "channel"})
    EXPECT_TRUE(welcome["choices"].contains(name)) << name;
  for (const char* name : {"spp", "max-depth", "workers", "nice", "side", "pixels", "frames"})
    EXPECT_GT(welcome["limits"].value(name, 0), 0) << name;
}

TEST_F(StudioSessionTest, AViewersRefusalNamesWhatItAskedFor) {
  connect(1, "see");
  say(1, {{"settings", {{"theme", "dark"}}}});
  EXPECT_EQ(heard(1, "refused").at(0)["request"], "settings");
  say(1, {{"view", {{"file", "a.tessera"}, {"size", {8, 8}}, {"mode", "sometimes"}}}});
  const std::string why = heard(1, "refused").at(0)["why"];
  EXPECT_NE(why.find("typing, save or hand"), std::string::npos) << why;
}

TEST_F(StudioSessionTest, OfEachKindOfQuestionAPageHasOneUnderWayAndTheNewestBehindIt) {
  connect(1);
  connect(2);
  say(1, {{"open", {{"file", "a.tessera"}}}});
  say(2, {{"open", {{"file", "a.tessera"}}}});
  std::vector<SourceOrder> asked;
  const auto ask = [&](ClientId client, const char* kind, uint64_t number) {
    const Json fields{{"file", "a.tessera"}, {"base", 1}, {"offset", 0}, {"number", number}};
    session_.receive(client, Json{{kind, fields}}.dump(), now_);
    for (StudioOrder& order : session_.tick(now_)) {
      if (auto* const source = std::get_if<SourceOrder>(&order))
        asked.push_back(std::move(*source));
      if (auto* const text = std::get_if<SendText>(&order))
        told_[text->client].push_back(Json::parse(text->text));
    }
  };
  for (uint64_t number = 1; number <= 100; ++number) ask(1, "complete", number);
  ask(1, "hover", 101);
  ask(2, "complete", 102);
  ASSERT_EQ(asked.size(), 3U);
  EXPECT_EQ(asked[0].request.number, 1U);
  const std::vector<Json> superseded = heard(1, "refused");
  ASSERT_EQ(superseded.size(), 98U);
  EXPECT_EQ(superseded.front()["number"], 2);
  EXPECT_EQ(superseded.back()["number"], 99);
  session_.take(RequestDone{{1, "complete"}});
  ask(1, "complete", 103);
  ASSERT_EQ(asked.size(), 4U);
  EXPECT_EQ(asked[3].request.number, 100U);
  session_.take(RequestDone{{1, "complete"}});
  ask(1, "complete", 105);
  session_.disconnect(1);
  session_.take(RequestDone{{1, "complete"}});
  ask(2, "hover", 104);
  EXPECT_EQ(asked.back().request.number, 104U) << "nothing is done for a page that is gone";
}

TEST_F(StudioSessionTest, ComparisonsAndListsDoNotPileUp) {
  connect(1, "see");
  const auto count = [&](const char* kind) {
    size_t found = 0;
    for (int i = 0; i < 100; ++i) session_.receive(1, Json{{kind, Json::object()}}.dump(), now_);
    for (const StudioOrder& order : session_.tick(now_)) {
      const auto* const task = std::get_if<FileTask>(&order);
      found += std::holds_alternative<ComparePictures>(order) ||
               (task && std::holds_alternative<ListFiles>(*task));
    }
    return found;
  };
  EXPECT_EQ(count("compare"), 1U);
  EXPECT_EQ(count("list"), 1U);
  session_.take(RequestDone{{1, "compare"}});
  session_.take(FilesListed{1, {}});
  EXPECT_EQ(session_.tick(now_).size(), 3U) << "the list, and what waited of either kind";
}

TEST_F(StudioSessionTest, APictureGoesToNamesThatNothingHas) {
  disk_.files["there.png"] = "";
  connect(1);
  const auto render = [](const std::string& name, bool force) {
    return Json{
        {"render", {{"file", "a.tessera"}, {"spec", {{"outputs", {name}}, {"force", force}}}}}};
  };
  say(1, render("there.png", false));
  EXPECT_EQ(heard(1, "refused").size(), 1u);
  EXPECT_TRUE(reads_.empty());
  say(1, render("new.png", false));
  EXPECT_EQ(heard(1, "refused").size(), 0u);
  EXPECT_EQ(reads_.size(), 1u);
}

TEST_F(StudioSessionTest, ASecondPageReadsAndMayTakeOver) {
  connect(1);
  say(1, {{"open", {{"file", "a.tessera"}}}});
  connect(2);
  say(2, {{"open", {{"file", "a.tessera"}}}});
  EXPECT_EQ(heard(2, "document").at(0)["read_only"], true);
  say(1, edit(1, {{0, 3, "1"}}));
  EXPECT_EQ(heard(2, "change").at(0)["changes"], Json::parse(R"([[0, 3, "1"]])"));
  say(2, edit(2, {{0, 0, "x"}}));
  EXPECT_EQ(heard(2, "refused").size(), 1u);
  heard(1, "document");
  say(2, {{"take_over", {{"file", "a.tessera"}}}});
  EXPECT_EQ(heard(1, "document").at(0)["read_only"], true);
  EXPECT_EQ(heard(2, "document").at(0)["read_only"], false);
  say(2, edit(2, {{0, 0, "x"}}));
  EXPECT_EQ(heard(2, "edited").size(), 1u);
}

TEST_F(StudioSessionTest, APageThatWasCutOffGoesOn) {
  connect(1);
  const std::string id = heard(1, "welcome").at(0)["id"];
  say(1, {{"open", {{"file", "a.tessera"}}}});
  say(1, edit(1, {{0, 3, "1"}}));
  session_.disconnect(1);
  session_.connect(2, now_);
  const auto hello = [](const std::string& resume, const std::string& text) {
    const std::string hash = sha256_hex(std::as_bytes(std::span(text)));
    return Json{
        {"hello", {{"token", "right"}, {"resume", resume}, {"have", {{"a.tessera", {2, hash}}}}}}};
  };
  say(2, hello(id, "1\ntwo\n"));
  EXPECT_EQ(heard(2, "edited").at(0)["version"], 2);
  EXPECT_TRUE(heard(2, "document").empty()) << "it has the text";
  say(2, edit(2, {{0, 0, "x"}}));
  EXPECT_EQ(heard(2, "edited").at(0)["version"], 3);
  // One whose last edit had not come is sent the text; and so is one that the program does not
  // notice to have been cut off.
  EXPECT_EQ(heard(2, "welcome").at(0)["id"], id) << "it is the same page";
  session_.connect(3, now_);
  say(3, hello(id, "1\ntwo\n"));
  EXPECT_EQ(heard(3, "document").at(0)["text"], "x1\ntwo\n");
  EXPECT_EQ(heard(3, "document").size(), 0u);
  EXPECT_EQ(closed_[2], 1000);
  // An id that this run did not give is worth nothing.
  session_.connect(4, now_);
  say(4, hello("9." + id.substr(2), "x1\ntwo\n"));
  EXPECT_EQ(heard(4, "document").at(0)["read_only"], true);
  EXPECT_FALSE(closed_.contains(3));
}

TEST_F(StudioSessionTest, ASampleIsSeenAsItShipsAndCopied) {
  connect(1);
  EXPECT_EQ(heard(1, "welcome").at(0)["templates"].size(), 3u);
  say(1, {{"open", {{"file", "a.tessera"}}}});
  say(1, {{"view", {{"pane", 6}, {"file", "a.tessera"}, {"sample", true}, {"size", {160, 90}}}}});
  ASSERT_EQ(reads_.size(), 1u);
  EXPECT_TRUE(reads_.back().is_sample);
  EXPECT_TRUE(reads_.back().texts.empty());
  say(1, edit(1, {{0, 3, "three"}}));
  EXPECT_EQ(reads_.size(), 1u) << "a text that is edited is no sample";
  say(1, {{"view", {{"pane", 0}, {"file", "a.tessera"}, {"size", {160, 90}}}}});
  ASSERT_EQ(reads_.size(), 2u);
  EXPECT_FALSE(reads_.back().is_sample);
  EXPECT_TRUE(reads_.back().texts.contains("a.tessera"));
  say(1, {{"create", {{"sample", "knot.tessera"}}}});
  ASSERT_EQ(disk_.others.size(), 1u);
  EXPECT_EQ(std::get<CopySample>(disk_.others[0]).sample, "knot.tessera");
}

/// The binary frame of a chunk.
std::string chunk_frame(uint8_t number, const std::string& bytes, bool is_last) {
  std::string frame = "TSPX" + std::string(28, '\0') + bytes;
  frame[4] = 3;
  frame[8] = static_cast<char>(number);
  frame[30] = is_last ? 1 : 0;
  return frame;
}

TEST_F(StudioSessionTest, AFileComesInChunks) {
  connect(1);
  say(1, {{"put", {{"name", "a.obj"}, {"size", 5}, {"number", 7}}}});
  ASSERT_EQ(disk_.others.size(), 1u);
  EXPECT_EQ(std::get<BeginUpload>(disk_.others[0]).name, "a.obj");
  session_.take(UploadProgress{1, 7, {"a-2.obj", 0, false}});
  act();
  EXPECT_EQ(heard(1, "put").at(0)["name"], "a-2.obj");
  session_.receive_binary(1, chunk_frame(7, "v 1 2", true), now_);
  session_.receive_binary(1, "no frame", now_);
  act();
  ASSERT_EQ(disk_.others.size(), 2u);
  const auto& chunk = std::get<AppendUpload>(disk_.others[1]);
  EXPECT_EQ(chunk.number, 7u);
  EXPECT_EQ(chunk.bytes, "v 1 2");
  EXPECT_TRUE(chunk.is_last);
  session_.take(FileFailed{1, "put", "a-2.obj", "the disk is full", 7});
  act();
  EXPECT_EQ(heard(1, "refused").at(0)["upload"], 7);
  session_.disconnect(1);
  act();
  EXPECT_EQ(std::get<DropUploads>(disk_.others.at(2)).client, 1u);
}

TEST_F(StudioSessionTest, WhoSendsChunksWithoutWaitingIsShutOut) {
  connect(1);
  for (int i = 0; i < StudioSession::kMostChunksWaiting; ++i)
    session_.receive_binary(1, chunk_frame(7, "v", false), now_);
  act();
  EXPECT_FALSE(closed_.contains(1));
  session_.receive_binary(1, chunk_frame(7, "v", false), now_);
  act();
  EXPECT_EQ(closed_[1], 1008);
  connect(2, "see");
  const size_t before = disk_.others.size();
  session_.receive_binary(2, chunk_frame(7, "v", false), now_);
  say(2, {{"put", {{"name", "a.obj"}, {"size", 5}, {"number", 7}}}});
  EXPECT_EQ(disk_.others.size(), before) << "a viewer writes nothing";
  session_.connect(3, now_);
  session_.receive_binary(3, chunk_frame(7, "v", false), now_);
  act();
  EXPECT_EQ(closed_[3], 4401);
}

TEST(ReadingLogTest, TellsOfReadsOnceTheyRest) {
  using std::chrono::milliseconds;
  ReadingLog log;
  const Time begin = std::chrono::seconds(5);
  EXPECT_EQ(log.deadline(), Time::max());
  log.note("a.tessera", .0042, begin);
  EXPECT_EQ(log.deadline(), begin + ReadingLog::kRest);
  EXPECT_TRUE(log.due(begin + milliseconds(999)).empty());
  EXPECT_EQ(log.due(begin + milliseconds(1000)),
            std::vector<std::string>{"'a.tessera': read in 4.2 ms"});
  EXPECT_EQ(log.deadline(), Time::max());
  // Someone types: no line a key.
  for (int i = 0; i < 4; ++i) {
    log.note("a.tessera", .003 + .001 * (3 - i), begin + milliseconds(2000 + 900 * i));
    EXPECT_TRUE(log.due(begin + milliseconds(2000 + 900 * i)).empty());
  }
  log.note("b.crt", .25, begin + milliseconds(4800));
  EXPECT_EQ(log.deadline(), begin + milliseconds(5700));
  EXPECT_EQ(log.due(begin + milliseconds(5800)),
            (std::vector<std::string>{"'a.tessera': read 4 times, each in 3.0 to 6.0 ms",
                                      "'b.crt': read in 250.0 ms"}));
}

TEST_F(StudioSessionTest, WithoutSamplesNoneIsSeen) {
  StudioSession bare({.folder = "/f", .file = "", .version = "1", .settings = "{}"},
                     [](const std::string&) { return StudioRole::editor; });
  bare.connect(1, now_);
  bare.receive(1, R"({"hello": {}})", now_);
  bare.receive(1, R"({"view": {"file": "etc/a.obj", "sample": true, "size": [9, 9]}})", now_);
  const StudioOrders orders = bare.tick(now_);
  ASSERT_TRUE(std::holds_alternative<SendText>(orders.back()));
  EXPECT_NE(std::get<SendText>(orders.back()).text.find("no samples"), std::string::npos);
}

TEST_F(StudioSessionTest, NoViewLooksOutOfTheFolder) {
  connect(1);
  for (const bool is_sample : {false, true}) {
    for (const char* const file : {"../b.tessera", "/etc/passwd", ".hidden/b.tessera", ""}) {
      say(1, {{"view", {{"file", file}, {"sample", is_sample}, {"size", {160, 90}}}}});
      EXPECT_EQ(heard(1, "refused").size(), 1u) << file;
    }
  }
  EXPECT_TRUE(reads_.empty());
}

TEST_F(StudioSessionTest, WrongMessagesAreRefusedAndHarmNobody) {
  connect(1);
  for (const std::string text :
       {"", "[]", "{}", "{\"edit\": 5}", "{\"edit\": {\"file\": 5}}", "{\"a\": {}, \"b\": {}}",
        "{\"view\": {\"pane\": 99, \"size\": [1, 1]}}",
        "{\"view\": {\"pane\": 0, \"size\": [0, 1]}}",
        "{\"view\": {\"pane\": 0, \"size\": [1, 1], \"camera\": {\"fov\": 180}}}",
        "{\"view\": {\"pane\": 0, \"size\": [1, 1], \"camera\": {\"eye\": [1, 2]}}}"}) {
    session_.receive(1, text, now_);
    act();
    EXPECT_EQ(heard(1, "refused").size(), 1u) << text;
  }
  say(1, {{"what_is_new", {{"a", 1}}}});
  EXPECT_EQ(heard(1, "refused").size(), 0u) << "an unknown kind is ignored";
  session_.receive(1, std::string(100, '[') + std::string(100, ']'), now_);
  act();
  EXPECT_EQ(heard(1, "refused").size(), 1u);
  EXPECT_FALSE(closed_.contains(1));
}

TEST_F(StudioSessionTest, NoMorePagesAreWelcomedThanAreFitForASecond) {
  const auto count = [&](ClientId first) {
    for (ClientId client = first; client < first + 100; ++client) {
      connect(client);
      session_.disconnect(client);
    }
    return std::ranges::count_if(closed_, [&](const auto& closed) {
      return closed.first >= first && closed.second == 1013;
    });
  };
  EXPECT_EQ(count(1), 100 - StudioSession::kMostWelcomes.at_once);
  now_ += seconds(1);
  EXPECT_EQ(count(101), 100 - StudioSession::kMostWelcomes.at_once);
}

TEST_F(StudioSessionTest, OnlyEditsMayBeLarge) {
  connect(1);
  say(1, {{"open", {{"file", "a.tessera"}}}});
  say(1, {{"open", {{"file", std::string(2 << 20, 'x')}}}});
  EXPECT_NE(heard(1, "refused").at(0).dump().find("bytes"), std::string::npos);
  EXPECT_EQ(disk_.others.size(), 0u);
  say(1, edit(1, {{0, 0, std::string(2 << 20, 'x')}}));
  EXPECT_EQ(heard(1, "edited").size(), 1u);
}

TEST_F(StudioSessionTest, ARefusalRepeatsLittleOfWhatItIsAbout) {
  connect(1);
  const std::string many(400'000, '1');
  for (const Json& message :
       {Json{{"open", {{"file", Json::array({many})}}}},
        Json{{"view",
              {{"file", "a.tessera"}, {"size", {9, 9}}, {"overrides", {{many, Json::array()}}}}}},
        edit(1, Json::array({many}))}) {
    say(1, message);
    const std::vector<Json> refused = heard(1, "refused");
    ASSERT_EQ(refused.size(), 1u);
    EXPECT_LT(refused[0].dump().size(), 1000u);
  }
}

TEST_F(StudioSessionTest, AnExportWithoutStatisticsSaysSo) {
  connect(1);
  const auto refusal_of = [&](const Json& wish) {
    say(1, {{"export", wish}});
    const std::vector<Json> refused = heard(1, "refused");
    return refused.empty() ? std::string() : refused[0]["why"].get<std::string>();
  };
  EXPECT_NE(refusal_of({{"file", "a.tessera"}, {"name", "a.png"}, {"statistics", true}})
                .find("statistics"),
            std::string::npos);
  EXPECT_EQ(refusal_of({{"file", "a.tessera"}, {"name", "a.png"}}).find("statistics"),
            std::string::npos);
}

TEST_F(StudioSessionTest, AnOrderIsAnsweredByItsNumberAndToItsPageAlone) {
  connect(1);
  connect(2);
  disk_.files["there.png"] = "";
  say(1, {{"render", {{"file", "a.tessera"}, {"number", 7}}}});
  EXPECT_EQ(heard(1, "ordered"), (std::vector<Json>{{{"number", 7}, {"job", 1}}}));
  EXPECT_TRUE(heard(2, "ordered").empty());
  const auto render_to = [](Json outputs) {
    return Json{{"file", "a.tessera"}, {"spec", {{"outputs", std::move(outputs)}}}};
  };
  // The last of them is found to be wrong before it is an order at all.
  const std::vector<std::pair<std::string, Json>> wrong{
      {"render", render_to({"a.tessera"})},
      {"render", render_to({"there.png"})},
      {"export", {{"job", 99}, {"name", "a.png"}}},
      {"export", {{"command", {{"camera", {{"eye", {0, 0, 1}}, {"target", {0, 0, 0}}}}}}}},
      {"render", render_to(Json::array({1}))}};
  for (const auto& [kind, fields] : wrong) {
    Json order = fields;
    order["number"] = 8;
    say(1, {{kind, order}});
    const std::vector<Json> refused = heard(1, "refused");
    ASSERT_EQ(refused.size(), 1u) << fields;
    EXPECT_EQ(refused[0]["request"], kind);
    EXPECT_EQ(refused[0].value("number", 0), 8) << fields;
  }
  say(1, {{"render", render_to({"there.png"})}});
  EXPECT_EQ(heard(1, "refused").at(0)["existing"], (Json{{"first", "there.png"}, {"count", 1}}));
  connect(3, "see");
  say(3, {{"render", {{"file", "a.tessera"}, {"number", 9}}}});
  EXPECT_EQ(heard(3, "refused").at(0).value("number", 0), 9);
}

TEST_F(StudioSessionTest, WhoFloodsIsShutOut) {
  connect(1);
  const auto flood = [&](int count) {
    for (int i = 0; i < count; ++i) say(1, {{"ack", Json::object()}});
  };
  now_ += seconds(10);
  flood(StudioSession::kMostMessages.at_once);
  EXPECT_EQ(closed_.count(1), 0U);
  now_ += seconds(1);
  flood(StudioSession::kMostMessages.per_second);
  EXPECT_EQ(closed_.count(1), 0U);
  flood(1);
  EXPECT_EQ(closed_[1], 1008);
}

TEST_F(StudioSessionTest, PagesAreToldOfTheFarmWhenTheyComeAndWhenItChanges) {
  connect(1);
  EXPECT_TRUE(heard(1, "farm").empty());
  session_.set_farm({{"endpoint", "tcp://farm:7117"}});
  act();
  EXPECT_EQ(heard(1, "farm").size(), 1u);
  connect(2);
  EXPECT_EQ(heard(2, "farm").at(0)["endpoint"], "tcp://farm:7117");
}

}  // namespace
}  // namespace tessera
