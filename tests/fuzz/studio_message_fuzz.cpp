// Whatever pages say, and whenever what they asked for ends: the studio throws nothing, answers in
// JSON, and ends no pass that does not run. A line is a step: a digit and the message of that page,
// or one of the letters below.
#include <cstddef>
#include <cstdint>
#include <cstdlib>
#include <map>
#include <memory>
#include <nlohmann/json.hpp>
#include <set>
#include <string_view>
#include <vector>

#include "studio/scene_reading.h"
#include "studio/source_reader.h"
#include "studio/studio_session.h"
#include "tests/unit/studio/fake_disk.h"

namespace {

using namespace tessera;

class Player {
 public:
  void step(std::string_view line) {
    if (line.empty()) return;
    const char what = line[0];
    const ClientId client = line.size() > 1 ? static_cast<unsigned char>(line[1]) % 4 : 0;
    if (what >= '0' && what <= '3') {
      session_.receive(static_cast<ClientId>(what - '0'), line.substr(1), now_);
    } else if (what == 'c') {
      session_.connect(client, now_);
    } else if (what == 'd') {
      session_.disconnect(client);
    } else if (what == 't') {
      now_ += std::chrono::milliseconds(100 * (1 + client));
    } else if (what == 'r' && !reads_.empty()) {
      const ReadOrder order = reads_.back();
      reads_.pop_back();
      session_.take(
          std::make_shared<const SceneReading>(read_for_studio(order, {.folder = "/nowhere"})),
          now_);
    } else if (what == 'p' && !passes_.empty()) {
      PassEnd end{.serial = *passes_.begin(), .overhead = 0.001, .trace = 0.01};
      if (client == 3) {
        end.how = PassEnd::How::failed;
        end.why = scene_error("it cannot be built");
      }
      passes_.erase(passes_.begin());
      session_.take(end);
    }
    act();
  }

 private:
  void act() {
    disk_.carry_out_all(session_, now_, [this](StudioOrder& order) { return handle(order); });
    if (session_.deadline() <= now_) std::abort();
  }
  bool handle(StudioOrder& order) {
    if (const auto* const text = std::get_if<SendText>(&order)) {
      check(*text);
    } else if (auto* const read = std::get_if<ReadOrder>(&order)) {
      reads_.push_back(std::move(*read));
    } else if (const auto* const source = std::get_if<SourceOrder>(&order)) {
      check(reader_.answer(*source));
      session_.take(RequestDone{{source->client, page::name_of(source->request.what)}});
      return true;
    } else if (const auto* const outline = std::get_if<OutlineOrder>(&order)) {
      session_.take(std::make_shared<const FileOutline>(reader_.outline(*outline)));
      return true;
    } else if (const auto* const pass = std::get_if<TracePass>(&order)) {
      passes_.insert(pass->order.serial);
    } else if (const auto* const aside = std::get_if<TraceAside>(&order)) {
      passes_.insert(aside->order.serial);
    } else if (const auto* const end = std::get_if<EndPass>(&order)) {
      if (passes_.erase(end->serial) == 0) std::abort();
    }
    return false;
  }
  static void check(const SendText& text) {
    const auto message = nlohmann::json::parse(text.text);
    if (!message.is_object() || message.size() != 1) std::abort();
  }

  Time now_ = std::chrono::seconds(1000);
  FakeDisk disk_{{{"a.tessera", "nodes { shape { sphere { radius: 0.5 } } }\n"}}};
  StudioSession session_{{.folder = "/nowhere", .file = "", .version = "1", .settings = "{}"},
                         [](const std::string& token) {
                           return token == "t" ? StudioRole::editor : StudioRole::none;
                         }};
  SourceReader reader_;
  std::vector<ReadOrder> reads_;
  std::set<uint32_t> passes_;
};

}  // namespace

extern "C" int LLVMFuzzerTestOneInput(const uint8_t* data, size_t size) {
  std::string_view text(reinterpret_cast<const char*>(data), size);
  Player player;
  for (size_t end = 0; end != text.npos; text.remove_prefix(std::min(text.size(), end + 1))) {
    end = text.find('\n');
    player.step(text.substr(0, end));
    if (end == text.npos) break;
  }
  return 0;
}
