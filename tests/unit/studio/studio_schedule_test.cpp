#include <fmt/format.h>
#include <gtest/gtest.h>

#include <cstdlib>
#include <deque>
#include <nlohmann/json.hpp>
#include <random>
#include <set>

#include "studio/scene_reading.h"
#include "studio/studio_session.h"
#include "tests/unit/studio/fake_disk.h"

// Thousands of orders in which keys, readings, passes, moves of the camera, losses of connections
// and returns can meet.

namespace tessera {
namespace {

using Json = nlohmann::json;
using std::chrono::milliseconds;

constexpr char kFile[] = "a.tessera";
const std::string kBegin = "nodes { shape { sphere { radius: 0.", kEnd = " } } }\n";

/// What a page knows: the text as it stands in its editor, and what of it the program has
/// acknowledged.
struct FakePage {
  ClientId client = 0;  ///< 0: not connected
  std::string id{};
  std::string text{};
  uint64_t version = 0;  ///< of the text, once all that was sent has come
  bool is_open = false, edits = false;
  std::deque<Json> sent{};  ///< and not come yet
  std::set<uint32_t> panes{};
};

class Schedule {
 public:
  explicit Schedule(uint64_t seed) : random_(seed) {}

  void play() {
    for (FakePage& page : pages_) connect(page);
    for (int step = 0; step < 80; ++step) {
      step_at_random();
      act();
      if (testing::Test::HasFailure()) return;
    }
    settle();
    check_end();
  }

 private:
  size_t draw(size_t below) { return random_() % below; }

  void step_at_random() {
    FakePage& page = pages_[draw(pages_.size())];
    switch (draw(12)) {
      case 0:
      case 1:
      case 2:
        return type(page);
      case 3:
        return look(page);
      case 4:
        return deliver(page, 1 + draw(3));
      case 5:
        return end_reading();
      case 6:
      case 7:
        return end_pass();
      case 8:
        now_ += milliseconds(draw(400));
        return;
      case 9:
        return page.client == 0 ? connect(page) : lose(page);
      case 10:
        if (page.client != 0 && page.is_open) say(page, "take_over", {{"file", kFile}});
        return;
      default:
        return order_pane(page);
    }
  }

  // ------------------------------------------------------------------------------------- a page

  void say(FakePage& page, const char* kind, Json fields) {
    page.sent.push_back({{kind, std::move(fields)}});
  }
  void deliver(FakePage& page, size_t most) {
    for (; most > 0 && !page.sent.empty() && page.client != 0; --most) {
      const std::string message = page.sent.front().dump();
      page.sent.pop_front();
      session_.receive(page.client, message, now_);
      act();
    }
  }
  void connect(FakePage& page) {
    page.client = ++last_client_;
    session_.connect(page.client, now_);
    Json hello{{"token", "right"}};
    if (page.is_open) {
      hello["resume"] = page.id;
      hello["have"] = {{kFile, {page.version, Digest::of(page.text).hex()}}};
    }
    session_.receive(page.client, Json{{"hello", hello}}.dump(), now_);
    act();
    if (!page.is_open) say(page, "open", {{"file", kFile}});
    for (const uint32_t pane : page.panes) show(page, pane);
  }
  /// The connection is cut, with whatever was on its way.
  void lose(FakePage& page) {
    session_.disconnect(page.client);
    page.client = 0;
    page.sent.clear();
  }
  /// A key: the number becomes another one, or none, or a comment grows.
  void type(FakePage& page) {
    if (!page.is_open || !page.edits) return;
    const size_t kind = draw(8);
    size_t from = kBegin.size(), to = from + 2;
    std::string text = fmt::format("{:02}", draw(100));
    if (kind == 0) text = "x!";
    if (kind == 1) {
      from = to = page.text.size();
      text = "#\n";
    }
    if (page.client != 0) {
      say(page, "edit", {{"file", kFile}, {"base", page.version}, {"changes", {{from, to, text}}}});
    }
    page.text.replace(from, to - from, text);
    ++page.version;
  }
  void show(FakePage& page, uint32_t pane) {
    Json view{{"pane", pane},
              {"file", kFile},
              {"size", {64 + 64 * draw(4), 64}},
              {"overrides", {{"spp", 1 + draw(20)}}}};
    if (draw(3) == 0) {
      view["moving"] = draw(2) == 0;
      view["camera"] = {
          {"eye", {0, 0, 3 + draw(5)}}, {"target", {0, 0, 0}}, {"up", {0, 1, 0}}, {"fov", 40}};
    }
    say(page, "view", std::move(view));
  }
  void look(FakePage& page) {
    if (page.client == 0) return;
    const auto pane = static_cast<uint32_t>(draw(2));
    page.panes.insert(pane);
    show(page, pane);
  }
  void order_pane(FakePage& page) {
    if (page.client == 0 || page.panes.empty()) return;
    const uint32_t pane = *page.panes.begin();
    static constexpr const char* kOrders[] = {"pause", "resume", "stop", "refresh", "close_view"};
    const char* const what = kOrders[draw(std::size(kOrders))];
    if (what == kOrders[4]) page.panes.erase(pane);
    say(page, what, {{"pane", pane}});
  }

