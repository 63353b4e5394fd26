#pragma once

#include <chrono>
#include <cstddef>
#include <cstdint>
#include <list>
#include <map>
#include <optional>
#include <utility>

#include "proto/transport/connection.h"

namespace tessera {

/// The connections that were accepted and have not been let in yet, whose number is bounded: more
/// than so many would use up the descriptors of the process. libzmq tells that some connection has
/// completed its handshake but not which, so that whether one still waits is found out by what the
/// server has sent to it. One thread uses it.
class WaitingConnections {
 public:
  /// Without keys, those that have sent no greeting wait.
  explicit WaitingConnections(bool has_keys);

  /// `listener` is the descriptor of the listening socket that has accepted it.
  void add(int listener, int descriptor);
  /// It is closed, or about to be.
  void remove(int listener, int descriptor);
  /// One of them, or more, has been let in.
  void note_admission() { admitted_ = true; }
  /// Ends the oldest of the address that has the most, until the bounds are kept. To be called when
  /// everything that has been told by then was passed on by the above.
  void enforce();

 private:
  using Clock = std::chrono::steady_clock;
  using Place = std::pair<int, int>;  ///< listener and descriptor
  using Network = std::optional<uint64_t>;
  struct Waiting {
    Place place;
    Connection connection;
    Network network;
    Clock::time_point since;
  };
  using Iterator = std::list<Waiting>::iterator;

  bool is_let_in(const Waiting& waiting) const;
  void forget(Iterator waiting);
  void forget_old();
  void forget_let_in();
  void end_oldest_of_as_many(size_t count);

  const uint64_t most_sent_;  ///< in bytes, to one that is not let in
  const size_t most_;
  std::list<Waiting> waiting_;  ///< the oldest first
  std::map<Place, Iterator> places_;
  std::map<Network, size_t> counts_;  ///< none is 0
  bool admitted_ = false;             ///< since those that are let in were last looked for
  bool told_ = false;
};

}  // namespace tessera
