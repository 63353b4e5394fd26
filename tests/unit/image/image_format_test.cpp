#include "image/image_format.h"

#include <gtest/gtest.h>

#include <string>
#include <utility>

#include "base/error.h"

namespace tessera {
namespace {

using namespace std::string_literals;

std::string format_of(const std::string& head) {
  try {
    return image_format_of("a.png", head);
  } catch (const Error& error) {
    EXPECT_EQ(error.code(), ExitCode::bad_scene);
    return error.what();
  }
}

/// A header of Targa whose third byte is `kind`.
std::string targa(char kind) {
  return std::string{"\0\0", 2} + kind + "\0\0\0\0\0\0\0\0\0\x10\0\x04\0\x18\0"s;
}

TEST(ImageFormat, is_told_by_the_first_bytes) {
  const std::pair<std::string, const char*> files[] = {
      {"\x89PNG\r\n\x1a\n\0\0\0\rIHDR"s, "png"},
      {"\xff\xd8\xff\xe0"s, "jpeg"},
      {"GIF89a"s, "gif"},
      {"BM\x46\0"s, "bmp"},
      {"II*\0\x08"s, "tiff"},
      {"MM\0*\0"s, "tiff"},
      {"\x76\x2f\x31\x01\x02"s, "openexr"},
      {"#?RADIANCE\n"s, "hdr"},
      {"RIFF\x1c\0\0\0WEBPVP8 "s, "webp"},
      {"DDS \x7c"s, "dds"},
      {"8BPS\0\1"s, "psd"},
      {"\x01\xda\0\1"s, "sgi"},
      {"\0\0\1\0\1\0"s, "ico"},
      {"\0\0\0\x0cjP  \r\n\x87\n"s, "jpeg2000"},
      {"\0\0\0\x1c"
       "ftypheic"s,
       "heif"},
      {"\0\0\0\x1c"
       "ftypavif"s,
       "heif"},
      {"P6\n16 4\n255\n"s, "pnm"},
      {"Pf\n1 1\n-1\n"s, "pnm"},
      {targa(2), "targa"},
  };
  for (const auto& [head, format] : files) EXPECT_EQ(format_of(head), format);
}

TEST(ImageFormat, what_is_not_read_is_named) {
  const std::pair<std::string, const char*> files[] = {
      {"<?xml version=\"1.0\"?>\n<MPD>"s, "an XML document"},
      {"\0\0\0\x18"
       "ftypisom"s,
       "a movie"},
      {"\0\0\0\x14"
       "ftypqt  "s,
       "a movie"},
      {"RIFF\x1c\0\0\0AVI LIST"s, "a movie"},
      {"\x1a\x45\xdf\xa3\1"s, "a movie"},
      {"#EXTM3U\n"s, "a playlist"},
      {std::string(128, '\0') + "DICM", "a DICOM file"},
      {"SIMPLE  =                    T"s, "a FITS file"},
      {"\x2f\x08\x67\xab\0"s, "a depth map"},
      {"ffconcat version 1.0\nfile 'a.mp4'\n"s, "of no known image format"},
      {"P7 is no image\n"s, "of no known image format"},
      {"PF"s, "of no known image format"},
      {targa(5), "of no known image format"},
      {std::string(1000, '\0'), "of no known image format"},
      {"\xff"s, "of no known image format"},
      {""s, "of no known image format"},
  };
  for (const auto& [head, what] : files) {
    const std::string said = format_of(head);
    EXPECT_TRUE(said.starts_with("a.png: is " + std::string(what))) << said;
    EXPECT_NE(said.find("; expected an image file (PNG, JPEG, "), std::string::npos) << said;
  }
}

}  // namespace
}  // namespace tessera
