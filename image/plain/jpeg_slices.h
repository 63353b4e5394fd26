#pragma once

#include <cstddef>
#include <cstdio>
#include <functional>
#include <optional>
#include <span>
#include <string>
#include <vector>
// After <cstdio>, whose FILE it names.
#include <jpeglib.h>

namespace tessera {

/// A JPEG file cut at its restart markers into files of some of its rows each, which several
/// threads may decode. Together they have the pixels of the whole, bit for bit.
class JpegSlices {
 public:
  /// `info` has read the header of `file`, which must outlive this, and no more. Nothing where the
  /// file has no markers between its rows, or fewer than it should, where slices would be few or
  /// large, and where rows of pixels depend on others than those of their blocks.
  static std::optional<JpegSlices> cut(const jpeg_decompress_struct& info,
                                       std::span<const char> file);
  size_t count() const { return begins_.size() - 1; }
  /// Decodes slice `number` to its place in `pixels`, which are the whole picture's, `channels`
  /// bytes each, and returns that place; nothing where libjpeg as much as warns. Several threads
  /// may each decode one.
  std::span<char> decode(size_t number, size_t channels, std::span<char> pixels) const;

 private:
  JpegSlices() = default;

  std::span<const char> file_;
  size_t width_ = 0, height_ = 0;
  size_t rows_ = 0;             ///< of pixels, in all slices but the last
  size_t height_at_ = 0;        ///< where the file has its height, two bytes
  std::vector<size_t> begins_;  ///< of the slices' data in the file, and the end of the last
};

/// Decodes all slices into `pixels` on several threads; each calls `finish` for what it
/// has decoded; false where one does not decode.
bool decode_slices(const JpegSlices& slices, size_t channels, std::span<char> pixels,
                   const std::function<void(std::span<char>)>& finish);

}  // namespace tessera
