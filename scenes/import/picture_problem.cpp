#include "scenes/import/picture_problem.h"

#include <fmt/format.h>

namespace tessera {

std::string picture_problem(const AssetFolder& assets, const std::string& name,
                            const PictureCheck& check) {
  const auto file = assets.find(name);
  std::error_code ignored;
  if (!file) return fmt::format("lies outside {} and is not read", assets.shown_root());
  if (!std::filesystem::is_regular_file(*file, ignored)) return "is not there";
  return check ? check(file->string(), nullptr) : "";
}

}  // namespace tessera
