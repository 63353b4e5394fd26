#pragma once

#include <cstddef>
#include <cstdint>
#include <optional>
#include <span>

#include "base/digest.h"
#include "base/owned_descriptor.h"

namespace tessera {

/// Memory of the processes of one farm on one machine, in which each thing is made once, by whoever
/// needs it first, while the others wait. It has no name: it goes with the last process that has it
/// open. Whoever dies over a thing makes way for the next. Safe between processes and threads.
class SharedArena {
 public:
  /// A new one, to be inherited by the processes that share it. Throws render_error.
  static OwnedDescriptor create();
  /// One that was inherited; `descriptor` must stay open.
  explicit SharedArena(int descriptor) : descriptor_(descriptor) {}

  /// The right to make the thing of that key, as long as this object lives: or the thing.
  class Claim {
   public:
    /// Bytes of the thing; nothing: it is not there, and is the caller's to make.
    std::optional<uint64_t> size() const { return size_; }
    /// Fills `to` from byte `from` of the thing on. False if it cannot be read.
    bool read(uint64_t from, std::span<std::byte> to) const;
    /// Puts the parts there for all, one behind the other, unless there is no room; the right ends.
    void publish(std::span<const std::span<const std::byte>> parts);

   private:
    friend class SharedArena;
    OwnedDescriptor file_;  ///< holds the locks
    Digest key_;
    uint64_t begin_ = 0;
    std::optional<uint64_t> size_;
  };
  /// Waits while another has the claim, half a minute at most: then everybody makes their own.
  Claim claim(const Digest& key) const;

 private:
  int descriptor_;
};

}  // namespace tessera
