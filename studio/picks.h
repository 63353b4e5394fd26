#pragma once

#include <cstdint>
#include <map>
#include <memory>
#include <string>
#include <vector>

#include "renderer/film/film.h"
#include "studio/live_views.h"
#include "studio/page_message.h"
#include "studio/pixel_frame.h"
#include "studio/source_map.h"
#include "studio/studio_orders.h"

namespace tessera {

/// Which parts of the scene pages ask for: those of one pixel, or of all. Orders the passes that
/// tell it, which go ahead of all others. A state machine like OpenDocuments. Not thread-safe.
class Picks {
 public:
  Picks(StudioOrders& orders, bool deflate) : orders_(orders), deflate_(deflate) {}

  void pick(ClientId client, const page::Pick& pick, LiveViews& views);
  void parts(ClientId client, const page::Parts& parts, LiveViews& views);
  void take(const PassEnd& end);
  void leave(ClientId client);

 private:
  void ask(PartQuestion question, const LiveViews::Seen& seen, const PixelRect& crop, int priority,
           LiveViews& views);

  StudioOrders& orders_;
  const bool deflate_;
  std::map<uint32_t, PartQuestion> asked_;  ///< by serial
};

/// The answer for the page to what was picked. The film is of one pixel.
SendText picked_answer(const PartQuestion& question, const Film& film, SourceMap& map);

/// The part picture: a number for each part, 0 for none, and the chains of the parts.
struct PartPicture {
  PixelFrame frame;
  std::vector<uint8_t> numbers;  ///< its pixels, little-endian
  SendText chains;               ///< is to be sent before it
};
PartPicture part_picture(const PartQuestion& question, const Film& film, SourceMap& map);

/// By the channels of a film with origins.
ScenePart part_at(const Film& film, int x, int y);

}  // namespace tessera
