#pragma once

#include <compare>
#include <cstdint>
#include <map>
#include <memory>
#include <nlohmann/json.hpp>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "base/monotonic.h"
#include "studio/live_view.h"
#include "studio/page_message.h"
#include "studio/reading_log.h"
#include "studio/scene_reading.h"
#include "studio/studio_orders.h"

namespace tessera {

/// The panes of all pages: the scenes that they show, and the passes traced for them. A state
/// machine like OpenDocuments. Not thread-safe.
class LiveViews {
 public:
  /// `orders` is where orders are put; it must outlive this. `folder`: the opened one; `samples`:
  /// that of the samples.
  LiveViews(StudioOrders& orders, std::string folder, std::string samples, bool deflate)
      : orders_(orders),
        folder_(std::move(folder)),
        samples_(std::move(samples)),
        deflate_(deflate) {}

  void set(ClientId client, const page::View& wish, Time now);
  void order(ClientId client, const page::PaneOrder& order);
  void leave(ClientId client);
  void note_saved();

  /// The texts are others: scenes that are shown are read anew. To be called before order() and
  /// note_saved(), which ask for the picture of what the texts are by then.
  void set_texts(uint64_t revision, const OpenTexts& texts);
  void take(std::shared_ptr<const SceneReading> reading, Time now);
  void take(const PassEnd& end);
  void take(uint32_t serial, const JobProgress& progress);
  void take(const OutputRefused& refused);
  /// Pages that asked for it are told which workers traced the tiles.
  void take(const PassTiles& tiles);

  /// What a pane shows, for passes beside its own.
  struct Seen {
    std::shared_ptr<const SceneReading> reading;
    std::shared_ptr<const RenderOptions> options;
    std::optional<FreeCamera> camera;
    int width = 0, height = 0;
  };
  /// Nothing where it shows nothing yet.
  std::optional<Seen> seen(const ViewId& id) const;
  /// For a pass beside those of the views.
  uint32_t new_serial() { return ++*serial_; }
  /// The scene of that file as a pane of the client shows it, of several the first one, as it was
  /// read last without errors; null: there is none.
  std::shared_ptr<const SceneReading> reading_of(ClientId client, const std::string& file) const;

  /// Orders what is due.
  void tick(Time now);
  Time deadline() const { return deadline_; }

 private:
  /// Which scene a pane shows.
  struct SceneKey {
    std::string file;
    int frame = 0;
    bool is_sample = false;
    ViewFilter filter{};
    friend auto operator<=>(const SceneKey&, const SceneKey&) = default;
  };
  struct ReadScene {
    std::shared_ptr<const SceneReading> last;  ///< null: not read yet
    std::shared_ptr<const SceneReading> good;  ///< the last one without errors
    uint64_t asked = 0;                        ///< revision that is or was read
    std::string failure{}, failed_digest{};    ///< as of ReadOrder
  };
  struct Pane {
    explicit Pane(std::shared_ptr<uint32_t> serial) : view(std::move(serial)) {}
    LiveView view;
    page::View wish;
    std::shared_ptr<const RenderOptions> options;
    std::string settings;  ///< of ViewLook
    OutputSettings output;
    ViewChannel channel = ViewChannel::light;
    bool shows_cost = false;  ///< of PassPicture
    /// Films have all values beside light from when any was asked for, so that another one can be
    /// shown at once.
    bool has_aovs = false;
    /// By the running or last pass: of the texts that make its scene, those read last.
    std::shared_ptr<const SceneReading> shown{};
    std::string told{};        ///< state, so that each is told once
    std::string why_failed{};  ///< of the last failure
    /// Why what is there is not shown as it is asked for; empty: it is.
    std::string output_fault{};
    /// Why the picture is that of an earlier text, and when that was read; null: it is not.
    nlohmann::json stale{};
    /// Of the texts whose picture was asked for, by an order or by saving, before they were read.
    std::optional<uint64_t> asked_for{};
  };

  static SceneKey key_of(const page::View& wish) {
    return {wish.file, wish.frame, wish.is_sample, wish.filter};
  }
  static SceneKey key_of(const Pane& pane) { return key_of(pane.wish); }
  void ask_for(const SceneKey& key);
  void read(const SceneKey& key);
  /// Gives the view what there is of its scene, and tells the page where it cannot be shown.
  void show_scene(const ViewId& id, Pane& pane, Time now);
  /// Goes on with what was paused or stopped.
  void resume(const ViewId& id, Pane& pane);
  /// The picture of the texts as they are now is asked for.
  void note_asked(Pane& pane);
  void carry_out(const ViewId& id, Pane& pane, Time now);
  void tell(const ViewId& id, Pane& pane, std::string_view state, nlohmann::json more);
  /// Of Pane.
  static nlohmann::json stale_json(const ReadScene& scene);
  void tell_reading(ClientId client, const SceneReading& reading);
  void drop_unused_scenes();
  Pane* pane_of(uint32_t serial, ViewId& id);

  StudioOrders& orders_;
  std::string folder_, samples_;
  bool deflate_;
  std::shared_ptr<uint32_t> serial_ = std::make_shared<uint32_t>(0);
  std::map<ViewId, Pane> panes_;
  std::map<SceneKey, ReadScene> scenes_;
  uint64_t revision_ = 0;
  OpenTexts texts_;
  ReadingLog log_;
  Time deadline_ = Time::max();
};

}  // namespace tessera
