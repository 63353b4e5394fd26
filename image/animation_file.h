#pragma once

#include <filesystem>
#include <string>
#include <string_view>
#include <vector>

namespace tessera {

/// Whether the format that the ending names holds the frames of an animation one after the other:
/// GIF, and PNG with the ending .apng.
bool holds_frames(const std::filesystem::path& path);

/// A file that shows pictures one after the other, again and again. It is joined from files of one
/// picture each, whose pixels stay what they are there.
class AnimationFile {
 public:
  /// The path is one that holds_frames().
  explicit AnimationFile(const std::filesystem::path& path);

  /// Adds what encode_image() made for that path. Throws a render error for a picture of another
  /// size than the first one.
  void add(std::string_view picture);
  size_t frames() const { return images_.size(); }
  static constexpr double kLeastRate = 0.002, kMostRate = 1000, kMostRateOfGif = 50;
  /// The rate that the format has nearest to that one. GIF counts hundredths of a second and gives
  /// each frame at least two.
  double nearest_rate(double frames_per_second) const;
  /// The file, of one frame at least, at the nearest rate.
  std::string bytes(double frames_per_second) const;

 private:
  void add_png(std::string_view picture);
  void add_gif(std::string_view picture);
  std::string png_bytes(double frames_per_second) const;
  std::string gif_bytes(double frames_per_second) const;
  /// Begins with the first picture's; later ones must have the same.
  void check_size(std::string_view size);

  std::filesystem::path path_;
  bool is_gif_;
  std::string size_;                 ///< as the format writes it, of every frame
  std::string head_, tail_;          ///< what stands before and after the frames
  std::vector<std::string> images_;  ///< the frames' pixels
};

}  // namespace tessera
