#include "image/plain/plain_formats.h"

#include <string_view>

#include "image/plain/exr_format.h"
#include "image/plain/jpeg_format.h"
#include "image/plain/png_format.h"
#include "image/plain/pnm_format.h"

namespace tessera {
namespace {

std::optional<ImageAnswer> decode(const ImageRequest& request, std::span<const char> file) {
  const std::string_view format = request.format;
  const bool all = request.call == ImageRequest::decode_all;
  if (format == "openexr") return decode_exr(file, all);
  if (format == "pnm") return decode_pnm(file, all);
  if (all) return std::nullopt;
  if (format == "jpeg") return decode_jpeg(file, request.to_srgb != 0);
  if (format == "png") return decode_png(file, request.to_srgb != 0);
  return std::nullopt;
}

}  // namespace

std::vector<std::pair<std::string, std::string>> image_texts(const ImageAttributes& attributes) {
  std::vector<std::pair<std::string, std::string>> texts{
      {"tessera:SceneDigest", attributes.scene_digest},
      {"tessera:Colors", attributes.colors},
      {"tessera:Seed", std::to_string(attributes.seed)},
      {"tessera:Samples", std::to_string(attributes.samples_per_pixel)}};
  if (attributes.denoiser[0]) texts.emplace_back("tessera:Denoised", attributes.denoiser);
  // Not every format has room for names of ours.
  std::string description;
  for (const auto& [name, text] : texts) {
    description.append(description.empty() ? "" : " ").append(name).append("=").append(text);
  }
  texts.emplace_back("Software", attributes.software);
  texts.emplace_back("Description", description);
  return texts;
}

std::optional<ImageAnswer> answer_plainly(const ImageRequest& request,
                                          std::span<const char> bytes) {
  switch (request.call) {
    case ImageRequest::encode:
      if (auto png = encode_png(request, bytes)) return png;
      return encode_exr(request, bytes);
    case ImageRequest::decode:
    case ImageRequest::decode_all:
      return decode(request, bytes);
    default:
      return std::nullopt;
  }
}

}  // namespace tessera
