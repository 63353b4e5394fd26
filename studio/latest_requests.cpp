#include "studio/latest_requests.h"

namespace tessera {

void LatestRequests::add(const RequestId& request, StudioOrder order,
                         std::optional<SendText> if_superseded) {
  const auto [at, is_first] = under_way_.try_emplace(request);
  if (is_first) return orders_.push_back(std::move(order));
  std::optional<Waiting>& waiting = at->second;
  if (waiting && waiting->if_superseded) orders_.push_back(std::move(*waiting->if_superseded));
  waiting = Waiting{std::move(order), std::move(if_superseded)};
}

void LatestRequests::take(const RequestDone& done) {
  const auto at = under_way_.find(done.request);
  if (at == under_way_.end()) return;  // its page is gone
  if (!at->second) {
    under_way_.erase(at);
    return;
  }
  orders_.push_back(std::move(at->second->order));
  at->second.reset();
}

void LatestRequests::leave(ClientId client) {
  std::erase_if(under_way_, [client](const auto& each) { return each.first.client == client; });
}

}  // namespace tessera
