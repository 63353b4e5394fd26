#pragma once

#include <cstdint>
#include <functional>
#include <map>
#include <memory>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "renderer/film/film.h"
#include "renderer/film/tone_map.h"
#include "studio/band_queue.h"
#include "studio/channel_view.h"
#include "studio/file_tasks.h"
#include "studio/ladder.h"
#include "studio/page_message.h"
#include "studio/pass_runner.h"

namespace tessera {

/// A pane of a page.
struct ViewId {
  ClientId client = 0;
  uint32_t pane = 0;
  friend auto operator<=>(const ViewId&, const ViewId&) = default;
};

/// A pass whose pixels are about to come.
struct PassPicture {
  uint32_t serial = 0;
  ViewPass pass;
  bool is_last = false;
  bool shows_cost = false;  ///< its light counts what rays cost
  uint32_t version = 0;     ///< of the text
  bool deflate = false;
  std::string scene{};        ///< its digest
  int width = 0, height = 0;  ///< of the pane
};

using WaitingBands = std::map<ViewId, BandQueue>;
/// Sends what the pages take of it. Returns whether any still waits.
bool catch_up(WaitingBands& waiting,
              const std::function<std::shared_ptr<PixelSink>(ClientId)>& sink_of);

/// Holds the film that each view shows, and makes the pixels for its page of it: each tile as it
/// comes, all of it when the tone changes, and once a page that was too slow has caught up. Used by
/// one thread.
class PictureStream {
 public:
  using Sinks = std::function<std::shared_ptr<PixelSink>(ClientId)>;
  using LegendCallback = std::function<void(const ViewId&, const Legend&)>;
  /// `sink_of` gives null for a page that is gone. `tell` is called where a view has another
  /// legend.
  explicit PictureStream(Sinks sink_of, LegendCallback tell = {})
      : sink_of_(std::move(sink_of)), tell_(std::move(tell)) {}

  /// From now on tiles of that pass are shown there, and none of another.
  void begin(const ViewId& view, const PassPicture& picture);
  /// Nothing happens where it is not the view's pass.
  void add(const ViewId& view, const PassTiles& tiles);
  /// The pass is whole, and its picture is of that frame.
  void finish(const ViewId& view, uint32_t serial, std::shared_ptr<const Film> film,
              std::shared_ptr<const FullFrame> frame = {});
  /// Shows what there is, and what comes, by other settings.
  void set_output(const ViewId& view, const OutputSettings& output, ViewChannel channel);
  void forget(const ViewId& view);
  void forget(ClientId client);
  /// Sends what pages had no room for. Returns whether any still waits.
  bool catch_up();

  /// What is seen at a pixel of the pane; nothing where that is not known, as nothing is there yet
  /// or what is there was of a pass that was given up.
  struct Value {
    std::vector<std::string> channels;
    std::vector<float> values;
    std::vector<int> shown;  ///< 0 to 255: red, green, blue
  };
  std::optional<Value> value_at(const ViewId& view, int x, int y) const;
  /// Pins a picture of the view, in place of one that was pinned before, and sends it. Returns the
  /// film; null where there is none of that kind. `none` unpins.
  std::shared_ptr<const Film> pin(const ViewId& view, page::Pin::What what);
  /// The pinned picture and the last whole one, with the pass of that; nothing without both.
  struct Pair {
    std::shared_ptr<const Film> pinned, shown;
    uint32_t serial = 0;
  };
  std::optional<Pair> pair(const ViewId& view) const;

  /// The picture that was last shown whole, what it is of, and how it is shown now.
  struct Whole {
    std::shared_ptr<const Film> film{};  ///< null: there is none yet
    std::shared_ptr<const FullFrame> frame{};
    OutputSettings output{};
  };
  Whole whole(const ViewId& view) const;

 private:
  struct Shown {
    OutputSettings output;
    ViewChannel channel = ViewChannel::light;
    PassPicture picture;
    std::optional<Film> film;     ///< of the pass, as far as it has come
    std::vector<PixelRect> done;  ///< tiles that it has
    bool is_torn = false;  ///< tiles of passes that were given up are seen over the whole picture
    std::shared_ptr<const Film> whole;  ///< of the last pass that ended
    PassPicture of_whole;
    std::shared_ptr<const FullFrame> frame_of_whole;
    std::shared_ptr<const Film> before;  ///< the last one of the scene as it was before
    std::shared_ptr<const Film> pinned;
    BandQueue waiting;         ///< of the picture
    BandQueue pinned_waiting;  ///< of what is pinned
    uint32_t last_sent = 0;    ///< the serial of the last piece
    Legend legend;             ///< by which its pixels are coloured
    bool is_told = false;      ///< of the legend

    /// What is shown of a pass.
    ViewChannel channel_of(const PassPicture& pass) const {
      return channel == ViewChannel::light && pass.shows_cost ? ViewChannel::cost : channel;
    }
  };
  /// Whether the legend is another one from now on.
  bool renew_legend(const ViewId& view, Shown& shown);
  /// What is seen: the last whole picture, and over it the tiles of the pass that is being traced.
  enum class Layer { whole, pass };
  /// Adds a piece of a layer to what waits to be sent. Without flags it is sent as one of the pass
  /// that is being traced, whose pixels may still come.
  static void add_piece(const ViewId& view, Shown& shown, Layer layer, const PixelRect& rect,
                        uint16_t flags);
  /// Nothing is seen any more.
  static void add_nothing(const ViewId& view, Shown& shown);
  /// All that is seen; tiles of passes that were given up are seen no longer.
  static void add_all(const ViewId& view, Shown& shown);
  void add_pinned(const ViewId& view, Shown& shown) const;
  /// Returns whether nothing waits any more.
  bool send(const ViewId& view, Shown& shown) const;

  Sinks sink_of_;
  LegendCallback tell_;
  std::map<ViewId, Shown> views_;
  uint32_t last_pin_ = 0;  ///< by which pinned pictures are told from those before
};

}  // namespace tessera
