#include "scenes/import/picture_problem.h"

#include <fmt/format.h>

#include "base/file.h"

namespace tessera {

std::string picture_problem(const AssetFolder& assets, const std::string& name,
                            const PictureCheck& check) {
  const auto file = assets.find_asset(name).file;
  if (!file) return fmt::format("lies outside {} and is not read", assets.shown_root(name));
  if (!is_input_file(*file)) return "is not there";
  return check ? check(file->string(), nullptr) : "";
}

}  // namespace tessera
