#include "proto/transport/waiting_connections.h"

#include <spdlog/spdlog.h>
#include <sys/resource.h>

#include <algorithm>
#include <iterator>

#include "proto/transport/zmq_sockets.h"

namespace tessera {
namespace {

/// Of all addresses together; a quarter of the process's descriptors where that is less.
constexpr size_t kMost = 1024;
/// Of one address. Behind one may be thousands of honest workers that start at once: each has done
/// with its handshake within milliseconds, and one that is ended comes again.
constexpr size_t kMostOfAnAddress = kMost / 4;

// What a server sends until somebody is let in (ZeroMQ RFC 23 and 26): its greeting, its welcome
// and perhaps an error. After that comes its READY of 67 bytes or more, by CURVE, and of 43
// without.
constexpr uint64_t kGreetingBytes = 64, kWelcomeBytes = 170, kErrorBytes = 12;

/// So long after it was accepted, a connection that still is there has completed its handshake.
constexpr auto kLongest = kHandshake + std::chrono::seconds(1);

size_t most_waiting() {
  rlimit limit{};
  if (getrlimit(RLIMIT_NOFILE, &limit) != 0) return kMost;
  return static_cast<size_t>(std::min<rlim_t>(kMost, limit.rlim_cur / 4));
}

}  // namespace

WaitingConnections::WaitingConnections(bool has_keys)
    : most_sent_(kGreetingBytes + (has_keys ? kWelcomeBytes + kErrorBytes : 0)),
      most_(most_waiting()) {}

void WaitingConnections::add(int listener, int descriptor) {
  remove(listener, descriptor);
  const Connection connection(descriptor);
  const Place place{listener, descriptor};
  waiting_.push_back({place, connection, connection.network(), Clock::now()});
  places_[place] = std::prev(waiting_.end());
  ++counts_[waiting_.back().network];
}

void WaitingConnections::remove(int listener, int descriptor) {
  const auto found = places_.find({listener, descriptor});
  if (found != places_.end()) forget(found->second);
}

void WaitingConnections::enforce() {
  forget_old();
  while (!waiting_.empty()) {
    const auto& [network, count] =
        *std::ranges::max_element(counts_, {}, [](const auto& each) { return each.second; });
    const bool too_many_of_it = network && count > kMostOfAnAddress;
    if (waiting_.size() <= most_ && !too_many_of_it) return;
    if (std::exchange(admitted_, false)) {
      forget_let_in();
    } else {
      end_oldest_of_as_many(count);
    }
  }
}

bool WaitingConnections::is_let_in(const Waiting& waiting) const {
  return waiting.connection.sent_bytes() > most_sent_;
}

void WaitingConnections::forget(Iterator waiting) {
  const auto count = counts_.find(waiting->network);
  if (--count->second == 0) counts_.erase(count);
  places_.erase(waiting->place);
  waiting_.erase(waiting);
}

void WaitingConnections::forget_old() {
  const auto longest_ago = Clock::now() - kLongest;
  while (!waiting_.empty() && waiting_.front().since < longest_ago) forget(waiting_.begin());
}

void WaitingConnections::forget_let_in() {
  for (auto next = waiting_.begin(); next != waiting_.end();) {
    const auto each = next++;
    if (is_let_in(*each)) forget(each);
  }
}

void WaitingConnections::end_oldest_of_as_many(size_t count) {
  const auto oldest = std::ranges::find_if(
      waiting_, [&](const Waiting& each) { return counts_.at(each.network) == count; });
  // It may have been let in since: READY is sent after the admission was told.
  if (!is_let_in(*oldest)) {
    if (!std::exchange(told_, true)) {
      spdlog::warn(
          "too many connections wait to be let in ({}, {} of them from {}): the oldest are ended; "
          "expected at most {}, and {} of an address",
          waiting_.size(), count, oldest->connection.peer(), most_, kMostOfAnAddress);
    }
    oldest->connection.end();
  }
  forget(oldest);
}

}  // namespace tessera
