#include <fmt/format.h>

#include <algorithm>
#include <array>

#include "base/file.h"
#include "base/plural.h"
#include "scenes/formats/x3d/x3d_steps.h"
#include "scenes/formats/x3d/x3d_translator.h"
#include "scenes/import/data_uri.h"
#include "scenes/import/mip_levels.h"
#include "scenes/import/picture_light.h"
#include "scenes/import/to_affine.h"

namespace tessera {
namespace {

constexpr int32_t kMaxPixelSide = 65536;

/// Rows from the top, as blobs have them.
DecodedTexture from_bottom_up(const std::vector<int32_t>& image, uint32_t channels) {
  DecodedTexture out;
  out.width = static_cast<uint32_t>(image[0]);
  out.height = static_cast<uint32_t>(image[1]);
  out.channels = channels;
  std::vector<std::byte> texels;
  texels.reserve(size_t{out.width} * out.height * channels);
  for (size_t row = out.height; row-- > 0;)
    for (size_t x = 0; x < out.width; ++x) {
      const auto pixel = static_cast<uint32_t>(image[3 + row * out.width + x]);
      for (uint32_t c = channels; c-- > 0;) texels.push_back(std::byte(pixel >> (8 * c) & 255));
    }
  out.texels = make_blob(std::move(texels));
  return out;
}

void put_texels(DecodedTexture texture, v1::Texture::Image& image, BlobStore& blobs) {
  const bool is_srgb = image.encoding() == v1::Texture::Image::ENCODING_SRGB;
  image.set_width(texture.width);
  image.set_height(texture.height);
  image.set_channels(texture.channels);
  image.set_bits(texture.bits);
  image.set_levels(
      image.filter() == v1::Texture::Image::TRILINEAR ? add_mip_levels(texture, is_srgb) : 1);
  image.mutable_texels()->set_size(texture.texels->size());
  image.mutable_texels()->set_digest(blobs.put(std::move(texture.texels)).hex());
}

v1::Texture::Image::Wrap wrap_of(const X3dValues& values, const X3dNode& properties,
                                 const char* field, v1::Texture::Image::Wrap otherwise) {
  using Image = v1::Texture::Image;
  constexpr std::array<std::string_view, 5> kModes{"REPEAT", "MIRRORED_REPEAT", "CLAMP",
                                                   "CLAMP_TO_EDGE", "CLAMP_TO_BOUNDARY"};
  constexpr std::array kWraps{Image::REPEAT, Image::MIRROR, Image::CLAMP, Image::CLAMP,
                              Image::CLAMP};
  return values.text(properties, field).empty() ? otherwise
                                                : kWraps[values.choice(properties, field, kModes)];
}

void add_matrix(const Affine& affine, v1::Transform& out) {
  v1::Matrix& matrix = *out.add_steps()->mutable_matrix();
  for (const auto& row : affine.m)
    for (const double value : row) matrix.add_rows(value);
}

}  // namespace

X3dTranslator::Coordinates X3dTranslator::coordinates_of(const X3dNode& geometry,
                                                         const X3dValues& values) {
  const X3dNode* node = geometry.child("texCoord");
  if (!node || node->type != "TextureCoordinateGenerator") return Coordinates::uv;
  using enum Coordinates;
  constexpr std::array<std::string_view, 6> kModes{
      "SPHERE", "COORD", "COORD-EYE", "CAMERASPACEPOSITION", "SPHERE-LOCAL", "CAMERASPACENORMAL"};
  constexpr std::array kMeant{sphere,    coord,        coord_eye,
                              coord_eye, sphere_local, camera_space_normal};
  return kMeant[values.choice(*node, "mode", kModes)];
}

/// The step from what the mapping gives to the coordinate that X3D means comes before all others.
void X3dTranslator::set_coordinates(Coordinates coordinates, v1::Texture& texture) const {
  switch (coordinates) {
    case Coordinates::uv:
      return;
    case Coordinates::coord:
      return texture.set_mapping(v1::Texture::OBJECT);
    case Coordinates::coord_eye:
      texture.set_mapping(v1::Texture::WORLD);
      return add_matrix(inverse(to_affine(build_.view.world_from_camera())),
                        *texture.mutable_transform());
    case Coordinates::sphere:
      return texture.set_mapping(v1::Texture::VIEW_NORMAL);
    case Coordinates::sphere_local:
      return texture.set_mapping(v1::Texture::OBJECT_NORMAL);
    case Coordinates::camera_space_normal:  // n, where the mapping gives (n + 1) / 2
      texture.set_mapping(v1::Texture::VIEW_NORMAL);
      return add_matrix(translation({-1, -1, 0}) * scaling({2, 2, 1}),
                        *texture.mutable_transform());
  }
}

v1::Texture::Image::Encoding X3dTranslator::color_encoding() const {
  return build_.options.x3d_color == ReadOptions::Color::linear
             ? v1::Texture::Image::ENCODING_SRGB
             : v1::Texture::Image::ENCODING_LINEAR;
}

std::string X3dTranslator::main_texture(const Look& look, const X3dNode* material,
                                        const char* field) {
  const X3dNode* own = material ? material->child(field) : nullptr;
  if (!own && look.appearance) own = look.appearance->child("texture");
  return texture(own, look, true);
}

std::string X3dTranslator::texture(const X3dNode* node, const Look& look, bool is_color) {
  if (node && node->type == "MultiTexture") {
    values_.warn(node->offset, "of a MultiTexture only the first texture is read");
    node = node->child("texture")
               ? std::find_if(node->children.begin(), node->children.end(),
                              [](const X3dNode::Child& c) { return c.container == "texture"; })
                     ->node
               : nullptr;
  }
  if (!node || (node->type != "ImageTexture" && node->type != "PixelTexture")) return "";
  const X3dNode* turn = look.appearance ? look.appearance->child("textureTransform") : nullptr;
  if (turn && turn->type == "MultiTextureTransform") {
    const auto& all = turn->children;
    turn = all.empty() ? nullptr : all.front().node;
  }
  if (turn && turn->type != "TextureTransform") turn = nullptr;
  const auto key = std::make_tuple(node, turn, look.coordinates, is_color);
  const auto known = textures_.find(key);
  if (known != textures_.end()) return known->second;

  v1::Texture::Image image;
  set_integer_encoding(is_color ? color_encoding() : v1::Texture::Image::ENCODING_LINEAR, image);
  set_wrapping(*node, image);
  std::string name = node->type == "PixelTexture" ? pixel_texture(*node, std::move(image))
                                                  : image_texture(*node, std::move(image));
  const bool own = !name.empty() && name != build_.placeholder;
  if (own && (turn || look.coordinates != Coordinates::uv)) {
    v1::Texture& made = *out_.scene.mutable_textures()->rbegin();
    if (turn) *made.mutable_transform() = texture_transform(*turn);
    set_coordinates(look.coordinates, made);
  }
  return textures_.emplace(key, name).first->second;
}

void X3dTranslator::set_wrapping(const X3dNode& node, v1::Texture::Image& image) const {
  using Image = v1::Texture::Image;
  image.set_wrap_s(values_.boolean(node, "repeatS", true) ? Image::REPEAT : Image::CLAMP);
  image.set_wrap_t(values_.boolean(node, "repeatT", true) ? Image::REPEAT : Image::CLAMP);
  const X3dNode* properties = node.child("textureProperties");
  if (!properties || properties->type != "TextureProperties") return;
  image.set_wrap_s(wrap_of(values_, *properties, "boundaryModeS", image.wrap_s()));
  image.set_wrap_t(wrap_of(values_, *properties, "boundaryModeT", image.wrap_t()));
  constexpr std::array<std::string_view, 5> kFilters{"DEFAULT", "AVG_PIXEL", "FASTEST", "NICEST",
                                                     "NEAREST_PIXEL"};
  if (values_.choice(*properties, "magnificationFilter", kFilters) == 4)
    image.set_filter(Image::NEAREST);
}

/// C^-1 S R C T: the coordinate is moved, turned and scaled about the centre, so that a scale of 2
/// makes the picture half as large.
v1::Transform X3dTranslator::texture_transform(const X3dNode& node) const {
  const auto pair = [&](const char* name, double otherwise) {
    const auto v = values_.exactly(node, name, 2);
    return v.empty() ? Vec3{otherwise, otherwise, 0} : Vec3{v[0], v[1], 0};
  };
  const Vec3 center = pair("center", 0), scale = pair("scale", 1);
  v1::Transform out;
  add_translation(-center, out);
  if (!(scale == Vec3{1, 1, 0})) put_vec3({scale.x, scale.y, 1}, out.add_steps()->mutable_scale());
  add_rotation({{0, 0, 1}, values_.angle(node, "rotation", 0)}, out);
  add_translation(center, out);
  add_translation(pair("translation", 0), out);
  return out;
}

std::string X3dTranslator::add_texture(v1::Texture texture, const std::string& wish) {
  texture.set_name(build_.unique(build_.texture_names, wish));
  *out_.scene.add_textures() = texture;
  return texture.name();
}

/// Why the URL names no picture; else "", with what Image.file calls it in `out`. `takes_others`:
/// another file may be taken for it.
std::string X3dTranslator::check_picture(const X3dNode& node, const std::string& url,
                                         bool takes_others, Picture& out) {
  const PictureCheck& check = build_.options.check_picture;
  const auto known = build_.data_pictures.find(url);
  if (known != build_.data_pictures.end()) {
    out.file = known->second;
    return "";
  }
  std::string problem;
  std::string compact = url.starts_with("data:") ? url : "";
  std::erase_if(compact, [](char c) { return c == ' ' || c == '\t' || c == '\n' || c == '\r'; });
  if (auto data = read_data_uri(compact)) {
    problem = data->problem;
    const std::string name = fmt::format(
        "{}#picture {}", to_utf8(document_.name().substr(document_.name().rfind('/') + 1)),
        out_.pictures.size() + 1);
    if (problem.empty() && check) problem = check(name, &data->bytes);
    out.is_damaged |= !problem.empty();
    if (!problem.empty()) return problem;
    out_.pictures[name] = std::move(data->bytes);
    out.file = build_.data_pictures[url] = name;
    return "";
  }
  if (!build_.files.has_folder()) {
    out.file = url;
    return "";
  }
  const X3dFiles::Found found = build_.files.find(url, folder_of(node), takes_others);
  if (found.file.empty()) return found.reason;
  if (check) problem = check(build_.files.full(found.file), nullptr);
  out.is_damaged |= !problem.empty();
  if (problem.empty()) out.file = found.file, out.note = found.note;
  return problem;
}

X3dTranslator::Picture X3dTranslator::find_picture(const X3dNode& node,
                                                   const std::vector<std::string>& urls) {
  Picture out;
  for (const std::string& url : urls) {
    const std::string reason = check_picture(node, url, false, out);
    if (reason.empty()) return out;
    out.reasons +=
        fmt::format("{}'{}': {}", out.reasons.empty() ? "" : "; ", X3dFiles::shown(url), reason);
  }
  for (const std::string& url : urls) {
    Picture other;
    if (check_picture(node, url, true, other).empty()) return other;
  }
  return out;
}

/// The first of its URLs that names a picture, else a placeholder and a warning.
std::string X3dTranslator::image_texture(const X3dNode& node, v1::Texture::Image image) {
  const std::vector<std::string> urls = values_.strings(node, "url");
  if (urls.empty()) return "";
  return picture_texture(find_picture(node, urls), std::move(image), node.offset);
}

std::string X3dTranslator::picture_texture(const Picture& picture, v1::Texture::Image image,
                                           size_t offset) {
  if (picture.file.empty()) {
    if (build_.options.x3d_strict)
      throw document_.error(offset, fmt::format("no picture {}", picture.reasons),
                            "a picture that can be read");
    values_.warn(offset, fmt::format("a placeholder stands for the picture {}", picture.reasons));
    return placeholder_texture();
  }
  if (picture.is_damaged)
    values_.warn(
        offset, fmt::format("the picture is '{}', not {}", to_utf8(picture.file), picture.reasons));
  if (!picture.note.empty()) values_.warn(offset, fmt::format("the picture {}", picture.note));
  v1::Texture texture;
  image.set_file(picture.file);
  *texture.mutable_image() = std::move(image);
  return add_texture(std::move(texture), to_utf8(picture.file.substr(picture.file.rfind('/') + 1)));
}

/// Squares of magenta and grey, which no scene wants.
std::string X3dTranslator::placeholder_texture() {
  if (!build_.placeholder.empty()) return build_.placeholder;
  v1::Texture texture;
  v1::Texture::Image& image = *texture.mutable_image();
  set_integer_encoding(color_encoding(), image);
  image.set_filter(v1::Texture::Image::NEAREST);
  put_texels(from_bottom_up({2, 2, 3, 0xFF00FF, 0x808080, 0x808080, 0xFF00FF}, 3), image,
             out_.blobs);
  return build_.placeholder = add_texture(std::move(texture), "missing picture");
}

std::string X3dTranslator::pixel_texture(const X3dNode& node, v1::Texture::Image image) {
  auto [pixels, offsets] = values_.integers(node, "image");
  if (pixels.empty()) return "";
  constexpr std::string_view kLeftOut = "it is left out";
  if (pixels.size() < 3) {
    values_.repair(node, "image", "width, height and components", kLeftOut);
    return "";
  }
  const int32_t width = pixels[0], height = pixels[1], components = pixels[2];
  if (width < 0 || height < 0 || width > kMaxPixelSide || height > kMaxPixelSide ||
      components < 0 || components > 4) {
    values_.repair(node, "image", "sides of 0 to 65536 and 0 to 4 components", kLeftOut);
    return "";
  }
  const size_t count = static_cast<size_t>(width) * static_cast<size_t>(height);
  if (count == 0 || components == 0) return "";
  if (const size_t given = pixels.size() - 3; given != count) {
    // A short text shall not become a large picture.
    const bool is_kept = given >= count / 2;
    values_.repair(node, "image", offsets[0],
                   fmt::format("{} for {} x {}", counted(given, "pixel"), width, height),
                   "one number a pixel",
                   given > count ? "the first ones are taken"
                   : is_kept     ? "the others are 0"
                                 : kLeftOut);
    if (!is_kept) return "";
    pixels.resize(3 + count);
  }
  const uint32_t most = UINT32_MAX >> (32 - 8 * components);
  for (size_t i = 3; i < pixels.size() && i < offsets.size(); ++i)
    if (const auto pixel = static_cast<uint32_t>(pixels[i]); pixel > most)
      values_.repair(node, "image", offsets[i], fmt::format("pixel {}", pixels[i]),
                     fmt::format("0 to {}", most),
                     fmt::format("its low {} bits are taken", 8 * components));
  put_texels(from_bottom_up(pixels, static_cast<uint32_t>(components)), image, out_.blobs);
  v1::Texture texture;
  *texture.mutable_image() = std::move(image);
  return add_texture(std::move(texture), node.def.empty() ? node.type : node.def);
}

/// The picture on one side of a background, from its URL or its texture node.
std::string X3dTranslator::sky_texture(const X3dNode& node, const std::string& side) {
  const std::string urls = side + "Url";
  v1::Texture::Image image;
  set_integer_encoding(color_encoding(), image);
  image.set_wrap_s(v1::Texture::Image::CLAMP);
  image.set_wrap_t(v1::Texture::Image::CLAMP);
  if (const X3dField* field = node.field(urls)) {
    // What is missing shows the colours, which stand behind the pictures for this.
    const auto all = values_.strings(node, urls);
    if (all.empty()) return "";
    const Picture picture = find_picture(node, all);
    if (!picture.file.empty()) return picture_texture(picture, std::move(image), field->offset);
    values_.warn(field->offset, fmt::format("the background has no picture {}", picture.reasons));
    return "";
  }
  const X3dNode* child = node.child(side + "Texture");
  return child ? texture(child, {}, true) : "";
}

}  // namespace tessera
