#include "renderer/image/plain/plain_formats.h"

#include <fstream>

#include "renderer/image/plain/jpeg_format.h"
#include "renderer/image/plain/png_format.h"

namespace tessera {
namespace {

std::vector<char> read_file(const std::vector<char>& path) {
  constexpr std::streamoff kMostBytes = std::streamoff{1} << 30;
  std::ifstream in(std::string(path.begin(), path.end()), std::ios::binary | std::ios::ate);
  const std::streamoff size = in ? static_cast<std::streamoff>(in.tellg()) : -1;
  if (size <= 0 || size > kMostBytes) return {};
  std::vector<char> bytes(static_cast<size_t>(size));
  in.seekg(0);
  in.read(bytes.data(), size);
  return in ? bytes : std::vector<char>{};
}

std::optional<ImageAnswer> decode(const std::vector<char>& file, bool to_srgb) {
  if (is_jpeg(file)) return decode_jpeg(file, to_srgb);
  if (is_png(file)) return decode_png(file, to_srgb);
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
                                          const std::vector<char>& payload) {
  switch (request.call) {
    case ImageRequest::encode:
      return encode_png(request, payload);
    case ImageRequest::decode_file:
      return decode(read_file(payload), request.to_srgb != 0);
    case ImageRequest::decode_bytes:
      return decode(payload, request.to_srgb != 0);
    default:
      return std::nullopt;
  }
}

}  // namespace tessera
