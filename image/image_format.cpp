#include "image/image_format.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cstdint>

#include "base/error.h"

namespace tessera {
namespace {

using namespace std::string_view_literals;

/// What stands at a fixed place of every file of a format.
struct Signature {
  std::string_view bytes;
  size_t at;
  const char* format;  ///< as OpenImageIO calls it; null: it is not read
  const char* title;   ///< of a format that is not read
};

constexpr const char* kMovie = "a movie";

constexpr std::array kSignatures{
    Signature{"\x89PNG\r\n\x1a\n"sv, 0, "png", nullptr},
    Signature{"\xff\xd8\xff"sv, 0, "jpeg", nullptr},
    Signature{"GIF87a"sv, 0, "gif", nullptr},
    Signature{"GIF89a"sv, 0, "gif", nullptr},
    Signature{"BM"sv, 0, "bmp", nullptr},
    Signature{"II*\0"sv, 0, "tiff", nullptr},
    Signature{"MM\0*"sv, 0, "tiff", nullptr},
    Signature{"II+\0"sv, 0, "tiff", nullptr},
    Signature{"MM\0+"sv, 0, "tiff", nullptr},
    Signature{"\x76\x2f\x31\x01"sv, 0, "openexr", nullptr},
    Signature{"#?"sv, 0, "hdr", nullptr},
    Signature{"WEBP"sv, 8, "webp", nullptr},
    Signature{"DDS "sv, 0, "dds", nullptr},
    Signature{"8BPS"sv, 0, "psd", nullptr},
    Signature{"\x01\xda"sv, 0, "sgi", nullptr},
    Signature{"\0\0\1\0"sv, 0, "ico", nullptr},
    Signature{"\0\0\0\x0cjP  \r\n\x87\n"sv, 0, "jpeg2000", nullptr},
    Signature{"\xff\x4f\xff\x51"sv, 0, "jpeg2000", nullptr},
    Signature{"ftyphei"sv, 4, "heif", nullptr},
    Signature{"ftyphev"sv, 4, "heif", nullptr},
    Signature{"ftypmif1"sv, 4, "heif", nullptr},
    Signature{"ftypmsf1"sv, 4, "heif", nullptr},
    Signature{"ftypavi"sv, 4, "heif", nullptr},
    // Others are told by their names alone.
    Signature{"ftyp"sv, 4, nullptr, kMovie},
    Signature{"moov"sv, 4, nullptr, kMovie},
    Signature{"mdat"sv, 4, nullptr, kMovie},
    Signature{"AVI "sv, 8, nullptr, kMovie},
    Signature{"\x1a\x45\xdf\xa3"sv, 0, nullptr, kMovie},
    Signature{"\0\0\1\xba"sv, 0, nullptr, kMovie},
    Signature{"#EXTM3U"sv, 0, nullptr, "a playlist"},
    Signature{"<?xml"sv, 0, nullptr, "an XML document"},
    Signature{"<MPD"sv, 0, nullptr, "an XML document"},
    Signature{"<svg"sv, 0, nullptr, "an SVG drawing"},
    Signature{"%PDF"sv, 0, nullptr, "a PDF document"},
    Signature{"DICM"sv, 128, nullptr, "a DICOM file"},
    Signature{"SIMPLE  ="sv, 0, nullptr, "a FITS file"},
    Signature{"\xabKTX"sv, 0, nullptr, "a KTX texture"},
    Signature{"\x2f\x08\x67\xab"sv, 0, nullptr, "a depth map of RenderMan"},
    Signature{"\xab\x67\x08\x2f"sv, 0, nullptr, "a depth map of RenderMan"},
};

constexpr const char* kExpected =
    "an image file (PNG, JPEG, GIF, BMP, TIFF, OpenEXR, Radiance HDR, Targa, PNM, PFM, WebP, DDS, "
    "PSD, SGI, ICO, JPEG 2000, HEIF or AVIF)";

uint8_t byte_at(std::string_view head, size_t at) { return static_cast<uint8_t>(head[at]); }

/// P1 to P6, PF or Pf, then white space or a comment.
bool is_pnm(std::string_view head) {
  return head.size() > 2 && head[0] == 'P' &&
         "123456Ff"sv.find(head[1]) != std::string_view::npos &&
         " \t\r\n#"sv.find(head[2]) != std::string_view::npos;
}

/// Targa has no signature. Its header has few values in few places.
bool is_targa(std::string_view head) {
  constexpr size_t kHeader = 18;
  if (head.size() < kHeader) return false;
  const uint8_t map = byte_at(head, 1), kind = byte_at(head, 2), bits = byte_at(head, 16);
  const bool is_mapped = kind == 1 || kind == 9;
  const bool is_kind = is_mapped || kind == 2 || kind == 3 || kind == 10 || kind == 11;
  const bool has_pixels = (head[12] != 0 || head[13] != 0) && (head[14] != 0 || head[15] != 0);
  return is_kind && map <= 1 && (map == 1 || !is_mapped) && has_pixels &&
         (bits == 8 || bits == 15 || bits == 16 || bits == 24 || bits == 32);
}

}  // namespace

const char* image_format_of(const std::string& name, std::string_view head) {
  head = head.substr(0, kFormatBytes);
  const auto found = std::ranges::find_if(kSignatures, [&](const Signature& signature) {
    return head.size() > signature.at && head.substr(signature.at).starts_with(signature.bytes);
  });
  if (found != kSignatures.end() && found->format) return found->format;
  if (found == kSignatures.end() && is_pnm(head)) return "pnm";
  if (found == kSignatures.end() && is_targa(head)) return "targa";
  throw scene_error(SourcePlace{name},
                    found == kSignatures.end()
                        ? "is of no known image format"
                        : fmt::format("is {}, which is not read as an image", found->title),
                    kExpected);
}

}  // namespace tessera
