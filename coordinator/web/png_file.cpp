#include "coordinator/web/png_file.h"

#include <png.h>

#include <cstring>

#include "base/error.h"

namespace tessera {

std::string png_file(const PreviewImage& image) {
  png_image png{};
  png.version = PNG_IMAGE_VERSION;
  png.width = static_cast<png_uint_32>(image.width);
  png.height = static_cast<png_uint_32>(image.height);
  png.format = PNG_FORMAT_RGB;
  png.flags = PNG_IMAGE_FLAG_FAST;
  std::string file(PNG_IMAGE_PNG_SIZE_MAX(png), '\0');
  png_alloc_size_t size = file.size();
  if (png_image_write_to_memory(&png, file.data(), &size, 0, image.rgb.data(), 0, nullptr) == 0) {
    throw render_error(std::string("the preview cannot be encoded: ") + png.message);
  }
  file.resize(size);
  return file;
}

}  // namespace tessera
