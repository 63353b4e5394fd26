#pragma once

#include <cstddef>
#include <cstdint>

namespace tessera {

/// What the loadable module offers: plain C types, so that the program that loads it links none of
/// its libraries. All calls are thread-safe; on failure they return false with the cause, cut to
/// `error_size`, in `error`.
struct ImageModule {
  struct Attribute {
    const char* name;
    enum Kind : uint32_t { text, integer, real } kind;
    const char* text_value;
    int integer_value;
    float real_value;
  };
  struct Picture {
    const void* pixels;  ///< rows from the top, 3 channels
    int width, height;
    bool is_float;  ///< else 8-bit unsigned
    const Attribute* attributes;
    size_t attribute_count;
  };
  /// Writes `path` in the named format.
  bool (*write)(const char* path, const char* format, const Picture& picture, char* error,
                size_t error_size);
  /// Reads a picture into memory from `allocate(context, width, height)`, which returns room for
  /// width * height * 3 floats, or null to refuse the size.
  bool (*read)(const char* path, float* (*allocate)(void* context, int width, int height),
               void* context, char* error, size_t error_size);
};

inline constexpr uint32_t kImageModuleVersion = 1;
inline constexpr const char* kImageModuleEntry = "tessera_image_module";
/// The type of that entry: null for a version that it does not speak.
using ImageModuleEntry = const ImageModule* (*)(uint32_t version);

}  // namespace tessera
