#include <OpenImageIO/imageio.h>

#include <algorithm>
#include <cstdio>
#include <exception>
#include <string>

#include "renderer/image/image_module.h"

namespace tessera {

namespace {

void report(const std::string& cause, char* error, size_t error_size) {
  std::snprintf(error, error_size, "%s", cause.c_str());
}

OIIO::ImageSpec make_spec(const ImageModule::Picture& picture) {
  OIIO::ImageSpec spec(picture.width, picture.height, 3,
                       picture.is_float ? OIIO::TypeDesc::FLOAT : OIIO::TypeDesc::UINT8);
  spec.attribute("oiio:ColorSpace", picture.is_float ? "Linear" : "sRGB");
  for (size_t i = 0; i < picture.attribute_count; ++i) {
    const ImageModule::Attribute& a = picture.attributes[i];
    switch (a.kind) {
      case ImageModule::Attribute::text:
        spec.attribute(a.name, a.text_value);
        break;
      case ImageModule::Attribute::integer:
        spec.attribute(a.name, a.integer_value);
        break;
      case ImageModule::Attribute::real:
        spec.attribute(a.name, a.real_value);
        break;
    }
  }
  return spec;
}

bool write(const char* path, const char* format, const ImageModule::Picture& picture, char* error,
           size_t error_size) {
  const auto output = OIIO::ImageOutput::create(format);
  if (!output) {
    report(OIIO::geterror(), error, error_size);
    return false;
  }
  const OIIO::TypeDesc type = picture.is_float ? OIIO::TypeDesc::FLOAT : OIIO::TypeDesc::UINT8;
  if (!output->open(path, make_spec(picture)) || !output->write_image(type, picture.pixels) ||
      !output->close()) {
    report(output->geterror(), error, error_size);
    return false;
  }
  return true;
}

bool read(const char* path, float* (*allocate)(void* context, int width, int height), void* context,
          char* error, size_t error_size) {
  const auto input = OIIO::ImageInput::open(path);
  if (!input) {
    report(OIIO::geterror(), error, error_size);
    return false;
  }
  const OIIO::ImageSpec& spec = input->spec();
  const int channels = spec.nchannels;
  float* const values = channels < 1 ? nullptr : allocate(context, spec.width, spec.height);
  if (!values) {
    report("its size is out of range", error, error_size);
    return false;
  }
  const bool three = channels >= 3;
  // One call reads a tiled or a scanline file alike; fewer channels are spread out in place after
  // it.
  const OIIO::stride_t pixel = 3 * sizeof(float);
  if (!input->read_image(0, 0, 0, three ? 3 : 1, OIIO::TypeDesc::FLOAT, values, pixel)) {
    report(input->geterror(), error, error_size);
    return false;
  }
  if (!three) {
    const size_t count = static_cast<size_t>(spec.width) * static_cast<size_t>(spec.height);
    for (size_t i = 0; i < count; ++i) values[3 * i + 1] = values[3 * i + 2] = values[3 * i];
  }
  return true;
}

bool read_texels(const char* path,
                 void* (*allocate)(void* context, const ImageModule::Layout& layout), void* context,
                 char* error, size_t error_size) {
  OIIO::ImageSpec config;
  config.attribute("oiio:UnassociatedAlpha", 1);
  const auto input = OIIO::ImageInput::open(path, &config);
  if (!input) {
    report(OIIO::geterror(), error, error_size);
    return false;
  }
  const OIIO::ImageSpec& spec = input->spec();
  // Integers of 16 bits are more than half floats hold.
  const OIIO::TypeDesc type = spec.format == OIIO::TypeDesc::UINT8  ? OIIO::TypeDesc::UINT8
                              : spec.format == OIIO::TypeDesc::HALF ? OIIO::TypeDesc::HALF
                                                                    : OIIO::TypeDesc::FLOAT;
  const int channels = std::min(spec.nchannels, 4);
  void* const texels = channels < 1 ? nullptr
                                    : allocate(context, {spec.width, spec.height, channels,
                                                         static_cast<int>(type.basesize()) * 8});
  if (!texels) {
    report("its size is out of range", error, error_size);
    return false;
  }
  if (!input->read_image(0, 0, 0, channels, type, texels)) {
    report(input->geterror(), error, error_size);
    return false;
  }
  return true;
}

// Nothing may be thrown through the C boundary.
bool guarded_write(const char* path, const char* format, const ImageModule::Picture& picture,
                   char* error, size_t error_size) {
  try {
    return write(path, format, picture, error, error_size);
  } catch (const std::exception& e) {
    report(e.what(), error, error_size);
    return false;
  }
}

bool guarded_read(const char* path, float* (*allocate)(void* context, int width, int height),
                  void* context, char* error, size_t error_size) {
  try {
    return read(path, allocate, context, error, error_size);
  } catch (const std::exception& e) {
    report(e.what(), error, error_size);
    return false;
  }
}

bool guarded_read_texels(const char* path,
                         void* (*allocate)(void* context, const ImageModule::Layout& layout),
                         void* context, char* error, size_t error_size) {
  try {
    return read_texels(path, allocate, context, error, error_size);
  } catch (const std::exception& e) {
    report(e.what(), error, error_size);
    return false;
  }
}

constexpr ImageModule kModule{guarded_write, guarded_read, guarded_read_texels};

}  // namespace

}  // namespace tessera

extern "C" __attribute__((visibility("default"))) const tessera::ImageModule* tessera_image_module(
    uint32_t version) {
  return version == tessera::kImageModuleVersion ? &tessera::kModule : nullptr;
}
