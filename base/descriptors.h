#pragma once

namespace tessera {

/// Throws render_error where this process may not open `count` more files and sockets now: below
/// that, libraries end the process instead of telling.
void check_room_for_descriptors(int count);

/// Raises this process's limit of descriptors (RLIMIT_NOFILE) to the hard one, less a reserve of 64
/// (a quarter, where there are fewer than 256): connections cannot take these, and SpareDescriptors
/// gives them to the process's own files. To be called before any other thread runs.
void keep_spare_descriptors();

/// While one lives, this process may also open what keep_spare_descriptors() has kept back: a file
/// can be opened though connections have used up all other descriptors. Descriptors that were
/// opened meanwhile stay valid, but hold a part of the reserve until they are closed. Without
/// keep_spare_descriptors() it does nothing. Any thread may have one, within another's, too.
///
/// The limit is that of the whole process: until the last of them is gone, a thread that accepts
/// connections can take from the reserve as well. Let it live for the call that opens and no
/// longer.
class SpareDescriptors {
 public:
  SpareDescriptors();
  ~SpareDescriptors();
  SpareDescriptors(const SpareDescriptors&) = delete;
  SpareDescriptors& operator=(const SpareDescriptors&) = delete;
};

}  // namespace tessera
