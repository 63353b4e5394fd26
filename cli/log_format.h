#pragma once

namespace CLI {
class App;
}

namespace tessera {

/// Adds --log-format; `json` must outlive the parsing.
void add_log_format(CLI::App& command, bool& json);

}  // namespace tessera
