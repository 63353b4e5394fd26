#include "front/animation_files.h"

#include <fmt/format.h>

#include "base/all_failures.h"

namespace tessera {

void AnimationFiles::add(const std::filesystem::path& path, const Film& film,
                         const OutputSettings& settings, const ImageMetadata& metadata) {
  const std::string picture = encode_image(path, film, settings, metadata);
  files_.try_emplace(path, path).first->second.add(picture);
}

void AnimationFiles::write(double frames_per_second, const Write& write) const {
  AllFailures failures;
  for (const auto& [path, file] : files_) {
    if (file.frames() == 0) continue;
    failures.attempt([&, &path = path, &file = file] {
      const double rate = file.nearest_rate(frames_per_second);
      const std::string note =
          rate == frames_per_second
              ? ""
              : fmt::format(
                    "'{}' shows {:.4g} frames a second in place of {:.4g}, as its format has "
                    "no other rate that is nearer",
                    path.string(), rate, frames_per_second);
      write({path, file.bytes(rate), file.frames(), rate, note});
    });
  }
  failures.throw_if_any();
}

}  // namespace tessera
