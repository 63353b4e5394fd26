#include "renderer/scene/texture_table.h"

#include <fmt/format.h>

#include <algorithm>

#include "base/error.h"
#include "renderer/scene/read_texture.h"

namespace tessera {

namespace {

// A look-up at an edge takes both sides: its cost doubles with every level.
constexpr size_t kDeepest = 8;

[[noreturn]] void fail_too_deep(const Where& place, size_t depth) {
  fail_value(place, "checkers in checkers", fmt::format("{} deep", depth),
             fmt::format("at most {}", kDeepest));
}

}  // namespace

TextureTable::TextureTable(const v1::Scene& scene, const BlobStore& blobs)
    : scene_(scene), blobs_(blobs) {
  for (const v1::Texture& texture : scene.textures()) {
    const Where where{.kind = "texture", .name = texture.name()};
    if (texture.name().empty()) fail_value(where, "name", "empty", "a name");
    if (!by_name_.try_emplace(texture.name(), &texture).second) {
      fail_value(where, "name", "used twice", "a name of its own");
    }
  }
}

const v1::Texture& TextureTable::find(const Where& where, std::string_view field,
                                      const std::string& name) const {
  const auto found = by_name_.find(name);
  if (found != by_name_.end()) return *found->second;
  std::vector<std::string> known;
  for (const v1::Texture& texture : scene_.textures()) known.push_back(texture.name());
  fail_value(where, field, fmt::format("'{}'", name),
             "the name of a texture" + suggestion(name, known));
}

std::shared_ptr<const ImageTexture> TextureTable::read_image(const Where& where,
                                                             const v1::Texture::Image& in) {
  auto image = read_image_texture(where, in, blobs_);
  blob_bytes_[in.texels().digest()] = image->settings().bytes();
  return image;
}

std::shared_ptr<const ImageTexture> TextureTable::use_image(const Where& where,
                                                            std::string_view field,
                                                            const std::string& name) {
  if (!find(where, field, name).has_image()) {
    fail_value(where, field, fmt::format("'{}'", name), "a texture with an image");
  }
  return textures_[use(where, field, name)].image;
}

uint32_t TextureTable::use(const Where& where, std::string_view field, const std::string& name) {
  const v1::Texture& in = find(where, field, name);
  const Where place{.kind = "texture", .name = name};
  if (std::find(active_.begin(), active_.end(), &in) != active_.end()) {
    fail_value(place, "checker", "made of itself", "other textures");
  }
  if (const auto known = used_.find(&in); known != used_.end()) return known->second;
  Texture out;
  read_mapping(place, in, out);
  switch (in.kind_case()) {
    case v1::Texture::kImage:
      out.kind = TextureKind::image;
      out.image = read_image(place, in.image());
      break;
    case v1::Texture::kChecker:
      // Before it goes down: the chain may be as long as the file.
      if (active_.size() >= kDeepest) fail_too_deep(place, active_.size() + 1);
      active_.push_back(&in);
      out.kind = TextureKind::checker;
      out.odd = read(place, "checker.odd", in.checker().odd(), kBlack);
      out.even = read(place, "checker.even", in.checker().even(), kWhite);
      active_.pop_back();
      break;
    default:
      read_pattern(place, in, out);
  }
  const auto index = static_cast<uint32_t>(textures_.size());
  const bool by_second = out.mapping == TextureMapping::second_uv;
  Facts facts{by_second || out.mapping == TextureMapping::uv, by_second};
  for (const uint32_t part : {out.odd.texture, out.even.texture}) {
    if (part == kNoTexture) continue;
    facts.needs_uv |= facts_[part].needs_uv;
    facts.needs_second_uv |= facts_[part].needs_second_uv;
    facts.depth = std::max(facts.depth, facts_[part].depth + 1);
  }
  const auto depth = static_cast<size_t>(facts.depth);
  if (depth > kDeepest) fail_too_deep(place, depth);
  facts_.push_back(facts);
  textures_.push_back(std::move(out));
  used_.emplace(&in, index);
  return index;
}

TexturedColor TextureTable::read(const Where& where, std::string_view field,
                                 const v1::ColorInput& input, const Color& fallback) {
  TexturedColor out{fallback};
  if (!input.texture().empty()) {
    out = {kWhite, use(where, fmt::format("{}.texture", field), input.texture())};
  }
  if (input.has_value()) out.value = checked(where, field, input.value());
  return out;
}

uint64_t TextureTable::texel_bytes() const {
  uint64_t sum = 0;
  for (const auto& [digest, bytes] : blob_bytes_) sum += bytes;
  return sum;
}

}  // namespace tessera
