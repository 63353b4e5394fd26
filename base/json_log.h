#pragma once

namespace tessera {

/// From here on the default logger, which was configured before, writes one JSON object a line:
/// {"time": "2026-03-01T12:00:00.123Z", "level": ..., "process": ..., "text": ...}.
void log_as_json();

}  // namespace tessera
