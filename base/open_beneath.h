#pragma once

#include <sys/types.h>

#include <string>

#include "base/owned_descriptor.h"

namespace tessera {

/// Opens `path`, relative and without links, below the open folder `root`: with errno ELOOP, EXDEV
/// or ENOTDIR where a part of it is a link by now or it leads out of `root`. "" and "." are the
/// folder itself. -1 where it fails, and errno tells why.
OwnedDescriptor open_beneath(int root, const std::string& path, int flags);
/// The same for kernels without openat2 (before 5.6, or where a sandbox forbids it): part by part.
OwnedDescriptor open_beneath_by_steps(int root, const std::string& path, int flags);

}  // namespace tessera
