// What a session does with texts: edits, saves, drafts, and files that change on disk.
#include <gtest/gtest.h>

#include <nlohmann/json.hpp>

#include "tests/unit/studio/studio_session_case.h"

namespace tessera {
namespace {

class StudioDocuments : public StudioSessionCase {};

TEST_F(StudioDocuments, EditsAreAcknowledgedAndSaved) {
  connect(1);
  say(1, {{"open", {{"file", "a.tessera"}}}});
  const Json document = heard(1, "document").at(0);
  EXPECT_EQ(document["version"], 1);
  EXPECT_EQ(document["read_only"], false);
  say(1, edit(1, {{0, 3, "1"}, {4, 7, "2"}}));
  EXPECT_EQ(heard(1, "edited").at(0)["version"], 2);
  say(1, {{"save", {{"file", "a.tessera"}}}});
  EXPECT_EQ(disk_.files["a.tessera"], "1\n2\n");
  EXPECT_EQ(heard(1, "saved").at(0)["version"], 2);
}

TEST_F(StudioDocuments, AnEditOfAnotherVersionIsAnsweredWithTheText) {
  connect(1);
  say(1, {{"open", {{"file", "a.tessera"}}}});
  heard(1, "document");
  say(1, edit(7, {{0, 0, "x"}}));
  EXPECT_EQ(heard(1, "document").at(0)["text"], "one\ntwo\n");
  say(1, edit(1, {{0, 100, "x"}}));
  EXPECT_EQ(heard(1, "refused").size(), 1u);
  EXPECT_EQ(heard(1, "document").at(0)["version"], 1);
}

TEST_F(StudioDocuments, AFileThatChangedOnDiskIsNotWrittenOver) {
  connect(1);
  say(1, {{"open", {{"file", "a.tessera"}}}});
  say(1, edit(1, {{0, 3, "mine"}}));
  disk_.files["a.tessera"] = "theirs\n";
  say(1, {{"save", {{"file", "a.tessera"}}}});
  EXPECT_EQ(disk_.files["a.tessera"], "theirs\n");
  EXPECT_EQ(heard(1, "disk").at(0)["state"], "changed");
  now_ += seconds(5);
  act();
  say(1, {{"save", {{"file", "a.tessera"}}}});
  EXPECT_EQ(disk_.files["a.tessera"], "theirs\n") << "also after it was looked at";
  say(1, {{"save", {{"file", "a.tessera"}, {"force", true}}}});
  EXPECT_EQ(disk_.files["a.tessera"], "mine\ntwo\n");
}

TEST_F(StudioDocuments, AForcedSaveGoesOverWhatWasToldAndNothingLater) {
  open_and_change_on_disk();
  say(1, edit(1, {{0, 3, "mine"}}));
  disk_.files["a.tessera"] = "later\n";
  say(1, {{"save", {{"file", "a.tessera"}, {"force", true}}}});
  EXPECT_EQ(disk_.files["a.tessera"], "later\n");
  EXPECT_EQ(heard(1, "disk").back()["text"], "later\n") << "it is told at once";
  say(1, {{"save", {{"file", "a.tessera"}, {"force", true}}}});
  EXPECT_EQ(disk_.files["a.tessera"], "mine\ntwo\n");
}

TEST_F(StudioDocuments, SavesOfAFileAreDoneInTurn) {
  connect(1);
  say(1, {{"open", {{"file", "a.tessera"}}}});
  say(1, edit(1, {{0, 3, "1"}}));
  std::vector<FileTask> saves;
  const auto save = [&] {
    session_.receive(1, Json{{"save", {{"file", "a.tessera"}}}}.dump(), now_);
    for (const StudioOrder& order : session_.tick(now_)) {
      const auto* const task = std::get_if<FileTask>(&order);
      if (task && std::holds_alternative<SaveFile>(*task)) saves.push_back(*task);
    }
  };
  for (int i = 0; i < 3; ++i) save();
  ASSERT_EQ(saves.size(), 1u);
  // A text that was typed meanwhile is saved with the next, which knows what this one wrote.
  session_.receive(1, edit(2, {{0, 1, "eins"}}).dump(), now_);
  disk_.carry_out(saves[0], session_);
  act();
  EXPECT_EQ(disk_.files["a.tessera"], "eins\ntwo\n");
  const std::vector<Json> saved = heard(1, "saved");
  ASSERT_EQ(saved.size(), 2u) << "those that waited are answered at once";
  EXPECT_EQ(saved[0]["version"], 2);
  EXPECT_EQ(saved[1]["version"], 3);
  EXPECT_EQ(heard(1, "refused").size(), 0u);
  EXPECT_EQ(heard(1, "disk").size(), 0u);
  // One that fails keeps none of the next ones.
  save();
  ASSERT_EQ(saves.size(), 2u);
  save();
  session_.take(FileFailed{1, "save", "a.tessera", "the disk is full"});
  act();
  EXPECT_EQ(heard(1, "refused").size(), 1u);
  EXPECT_EQ(heard(1, "saved").size(), 1u);
}

TEST_F(StudioDocuments, AFileThatIsGoneIsWrittenAnewOnceThatWasTold) {
  connect(1);
  say(1, {{"open", {{"file", "a.tessera"}}}});
  const Json save{{"save", {{"file", "a.tessera"}}}};
  disk_.files.erase("a.tessera");
  say(1, save);
  EXPECT_EQ(heard(1, "disk").at(0)["state"], "deleted");
  EXPECT_EQ(heard(1, "refused").size(), 1u);
  EXPECT_FALSE(disk_.files.contains("a.tessera"));
  disk_.files["a.tessera"] = "theirs\n";
  say(1, save);
  EXPECT_EQ(heard(1, "refused").size(), 1u);
  EXPECT_EQ(disk_.files["a.tessera"], "theirs\n") << "it came back";
  disk_.files.erase("a.tessera");
  say(1, save);
  EXPECT_EQ(heard(1, "saved").size(), 1u);
  EXPECT_EQ(disk_.files["a.tessera"], "one\ntwo\n");
}

TEST_F(StudioDocuments, ThirtyTwoFilesAreOpenAtMost) {
  connect(1);
  const auto open = [&](int number) {
    const std::string file = "f" + std::to_string(number) + ".tessera";
    disk_.files[file] = "text\n";
    say(1, {{"open", {{"file", file}}}});
  };
  for (int i = 0; i < 32; ++i) open(i);
  EXPECT_EQ(heard(1, "document").size(), 32u);
  open(32);
  EXPECT_EQ(heard(1, "refused").at(0)["why"], "32 files are open; expected at most that many");
  say(1, {{"close", {{"file", "f0.tessera"}}}});
  open(32);
  EXPECT_EQ(heard(1, "document").size(), 1u);
  EXPECT_EQ(heard(1, "refused").size(), 0u);
}

TEST_F(StudioDocuments, ATextThatNobodyEditsFollowsTheDisk) {
  connect(1, "see");
  say(1, {{"open", {{"file", "a.tessera"}}}});
  heard(1, "document");
  disk_.files["a.tessera"] = "theirs\r\n";
  now_ += seconds(5);
  act();
  const Json document = heard(1, "document").at(0);
  EXPECT_EQ(document["text"], "theirs\n");
  EXPECT_EQ(document["version"], 2);
  EXPECT_EQ(document["eol"], "crlf");
  EXPECT_EQ(document["dirty"], false);
  EXPECT_EQ(heard(1, "disk").size(), 0u);
  connect(2);
  say(2, {{"open", {{"file", "a.tessera"}}}});
  EXPECT_EQ(heard(2, "document").at(0)["text"], "theirs\n");
}

TEST_F(StudioDocuments, ALookThatASaveOvertookTellsNothing) {
  connect(1);
  say(1, {{"open", {{"file", "a.tessera"}}}});
  say(1, edit(1, {{0, 3, "1"}}));
  // The look is ordered while the save is still on its way.
  session_.receive(1, Json{{"save", {{"file", "a.tessera"}}}}.dump(), now_);
  now_ += seconds(5);
  const StudioOrders orders = session_.tick(now_);
  for (const StudioOrder& order : orders) {
    const auto* const task = std::get_if<FileTask>(&order);
    if (task && std::holds_alternative<SaveFile>(*task)) disk_.carry_out(*task, session_);
  }
  say(1, edit(2, {{0, 1, "eins"}}));
  int looks = 0;
  for (const StudioOrder& order : orders) {
    const auto* const task = std::get_if<FileTask>(&order);
    if (!task || !std::holds_alternative<LookAtFile>(*task)) continue;
    disk_.carry_out(*task, session_);
    ++looks;
  }
  act();
  EXPECT_EQ(looks, 1);
  EXPECT_EQ(heard(1, "disk").size(), 0u);
  say(1, {{"save", {{"file", "a.tessera"}}}});
  EXPECT_EQ(heard(1, "refused").size(), 0u);
  EXPECT_EQ(disk_.files["a.tessera"], "eins\ntwo\n");
}

TEST_F(StudioDocuments, AFileIsLookedAtOnceAtATimeHoweverLongThatTakes) {
  connect(1);
  say(1, {{"open", {{"file", "a.tessera"}}}});
  std::vector<FileTask> looks;
  const auto look = [&] {
    for (const StudioOrder& order : session_.tick(now_)) {
      const auto* const task = std::get_if<FileTask>(&order);
      if (task && std::holds_alternative<LookAtFile>(*task)) looks.push_back(*task);
    }
  };
  for (int i = 0; i < 10; ++i) {
    now_ += seconds(5);
    look();
  }
  ASSERT_EQ(looks.size(), 1U);
  session_.receive(1, Json{{"reload", {{"file", "a.tessera"}}}}.dump(), now_);
  session_.receive(1, Json{{"reload", {{"file", "a.tessera"}}}}.dump(), now_);
  look();
  ASSERT_EQ(looks.size(), 1U) << "it waits until the file was looked at";
  disk_.files["a.tessera"] = "theirs\n";
  session_.take(FileFailed{0, "look", "a.tessera", "too slow"});
  look();
  ASSERT_EQ(looks.size(), 2U);
  disk_.carry_out(looks[1], session_);
  act();
  EXPECT_EQ(heard(1, "disk").at(0)["text"], "theirs\n");
  now_ += seconds(5);
  look();
  EXPECT_EQ(looks.size(), 3U);
}

TEST_F(StudioDocuments, AReloadedFileIsCleanOnceThePageHasTakenItUp) {
  open_and_change_on_disk();
  say(1, edit(1, {{0, 8, "theirs\n"}}));
  EXPECT_EQ(heard(1, "saved").at(0)["version"], 2);
  say(1, {{"save", {{"file", "a.tessera"}}}});
  EXPECT_EQ(heard(1, "refused").size(), 0u);
}

TEST_F(StudioDocuments, AReloadLetsNoSaveWriteOverWhatIsNotReadYet) {
  open_and_change_on_disk();
  session_.receive(1, Json{{"reload", {{"file", "a.tessera"}}}}.dump(), now_);
  session_.receive(1, Json{{"save", {{"file", "a.tessera"}}}}.dump(), now_);
  act();
  EXPECT_EQ(disk_.files["a.tessera"], "theirs\n");
  EXPECT_EQ(heard(1, "refused").size(), 1u);
  const std::vector<Json> disk = heard(1, "disk");
  EXPECT_EQ(disk.back()["text"], "theirs\n") << "it comes though it was told before";
}

TEST_F(StudioDocuments, NoMoreThanASecondOfTypingHasNoDraft) {
  connect(1);
  say(1, {{"open", {{"file", "a.tessera"}}}});
  uint64_t version = 1;
  for (int i = 0; i < 49; ++i) {
    say(1, edit(version++, {{0, 0, "x"}}));
    now_ += milliseconds(100);
    act();
    const size_t kept = disk_.drafts["a.tessera"].text.find("one");
    EXPECT_GE((kept == std::string::npos ? 0 : kept) + 10, static_cast<size_t>(i + 1));
  }
  disk_.drafts.clear();
  say(1, edit(version++, {{0, 0, "y"}}));
  EXPECT_EQ(session_.deadline(), std::min(session_.deadline(), now_ + seconds(1)));
  now_ += seconds(1);
  act();
  EXPECT_EQ(disk_.drafts["a.tessera"].text.substr(0, 2), "yx");
  say(1, {{"save", {{"file", "a.tessera"}}}});
  EXPECT_TRUE(disk_.drafts.empty());
}

TEST_F(StudioDocuments, ADraftThatFailedIsTriedAgain) {
  connect(1);
  say(1, {{"open", {{"file", "a.tessera"}}}});
  disk_.draft_failure = "the disk is full";
  say(1, edit(1, {{0, 0, "x"}}));
  for (int i = 0; i < 5; ++i) {
    now_ += seconds(1);
    act();
  }
  EXPECT_EQ(heard(1, "refused").size(), 1u) << "it is told once";
  EXPECT_LE(session_.deadline(), now_ + seconds(1));
  disk_.draft_failure.clear();
  now_ += seconds(1);
  act();
  EXPECT_EQ(disk_.drafts["a.tessera"].text, "xone\ntwo\n");
  disk_.draft_failure = "the disk is full";
  say(1, edit(2, {{0, 0, "y"}}));
  now_ += seconds(1);
  act();
  EXPECT_EQ(heard(1, "refused").size(), 1u) << "it is told anew";
  say(1, {{"save", {{"file", "a.tessera"}}}});
  disk_.draft_failure.clear();
  now_ += seconds(2);
  act();
  EXPECT_TRUE(disk_.drafts.empty()) << "what is saved needs none";
}

TEST_F(StudioDocuments, ADraftIsOffered) {
  disk_.left["a.tessera"] = {{"p", {"/f", "a.tessera", Digest::of(""), 5, "unsaved"}}};
  connect(1);
  say(1, {{"open", {{"file", "a.tessera"}}}});
  EXPECT_EQ(heard(1, "document").at(0)["draft"]["text"], "unsaved");
  say(1, {{"recover", {{"file", "a.tessera"}, {"take", false}}}});
  EXPECT_TRUE(disk_.left["a.tessera"].empty());
}

TEST_F(StudioDocuments, SavingDropsNoDraftThatWasNotDecidedAbout) {
  const auto draft = [](const char* program, const char* text) {
    return KeptDraft{program, {"/f", "a.tessera", Digest::of(""), 5, text}};
  };
  disk_.left["a.tessera"] = {draft("r", "newest"), draft("q", "older"), draft("p", "oldest")};
  const Json save{{"save", {{"file", "a.tessera"}}}};
  const auto recover = [](bool take) {
    return Json{{"recover", {{"file", "a.tessera"}, {"take", take}}}};
  };
  connect(1);
  say(1, {{"open", {{"file", "a.tessera"}}}});
  EXPECT_EQ(heard(1, "document").at(0)["draft"]["text"], "newest");
  // It is put off: the page says nothing of it.
  say(1, edit(1, {{0, 0, "1"}}));
  now_ += seconds(1);
  act();
  say(1, save);
  EXPECT_EQ(disk_.left["a.tessera"].size(), 3u);
  say(1, recover(true));
  const Json next = heard(1, "draft").at(0);
  EXPECT_EQ(next["file"], "a.tessera");
  EXPECT_EQ(next["text"], "older");
  EXPECT_EQ(disk_.left["a.tessera"].size(), 3u) << "until it is saved";
  now_ += seconds(1);
  say(1, edit(2, {{0, 1, "2"}}));
  now_ += seconds(1);
  act();
  say(1, recover(false));
  EXPECT_EQ(heard(1, "draft").at(0)["text"], "oldest");
  EXPECT_EQ(disk_.left["a.tessera"].size(), 2u);
  EXPECT_EQ(disk_.drafts.size(), 1u) << "what was typed here has its own";
  say(1, save);
  ASSERT_EQ(disk_.left["a.tessera"].size(), 1u);
  EXPECT_EQ(disk_.left["a.tessera"][0].program, "p");
  EXPECT_TRUE(disk_.drafts.empty());
}

TEST_F(StudioDocuments, WhatIsDiscardedIsForgotten) {
  connect(1);
  connect(2, "see");
  say(1, {{"open", {{"file", "a.tessera"}}}});
  say(2, {{"open", {{"file", "a.tessera"}}}});
  say(1, edit(1, {{0, 3, "1"}}));
  now_ += seconds(1);
  act();
  EXPECT_EQ(disk_.drafts.size(), 1u);
  const Json discard{{"close", {{"file", "a.tessera"}, {"discard", true}}}};
  say(2, discard);
  EXPECT_EQ(heard(2, "refused").size(), 1u);
  EXPECT_EQ(disk_.drafts.size(), 1u) << "a viewer discards nothing";
  heard(2, "document");
  say(1, discard);
  EXPECT_TRUE(disk_.drafts.empty());
  EXPECT_EQ(heard(2, "document").at(0)["text"], "one\ntwo\n") << "who reads it sees the disk's";
  heard(1, "document");
  say(1, {{"open", {{"file", "a.tessera"}}}});
  const Json again = heard(1, "document").at(0);
  EXPECT_EQ(again["text"], "one\ntwo\n");
  EXPECT_FALSE(again.contains("draft"));
}

TEST_F(StudioDocuments, WhatIsClosedUnsavedAloneStays) {
  connect(1);
  say(1, {{"open", {{"file", "a.tessera"}}}});
  say(1, edit(1, {{0, 3, "1"}}));
  say(1, {{"close", {{"file", "a.tessera"}}}});
  heard(1, "document");
  say(1, {{"open", {{"file", "a.tessera"}}}});
  EXPECT_EQ(heard(1, "document").at(0)["text"], "1\ntwo\n");
}

TEST_F(StudioDocuments, ATextThatIsReadAnewIsSentToWhoLacksItAlone) {
  const auto have = [](const std::string& text) {
    const std::string hash = sha256_hex(std::as_bytes(std::span(text)));
    return Json{{"hello", {{"token", "right"}, {"have", {{"a.tessera", {7, hash}}}}}}};
  };
  session_.connect(1, now_);
  say(1, have("one\ntwo\n"));
  EXPECT_EQ(heard(1, "edited").at(0)["version"], 1);
  EXPECT_TRUE(heard(1, "document").empty());
  session_.disconnect(1);
  session_.connect(2, now_);
  say(2, have("another\n"));
  EXPECT_EQ(heard(2, "document").at(0)["text"], "one\ntwo\n");
}

TEST_F(StudioDocuments, TextsThatAreOpenStandForFilesWhereScenesAreRead) {
  connect(1);
  say(1, {{"open", {{"file", "a.tessera"}}}});
  say(1, {{"view", {{"pane", 0}, {"file", "a.tessera"}, {"size", {64, 32}}}}});
  ASSERT_EQ(reads_.size(), 1u);
  EXPECT_EQ(reads_[0].texts.at("a.tessera").text(), "one\ntwo\n");
  say(1, edit(1, {{0, 3, "1"}}));
  ASSERT_EQ(reads_.size(), 2u);
  EXPECT_EQ(reads_[1].texts.at("a.tessera").text(), "1\ntwo\n");
  EXPECT_GT(reads_[1].revision, reads_[0].revision);
}

TEST_F(StudioDocuments, PagesThatComeAndGoOpenAFileOnce) {
  size_t opened = 0;
  for (ClientId client = 1; client <= 50; ++client) {
    session_.connect(client, now_);
    session_.receive(client, R"({"hello": {"token": "right"}})", now_);
    session_.receive(client, R"({"open": {"file": "a.tessera"}})", now_);
    session_.disconnect(client);
    for (const StudioOrder& order : session_.tick(now_)) {
      const auto* const task = std::get_if<FileTask>(&order);
      opened += task && std::holds_alternative<OpenFile>(*task);
    }
  }
  EXPECT_EQ(opened, 1u);
  disk_.carry_out(OpenFile{1, "a.tessera"}, session_);
  now_ += seconds(1);
  connect(99);
  say(99, {{"open", {{"file", "a.tessera"}}}});
  EXPECT_EQ(heard(99, "document").size(), 1u);
}

}  // namespace
}  // namespace tessera
