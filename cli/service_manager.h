#pragma once

#include <string>

namespace tessera {

/// Tells systemd, where it started this process as a service of Type=notify, how that is: such as
/// "READY=1" (sd_notify(3)). Elsewhere nothing happens.
void notify_service_manager(const std::string& state);

}  // namespace tessera
