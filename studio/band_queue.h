#pragma once

#include <cstdint>
#include <deque>
#include <functional>
#include <memory>
#include <string>
#include <vector>

#include "studio/pixel_frame.h"

namespace tessera {

/// What a page reads pixels by. Its functions may be called by any thread.
class PixelSink {
 public:
  virtual ~PixelSink() = default;
  /// Returns false where it is full: what was to be sent is dropped.
  virtual bool send(std::shared_ptr<const std::string> frame) = 0;
};

/// Pictures on their way to one page, in bands of rows that its sink has room for. Used by one
/// thread.
class BandQueue {
 public:
  /// Of a band's pixels before they are deflated, but for one row that is longer.
  static constexpr size_t kMostBytes = size_t{4} << 20;

  /// Gives the pixels of a part of the picture, four bytes each.
  using Pixels = std::function<std::vector<uint8_t>(const PixelRect&)>;

  /// Appends that piece of a picture. Its flags are those of its last band; `pixels` is called when
  /// a band is sent.
  void add(const PixelFrame& frame, const Pixels& pixels, bool deflate);
  void clear();
  bool empty() const { return bands_.empty(); }
  /// Sends what the sink takes, from where it was full; a null one takes all. Returns whether
  /// nothing is left.
  bool send(PixelSink* sink);

 private:
  struct Band {
    PixelFrame frame;
    Pixels pixels;
    bool deflate = false;
  };
  std::deque<Band> bands_;
  std::shared_ptr<const std::string> encoded_;  ///< the first band, which found no room
};

/// The pixels of a picture of that width, which begins in the topmost row, out of all its bytes.
BandQueue::Pixels pixels_of(std::vector<uint8_t> bytes, int width);

}  // namespace tessera