  void hear(FakePage& page, const std::string& kind, const Json& fields) {
    if (kind == "welcome") page.id = fields["id"];
    if (kind == "document") hear_document(page, fields);
    if (kind == "edited") {
      EXPECT_LE(fields["version"], page.version) << "an edit that was never made";
      if (fields.contains("read_only")) page.edits = !fields["read_only"].get<bool>();
    }
    if (kind == "change") {
      ASSERT_FALSE(page.edits) << "two pages edit one text";
      ASSERT_EQ(fields["base"], page.version);
      for (const Json& change : fields["changes"]) {
        const size_t from = change[0], to = change[1];
        page.text.replace(from, to - from, change[2].get<std::string>());
      }
      ++page.version;
    }
    if (kind == "job")
      is_told_stale_[{page.client, fields["pane"].get<uint32_t>()}] = fields.contains("stale");
    EXPECT_NE(kind, "refused") << fields;
  }
  void hear_document(FakePage& page, const Json& fields) {
    const std::string theirs = fields["text"];
    const bool had_keys = page.is_open && page.edits && page.text != theirs;
    page.version = fields["version"];
    page.edits = !fields["read_only"].get<bool>();
    // Edits of another version come to nothing.
    std::erase_if(page.sent, [](const Json& message) { return message.contains("edit"); });
    if (had_keys && page.edits) {
      say(page, "edit",
          {{"file", kFile}, {"base", page.version}, {"changes", {{0, theirs.size(), page.text}}}});
      ++page.version;
    } else {
      page.text = theirs;
    }
    page.is_open = true;
  }

  // ------------------------------------------------------------------- the threads of the program

  void act() {
    disk_.carry_out_all(session_, now_, [this](StudioOrder& order) {
      handle(order);
      return false;
    });
    EXPECT_GT(session_.deadline(), now_) << "what is due was not done";
  }
  void handle(StudioOrder& order) {
    if (const auto* const text = std::get_if<SendText>(&order)) {
      const Json message = Json::parse(text->text);
      for (FakePage& page : pages_) {
        if (page.client == text->client) hear(page, message.begin().key(), message.begin().value());
      }
    } else if (const auto* const close = std::get_if<CloseClient>(&order)) {
      for (FakePage& page : pages_) {
        if (page.client == close->client) lose(page);
      }
    } else if (auto* const read = std::get_if<ReadOrder>(&order)) {
      // Of texts that wait to be read, the newest is enough.
      std::erase_if(reads_, [&](const ReadOrder& each) { return each.frame == read->frame; });
      reads_.push_back(std::move(*read));
    } else if (auto* const pass = std::get_if<TracePass>(&order)) {
      begin_pass(*pass);
    } else if (const auto* const end = std::get_if<EndPass>(&order)) {
      EXPECT_EQ(passes_.erase(end->serial), 1u) << "a pass is ended that does not run";
    } else if (const auto* const gone = std::get_if<ForgetView>(&order)) {
      shown_.erase(gone->view);
      is_told_stale_.erase(gone->view);
    }
  }
  void begin_pass(const TracePass& pass) {
    Shown& shown = shown_[pass.view];
    EXPECT_FALSE(passes_.contains(shown.serial)) << "two passes for one pane";
    EXPECT_GT(pass.picture.serial, shown.serial);
    EXPECT_GE(pass.picture.version, shown.version) << "an older picture after a newer";
    shown = {pass.picture.serial, pass.picture.version, pass.order.reading, false,
             pass.picture.is_last};
    passes_[pass.picture.serial] = pass.view;
  }
  void end_reading() {
    if (reads_.empty()) return;
    const ReadOrder order = reads_.front();
    reads_.pop_front();
    session_.take(
        std::make_shared<const SceneReading>(read_for_studio(order, {.folder = "/nowhere"})), now_);
  }
  void end_pass() {
    if (passes_.empty()) return;
    const auto pass = *std::next(passes_.begin(), static_cast<ptrdiff_t>(draw(passes_.size())));
    passes_.erase(pass.first);
    shown_[pass.second].is_done = true;
    PassEnd end{
        .serial = pass.first, .overhead = 0.001, .trace = 0.001 * static_cast<double>(draw(200))};
    if (draw(20) == 0) {
      end.how = PassEnd::How::failed;
      end.why = render_error("a worker was lost");
    }
    session_.take(end);
  }

