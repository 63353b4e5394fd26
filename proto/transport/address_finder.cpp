#include "proto/transport/address_finder.h"

#include <fmt/format.h>

#include <algorithm>
#include <mutex>
#include <system_error>
#include <utility>

#include "proto/transport/listening.h"
#include "proto/transport/socket_address.h"

namespace tessera {
namespace {

// A name that is not answered for so long is trouble; its answer is still taken.
constexpr Time kPatience = std::chrono::seconds(2);
// After so long another question is asked beside one that is not answered, by another thread.
constexpr Time kAskAgain = std::chrono::seconds(20);
constexpr size_t kMostLookups = 3;
// Between the end of a lookup and the next, while there is no connection.
constexpr Time kFirstPause = std::chrono::seconds(1), kLongestPause = std::chrono::seconds(5);

}  // namespace

/// Shared with the thread that looks, which may outlive whoever asked.
struct AddressFinder::Lookup {
  std::string current;              ///< the address until now; empty: none
  std::optional<std::string> good;  ///< by which there was a connection last

  std::mutex mutex;  // of what the thread has found
  bool done = false;
  ResolvedHost found;
  ConnectionRace race;
};

AddressFinder::AddressFinder(Endpoint endpoint, ResolveHost resolve, std::shared_ptr<WakeUp> wake,
                             Time now)
    : endpoint_(std::move(endpoint)),
      resolve_(std::move(resolve)),
      wake_(std::move(wake)),
      pause_(kFirstPause) {
  const bool has_name = endpoint_.tcp && !socket_address(endpoint_.host, endpoint_.port);
  if (has_name) {
    look(now);
  } else {
    address_ = endpoint_;
  }
}

void AddressFinder::look(Time now) {
  const auto lookup = std::make_shared<Lookup>();
  if (address_) lookup->current = address_->host;
  lookup->good = good_;
  if (!asked_) asked_ = now;
  next_look_ = now + kAskAgain;
  try {
    run_detached(
        [lookup, host = endpoint_.host, port = endpoint_.port, resolve = resolve_, wake = wake_] {
          ResolvedHost found = resolve(host);
          std::vector<std::string>& all = found.addresses;
          ConnectionRace result;
          // The address until now goes on being used where it is as good as others.
          const auto current = std::ranges::find(all, lookup->current);
          if (current != all.end()) std::rotate(all.begin(), current, current + 1);
          // What the name no longer stands for comes last.
          const bool adds =
              !all.empty() && lookup->good && std::ranges::find(all, *lookup->good) == all.end();
          if (adds) all.push_back(*lookup->good);
          if (all.size() > 1) {
            result = race(all, port);
          } else if (!all.empty()) {
            result.winner = 0;
          }
          {
            const std::scoped_lock lock(lookup->mutex);
            lookup->found = std::move(found);
            lookup->race = std::move(result);
            lookup->done = true;
          }
          wake->wake();
        });
    lookups_.push_back(lookup);
  } catch (const std::system_error& error) {
    why_ = fmt::format("the name of the host of {} cannot be resolved: {}", endpoint_.str(),
                       error.what());
    asked_.reset();
    next_look_ = now + kLongestPause;
  }
}

bool AddressFinder::update(bool connected, Time now) {
  bool changed = false;
  for (size_t i = lookups_.size(); i-- > 0;) {
    const std::shared_ptr<Lookup> lookup = lookups_[i];
    const std::scoped_lock lock(lookup->mutex);
    if (!lookup->done) continue;
    changed = take(*lookup, connected, now);
    // What was asked before that says nothing new.
    lookups_.erase(lookups_.begin(), lookups_.begin() + static_cast<std::ptrdiff_t>(i) + 1);
    break;
  }
  if (connected) {
    good_ = address_->host;
    pause_ = kFirstPause;
    if (lookups_.empty() && next_look_ != Time::max()) next_look_ = now;  // once it breaks
  } else if (now >= next_look_ && lookups_.size() < kMostLookups) {
    look(now);
  }
  return changed;
}

bool AddressFinder::take(const Lookup& lookup, bool connected, Time now) {
  asked_.reset();
  next_look_ = now + pause_;
  pause_ = std::min(2 * pause_, kLongestPause);
  const ResolvedHost& found = lookup.found;
  is_unknown_ = found.is_unknown && !address_;
  why_.clear();
  const std::string endpoint = endpoint_.str();
  if (found.is_unknown) {
    why_ = fmt::format("the name of the host of {} is unknown{}", endpoint, last_address());
  } else if (found.addresses.empty()) {
    why_ = fmt::format("the name of the host of {} cannot be resolved: {}{}", endpoint,
                       found.failure, last_address());
  } else if (!lookup.race.winner) {
    std::string failures;
    for (size_t i = 0; i < found.addresses.size(); ++i) {
      failures +=
          fmt::format("{}{}: {}", i == 0 ? "" : ", ", found.addresses[i], lookup.race.failures[i]);
    }
    why_ = fmt::format("no address of the host of {} takes a connection ({})", endpoint, failures);
  }
  if (found.addresses.empty() || connected) return false;
  // Who answers nobody now may be starting anew, while the answer may be wrong.
  if (!lookup.race.winner && address_ && good_ == address_->host) return false;
  const std::string& host = found.addresses[lookup.race.winner.value_or(0)];
  if (address_ && address_->host == host) return false;
  address_ = endpoint_;
  address_->host = host;
  return true;
}

std::string AddressFinder::last_address() const {
  return address_ ? fmt::format("; its last address, {}, is tried", address_->host) : "";
}

std::optional<ConnectionTrouble> AddressFinder::trouble(Time now) const {
  std::string why = why_;
  if (asked_ && now - *asked_ >= kPatience) {
    why =
        fmt::format("no name server answers for the host of {}{}", endpoint_.str(), last_address());
  }
  if (why.empty()) return std::nullopt;
  return ConnectionTrouble{
      .why = why, .refused = false, .is_unknown_host = is_unknown_, .attempts = 0};
}

}  // namespace tessera
