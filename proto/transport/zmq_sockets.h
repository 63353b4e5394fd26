#pragma once

#include <chrono>
#include <span>
#include <vector>
#include <zmq.hpp>

#include "proto/transport/transport.h"

namespace tessera {

/// What both ends of ZeroMQ share; for this module alone.

/// What either end opens before the first connection, and some more.
inline constexpr int kTransportDescriptors = 32;

/// A connection that has not completed its handshake after so long is ended by libzmq.
inline constexpr std::chrono::seconds kHandshake{5};

/// Interrupts a wait from another thread.
class WakeUp {
 public:
  WakeUp();
  ~WakeUp();
  WakeUp(const WakeUp&) = delete;
  WakeUp& operator=(const WakeUp&) = delete;
  int descriptor() const { return descriptor_; }
  void wake();
  void clear();

 private:
  int descriptor_;
};

/// Sets the limits of a socket, before it is bound or connected.
void configure(zmq::socket_t& socket, Channel channel);
/// Gives the bytes to zmq without copying them; its I/O thread frees them.
zmq::message_t wrap(MessageBytes bytes);
/// The bytes stay where they came in.
void take_bytes(ReceivedMessage& message, zmq::message_t& part);
/// All parts of the next message, or none.
std::vector<zmq::message_t> receive_parts(zmq::socket_t& socket);
/// Returns early where a signal comes.
void poll_sockets(std::span<zmq::pollitem_t> items, std::chrono::milliseconds timeout);

}  // namespace tessera
