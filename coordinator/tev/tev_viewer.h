#pragma once

#include <cstdint>
#include <map>
#include <string>
#include <utility>
#include <vector>

#include "base/monotonic.h"
#include "coordinator/jobs/farm_snapshot.h"
#include "coordinator/tev/tev_link.h"
#include "renderer/film/film.h"

namespace tessera {

class Coordinator;

/// Shows frames in the viewer tev while they are traced: an image a frame, each tile as soon as it
/// is done. Used by the coordinator's thread. A tile that the viewer cannot take now is offered
/// again later.
class TevViewer {
 public:
  /// As TevLink.
  explicit TevViewer(const std::string& address) : link_(address) {}

  /// To be called often: sends what is new, ten times a second at most, and in at most a fiftieth
  /// of the thread's time.
  void look(Coordinator& coordinator, Time now);
  /// The film of the frame of this process that was looked at last, now that it has ended.
  void finish(const Film& film);

 private:
  struct Shown {
    std::string name;
    bool created = false;
    std::vector<PixelRect> tiles;
    std::vector<bool> sent;  ///< by tile
    std::vector<bool> done;
  };
  using FrameKey = std::pair<uint64_t, uint32_t>;

  void show_running(Coordinator& coordinator, Time now);
  /// What was not sent before they ended.
  void show_ended(Coordinator& coordinator);
  /// True once all that is done is sent.
  bool send(Shown& shown, const FilmView& film);

  TevLink link_;
  uint64_t connections_ = 0;
  Time next_look_{};
  std::map<FrameKey, Shown> frames_;
};

}  // namespace tessera
