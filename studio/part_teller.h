#pragma once

#include <functional>
#include <memory>
#include <string>

#include "studio/picture_stream.h"
#include "studio/source_map.h"
#include "studio/studio_orders.h"

namespace tessera {

/// Tells pages what in the texts made what pictures show, and where that is. Used by one thread, as
/// it keeps the map of the reading that was asked about last.
class PartTeller {
 public:
  /// `folder`: the opened one. `send` is called with what pages are told.
  PartTeller(std::string folder, PictureStream::Sinks sink_of, std::function<void(SendText)> send)
      : folder_(std::move(folder)), sink_of_(std::move(sink_of)), send_(std::move(send)) {}

  /// Both return what catch_up() does.
  bool tell(const TellParts& order);
  bool tell(const TellCenters& order);
  /// Sends what pages had no room for. Returns whether any still waits.
  bool catch_up() { return tessera::catch_up(waiting_, sink_of_); }

 private:
  SourceMap& map_of(const std::shared_ptr<const SceneReading>& reading);

  std::string folder_;
  PictureStream::Sinks sink_of_;
  std::function<void(SendText)> send_;
  std::unique_ptr<SourceMap> map_;
  WaitingBands waiting_;  ///< of part pictures
};

}  // namespace tessera
