#pragma once

namespace tessera {

/// Throws render_error where this process may not open `count` more files and sockets now: below
/// that, libraries end the process instead of telling.
void check_room_for_descriptors(int count);

}  // namespace tessera
