#pragma once

#include <gtest/gtest.h>

#include <chrono>
#include <map>
#include <nlohmann/json.hpp>
#include <string>
#include <utility>
#include <vector>

#include "studio/studio_session.h"
#include "tests/unit/studio/fake_disk.h"

namespace tessera {

/// A studio whose files are in memory, and whose scenes are never traced.
class StudioSessionCase : public testing::Test {
 protected:
  using Json = nlohmann::json;
  using milliseconds = std::chrono::milliseconds;
  using seconds = std::chrono::seconds;

  /// Page 1 has the file open, and is told that another program has changed it.
  void open_and_change_on_disk() {
    connect(1);
    say(1, {{"open", {{"file", "a.tessera"}}}});
    disk_.files["a.tessera"] = "theirs\n";
    now_ += seconds(5);
    act();
    EXPECT_EQ(heard(1, "disk").at(0)["text"], "theirs\n");
  }
  void connect(ClientId client, const std::string& token = "right") {
    session_.connect(client, now_);
    say(client, {{"hello", {{"token", token}}}});
  }
  void say(ClientId client, const Json& message) {
    session_.receive(client, message.dump(), now_);
    act();
  }
  /// Carries out what was ordered, files at once.
  void act() {
    disk_.carry_out_all(session_, now_, [this](StudioOrder& order) {
      if (auto* const text = std::get_if<SendText>(&order)) {
        told_[text->client].push_back(Json::parse(text->text));
      } else if (auto* const close = std::get_if<CloseClient>(&order)) {
        closed_[close->client] = close->code;
      } else if (auto* const read = std::get_if<ReadOrder>(&order)) {
        reads_.push_back(*read);
      }
      return false;
    });
  }
  /// The messages of that kind, which are forgotten.
  std::vector<Json> heard(ClientId client, const std::string& kind) {
    std::vector<Json> found;
    std::erase_if(told_[client], [&](const Json& message) {
      if (!message.contains(kind)) return false;
      found.push_back(message[kind]);
      return true;
    });
    return found;
  }
  Json edit(uint64_t base, Json changes) {
    return {{"edit", {{"file", "a.tessera"}, {"base", base}, {"changes", std::move(changes)}}}};
  }

  Time now_ = seconds(1000);
  FakeDisk disk_{{{"a.tessera", "one\ntwo\n"}}};
  std::map<ClientId, std::vector<Json>> told_;
  std::map<ClientId, uint16_t> closed_;
  std::vector<ReadOrder> reads_;
  StudioSession session_{
      {.folder = "/f", .file = "", .version = "1", .settings = "{}", .samples_folder = "/s"},
      [](const std::string& token) {
        return token == "right" ? StudioRole::editor
               : token == "see" ? StudioRole::viewer
                                : StudioRole::none;
      }};
};

}  // namespace tessera
