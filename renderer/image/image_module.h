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
  /// What a picture is kept as: its own numbers, alpha not multiplied in.
  struct Layout {
    int width, height;
    int channels;  ///< 1 to 4; further ones of the file are left out
    int bits;      ///< 8, 16 (half float) or 32 (float), the least that holds the file's numbers
  };
  /// Reads a picture into memory from `allocate(context, layout)`, which returns room for its rows
  /// from the top, tightly packed, or null to refuse the size.
  bool (*read_texels)(const char* path, void* (*allocate)(void* context, const Layout& layout),
                      void* context, char* error, size_t error_size);
};

inline constexpr uint32_t kImageModuleVersion = 2;
inline constexpr const char* kImageModuleEntry = "tessera_image_module";
/// The type of that entry: null for a version that it does not speak.
using ImageModuleEntry = const ImageModule* (*)(uint32_t version);

}  // namespace tessera
