#pragma once

#include <sys/types.h>

#include <cstdint>
#include <optional>
#include <string>

namespace tessera {

/// A connection that libzmq has accepted, by its descriptor. libzmq closes that whenever it likes
/// and the number is given to another file; the socket's inode tells them apart. For this module
/// alone.
class Connection {
 public:
  Connection() = default;
  explicit Connection(int descriptor);

  int descriptor() const { return descriptor_; }
  /// Ends it, by either protocol; libzmq then closes the descriptor. Does nothing where it is gone.
  void end() const;
  /// By which the connections of one peer are counted: an IPv4 address, or the /64 of an IPv6
  /// address, which is what one site has. Nothing for local sockets.
  std::optional<uint64_t> network() const;
  /// The other side's address as text, for the log.
  std::string peer() const;
  /// How many bytes were sent to the other side, those sent again counted once; 0 where the system
  /// does not tell (Linux before 4.19, local sockets).
  uint64_t sent_bytes() const;

 private:
  int descriptor_ = -1;
  ino_t inode_ = 0;  ///< 0: it was gone already
};

}  // namespace tessera
