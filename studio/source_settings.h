#pragma once

#include <string>
#include <utility>
#include <vector>

#include "scenes/edit/edit.h"

namespace tessera {

/// Writes options of `tessera render`, by their long names, as settings of the scene. Refuses those
/// that the language has no setting for.
edit::Change write_settings(const edit::Outline& outline,
                            const std::vector<std::pair<std::string, std::string>>& options);

}  // namespace tessera
