#include "scenes/import/picture_problem.h"

namespace tessera {

std::string picture_problem(const AssetFolder& assets, const std::string& name,
                            const PictureCheck& check) {
  const auto file = assets.find(name);
  std::error_code ignored;
  if (!file) return "lies outside the scene's folder and is not read";
  if (!std::filesystem::is_regular_file(*file, ignored)) return "is not there";
  return check ? check(file->string(), nullptr) : "";
}

}  // namespace tessera