  // -------------------------------------------------------------------------------------- the end

  /// Nobody does anything any more, and all that is under way ends.
  void settle() {
    for (FakePage& page : pages_) {
      if (page.client == 0) connect(page);
      deliver(page, 1000);
      for (const uint32_t pane : page.panes) say(page, "refresh", {{"pane", pane}});
    }
    for (int round = 0; round < 1000; ++round) {
      for (FakePage& page : pages_) deliver(page, 1000);
      end_reading();
      end_pass();
      now_ += milliseconds(100);
      act();
      if (testing::Test::HasFailure()) return;
    }
  }
  void check_end() {
    EXPECT_TRUE(passes_.empty() && reads_.empty());
    const std::string* text = nullptr;
    size_t editors = 0;
    for (const FakePage& page : pages_) {
      editors += page.edits ? 1 : 0;
      if (!text) text = &page.text;
      EXPECT_EQ(page.text, *text) << "pages have other texts";
    }
    EXPECT_EQ(editors, 1u);
    const SceneReading now =
        read_for_studio({.file = kFile, .revision = 1, .texts = {{kFile, Document(*text)}}},
                        {.folder = "/nowhere"});
    for (const auto& [view, is_stale] : is_told_stale_) EXPECT_EQ(is_stale, !now.scene);
    if (!now.scene) return;  // the last good picture stays
    for (const FakePage& page : pages_) EXPECT_EQ(page.panes.size(), panes_of(page.client));
    for (const auto& [view, shown] : shown_) {
      EXPECT_TRUE(shown.is_done);
      ASSERT_TRUE(shown.reading && shown.reading->scene);
      EXPECT_EQ(shown.reading->scene->digest, now.scene->digest) << "the last text does not win";
    }
  }
  size_t panes_of(ClientId client) const {
    return static_cast<size_t>(std::count_if(shown_.begin(), shown_.end(), [&](const auto& each) {
      return each.first.client == client;
    }));
  }

  struct Shown {
    uint32_t serial = 0, version = 0;
    std::shared_ptr<const SceneReading> reading{};
    bool is_done = false, is_last = false;
  };

  std::mt19937_64 random_;
  Time now_ = std::chrono::seconds(1000);
  FakeDisk disk_{{{kFile, kBegin + "50" + kEnd}}};
  StudioSession session_{{.folder = "/nowhere", .file = "", .version = "1", .settings = "{}"},
                         [](const std::string&) { return StudioRole::editor; }};
  ClientId last_client_ = 0;
  std::vector<FakePage> pages_{3};
  std::deque<ReadOrder> reads_;
  std::map<uint32_t, ViewId> passes_;  ///< by serial
  std::map<ViewId, Shown> shown_;
  std::map<ViewId, bool> is_told_stale_;  ///< by the last message of the pane's job
};

/// Schedules of 2,000 seeds, an eighth in each test.
class StudioSchedules : public testing::TestWithParam<uint64_t> {};
INSTANTIATE_TEST_SUITE_P(Seeds, StudioSchedules, testing::Range<uint64_t>(0, 8));

TEST_P(StudioSchedules, AllEndWithTheLastText) {
  constexpr uint64_t kSeeds = 250;
  const char* const one = std::getenv("TESSERA_STUDIO_SEED");
  const uint64_t first = one ? std::strtoull(one, nullptr, 10) : 1 + kSeeds * GetParam();
  for (uint64_t seed = first; seed < first + (one ? 1 : kSeeds); ++seed) {
    Schedule(seed).play();
    ASSERT_FALSE(HasFailure()) << "TESSERA_STUDIO_SEED=" << seed << " plays it again";
  }
}

}  // namespace
}  // namespace tessera
