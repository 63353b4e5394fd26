#pragma once

#include <map>
#include <optional>
#include <string>
#include <utility>

#include "studio/studio_orders.h"

namespace tessera {

/// What pages ask that other threads take a while for. Of each kind a page has one request under
/// way, and behind it the newest alone: however many it sends, no more work piles up. A state
/// machine like OpenDocuments. Not thread-safe.
class LatestRequests {
 public:
  /// `orders` is where orders are put; it must outlive this.
  explicit LatestRequests(StudioOrders& orders) : orders_(orders) {}

  /// Orders it, at once or when the one that is under way is done. `if_superseded` is sent where a
  /// newer one takes its place before; without it the newer one's answer is its answer, too.
  void add(const RequestId& request, StudioOrder order, std::optional<SendText> if_superseded = {});
  /// The one that was under way is answered, or cannot be.
  void take(const RequestDone& done);
  void leave(ClientId client);

 private:
  struct Waiting {
    StudioOrder order;
    std::optional<SendText> if_superseded;
  };

  StudioOrders& orders_;
  std::map<RequestId, std::optional<Waiting>> under_way_;
};

}  // namespace tessera
