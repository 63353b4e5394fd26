#pragma once

#include <cstddef>
#include <filesystem>
#include <functional>
#include <map>
#include <string>

#include "image/animation_file.h"
#include "image/image_file.h"

namespace tessera {

/// The files of a render that hold all frames of an animation, kept until they are written.
class AnimationFiles {
 public:
  /// A file as it is to be written.
  struct Whole {
    const std::filesystem::path& path;
    std::string bytes;
    size_t frames = 0;
    double frames_per_second = 0;
    std::string note;  ///< why that is another rate than was asked for; empty: it is not
  };
  using Write = std::function<void(const Whole& file)>;

  /// Adds the next frame of the file at `path`, which holds_frames(). Throws a render error where
  /// it cannot be encoded or has another size than the first one.
  void add(const std::filesystem::path& path, const Film& film, const OutputSettings& settings,
           const ImageMetadata& metadata);
  /// Hands on each file that has a frame. What `write` throws for one keeps none of the others from
  /// being written; it is thrown in the end.
  void write(double frames_per_second, const Write& write) const;

 private:
  std::map<std::filesystem::path, AnimationFile> files_;
};

}  // namespace tessera
