#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <filesystem>
#include <utility>

#include "renderer/math/elementary.h"
#include "scenes/formats/gltf/gltf_material.h"
#include "scenes/import/data_uri.h"
#include "scenes/import/picture_light.h"

namespace tessera {
namespace {

constexpr uint64_t kNearest = 9728, kLinear = 9729;

/// Returns the number of a sampler's filter; nothing, with a warning, where glTF has no such
/// filter. The largest one is `most`: kLinear, or the last one that mixes levels of detail.
std::optional<uint64_t> filter_of(const GltfValue& filter, uint64_t most, const char* expected) {
  constexpr uint64_t kFirstWithLevels = 9984;
  const auto number = filter.whole();
  if (!number || *number == kNearest || *number == kLinear ||
      (*number >= kFirstWithLevels && *number <= most))
    return number;
  filter.repair(filter.shown(), expected, "it is left out");
  return std::nullopt;
}

v1::Texture::Image::Wrap wrap_of(const GltfValue& mode) {
  constexpr uint64_t kClamp = 33071, kMirror = 33648, kRepeat = 10497;
  const uint64_t number = mode.whole().value_or(kRepeat);
  if (number == kClamp) return v1::Texture::Image::CLAMP;
  if (number == kMirror) return v1::Texture::Image::MIRROR;
  if (number == kRepeat) return v1::Texture::Image::REPEAT;
  mode.repair(fmt::format("{}", number), "33071 (clamp), 33648 (mirror) or 10497 (repeat)",
              "10497 is taken");
  return v1::Texture::Image::REPEAT;
}

}  // namespace

void GltfTextures::sample(const GltfValue& sampler, v1::Texture::Image& image) {
  image.set_wrap_s(wrap_of(sampler["wrapS"]));
  image.set_wrap_t(wrap_of(sampler["wrapT"]));
  const auto near = filter_of(sampler["magFilter"], kLinear, "9728 or 9729");
  const auto far = filter_of(sampler["minFilter"], 9987, "9728, 9729 or 9984 to 9987");
  if (near == kNearest)
    image.set_filter(v1::Texture::Image::NEAREST);
  else if (far == kNearest || far == kLinear)
    image.set_filter(v1::Texture::Image::BILINEAR);
}

/// KHR_texture_transform: translation * rotation * scale of coordinates whose v runs down; ours
/// runs up, so the matrix is turned over on both sides.
void GltfTextures::place(const GltfValue& transform, v1::Texture& texture) {
  if (!transform) return;
  const auto offset = transform["offset"].numbers({0, 0}),
             scale = transform["scale"].numbers({1, 1});
  const double angle = std::fmod(transform["rotation"].number(0), 2 * portable::kPi);
  const double c = portable::cos(angle), s = portable::sin(angle);
  const double a = c * scale[0], b = s * scale[1], d = -s * scale[0], e = c * scale[1];
  v1::Matrix& matrix = *texture.mutable_transform()->add_steps()->mutable_matrix();
  for (const double value :
       {a, -b, 0., offset[0] + b, -d, e, 0., 1 - e - offset[1], 0., 0., 1., 0.})
    matrix.add_rows(value);
}

std::string GltfTextures::picture(const GltfValue& image, size_t index) {
  constexpr std::string_view kLeftOut = "the picture is left out";
  const auto [known, is_new] = pictures_.try_emplace(index);
  if (!is_new) return known->second;
  const GltfValue uri = image["uri"];
  std::optional<std::string> bytes;
  if (const std::string text = uri.text(""); !text.empty()) {
    if (auto data = read_data_uri(text)) {
      if (!data->problem.empty()) {
        uri.repair(data->problem, data->expected, kLeftOut);
        return "";
      }
      bytes = std::move(data->bytes);
    }
  } else {
    const GltfValue place = image["bufferView"];
    if (!place) image.repair("no picture", "a uri or a bufferView", kLeftOut);
    const auto view = place.index(file_.root()["bufferViews"].size(), "buffer view", kLeftOut);
    if (view) file_.attempt(kLeftOut, [&] { bytes = file_.view(*view).bytes; });
    if (!bytes) return "";
    file_.spend(bytes->size(), image);
  }
  std::string name =
      fmt::format("{}#images/{}", std::filesystem::path(file_.name()).filename().string(), index);
  if (!bytes && !file_.attempt(kLeftOut, [&] { name = GltfFile::path_of_uri(uri); })) return "";
  const std::string problem = check_ ? check_(name, bytes ? &*bytes : nullptr) : "";
  if (!problem.empty()) {
    warnings_.missing(fmt::format("picture '{}' {}", name, problem), [&] { return image.place(); });
    return "";
  }
  if (bytes) out_.pictures[name] = std::move(*bytes);
  return known->second = name;
}

/// The first image of a texture that can be read.
std::optional<size_t> GltfTextures::readable_image(const GltfValue& texture) {
  const GltfValue webp = texture["extensions"]["EXT_texture_webp"]["source"];
  const GltfValue images = file_.root()["images"];
  bool is_given = false;
  for (const GltfValue& source : {webp, texture["source"]}) {
    const auto index = source.index(images.size(), "image");
    if (!index) continue;
    is_given = true;
    if (!picture(images.at(*index), *index).empty()) return index;
  }
  if (!is_given) warnings_.add("textures without an image that is read are left out");
  return std::nullopt;
}

v1::Texture::Mapping GltfTextures::mapping(const GltfValue& info, GltfUvSets& sets) {
  constexpr size_t kMost = 2;
  const GltfValue moved = info["extensions"]["KHR_texture_transform"]["texCoord"];
  const size_t set = (moved ? moved : info["texCoord"]).whole().value_or(0);
  if (sets.size() < kMost && std::find(sets.begin(), sets.end(), set) == sets.end())
    sets.push_back(set);
  if (set == sets.front()) return v1::Texture::UV;
  if (set != sets.back())
    warnings_.add(
        "a material has more than two sets of texture coordinates; the second stands for the rest",
        [&] { return info.place(); });
  return v1::Texture::SECOND_UV;
}

std::string GltfTextures::use(const GltfValue& info, v1::Texture::Image::Encoding encoding,
                              GltfUvSets& sets) {
  if (!info) return "";
  const GltfValue which = info["index"];
  if (!which) info.repair("no texture", "its index", "it is left out");
  const auto index = which.index(file_.root()["textures"].size(), "texture");
  if (!index) return "";
  used_.insert(*index);
  const GltfValue in = file_.element("textures", *index);
  const auto source = readable_image(in);
  if (!source) return "";
  const GltfValue source_image = file_.element("images", *source);
  v1::Texture texture;
  v1::Texture::Image& image = *texture.mutable_image();
  image.set_file(picture(source_image, *source));
  set_integer_encoding(encoding, image);
  const auto sampler = in["sampler"].index(file_.root()["samplers"].size(), "sampler");
  if (sampler) sample(file_.element("samplers", *sampler), image);
  place(info["extensions"]["KHR_texture_transform"], texture);
  texture.set_mapping(mapping(info, sets));
  const std::string name = in["name"].text(source_image["name"].text(""));
  texture.set_name(name.empty() ? fmt::format("texture {}", *index) : name);
  return textures_.add(std::move(texture));
}

}  // namespace tessera
