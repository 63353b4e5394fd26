#pragma once

#include "proto/tessera/v1/farm.pb.h"
#include "proto/wire/version.h"

namespace tessera::testing {

/// What a played worker of one thread says first.
inline v1::Envelope played_hello(uint64_t id) {
  v1::Envelope message;
  v1::Hello& hello = *message.mutable_hello();
  hello.set_protocol_major(kProtocolMajor);
  hello.set_numerics_id(kNumericsId);
  hello.set_worker_id(id);
  hello.set_session(1);
  hello.set_threads(1);
  hello.set_credit(2);
  return message;
}

}  // namespace tessera::testing
