#pragma once

#include <cstdint>
#include <memory>
#include <span>
#include <vector>

#include "renderer/math/color.h"
#include "renderer/math/transform.h"
#include "renderer/math/vec.h"
#include "renderer/shading/image_texture.h"

namespace tessera {

/// A place that a texture can be looked up at, and two vectors that span the patch around it which
/// one sample stands for; zero where that is not known.
struct TextureCoordinate {
  Vec3 at;
  Vec3 a, b;
};

/// The places of one surface point by every mapping.
struct TexturePoint {
  TextureCoordinate uv, second_uv, object, world;
  Vec3 object_normal, view_normal;  ///< unit
};

enum class TextureMapping : uint8_t { uv, second_uv, object, world, object_normal, view_normal };
enum class TextureKind : uint8_t { image, checker, noise, gradient };
enum class NoiseKind : uint8_t { perlin, turbulence, marble, wood };

inline constexpr uint32_t kNoTexture = 0xffffffffu;

/// A colour, or its product with a texture of the scene.
struct TexturedColor {
  Color value = kWhite;
  uint32_t texture = kNoTexture;  ///< into the scene's textures
};

/// A colour and an opacity for every place. Immutable once built; thread-safe.
struct Texture {
  TextureKind kind = TextureKind::gradient;
  TextureMapping mapping = TextureMapping::uv;
  Affine transform{};  ///< acts on the coordinate
  std::shared_ptr<const ImageTexture> image{};
  TexturedColor odd{kBlack}, even{kWhite};  ///< of a checker
  /// Of noise; `frequency` per unit of the coordinate, 1 to 16 octaves.
  NoiseKind noise = NoiseKind::perlin;
  Color low = kBlack, high = kWhite;
  double frequency = 1, strength = 1;
  uint32_t octaves = 1;
  /// Of a gradient: increasing positions, one colour each, at least one.
  std::vector<double> positions{};
  std::vector<Color> colors{};

  bool has_color() const { return kind != TextureKind::image || image->settings().has_color(); }
  bool has_alpha() const { return kind == TextureKind::image && image->settings().has_alpha(); }
};

/// The texture's value at `point`. `all` are the scene's textures, which a checker may name; none
/// names itself, however indirectly.
Texel look_up(const Texture& texture, const TexturePoint& point, std::span<const Texture> all);

}  // namespace tessera
