#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

namespace tessera {

/// What a film may hold beside light (arbitrary output variables), in the order of its channels.
/// Of surfaces the first one that a camera ray meets counts; where there is none, all are 0.
///   albedo    the share of light from everywhere that it sends on: mean of the samples
///   normal    for shading, unit, towards the viewer, world axes: mean of the samples
///   depth     metres along the ray of the first sample
///   position  where that ray meets it, metres, world axes
///   id        of the object that it meets there, from 1
///   variance  of the pixel's light as a mean of its samples, by their spread
///   samples   how many the pixel's light is the mean of
///   origin    the nodes that the object stands in, by their numbers (proto/wire/node_numbers.h):
///             the innermost first, of a set operation the operand's; then 0
///   primitive within that object's shape, from 1: of a mesh the row of its triangles, of a box its
///             face, of a set operation those of its operands one after the other
///   alpha     the share of the pixel that is not background as the camera sees it directly, which
///             light then leaves out: colours are multiplied by alpha, as OpenEXR has it. A filter
///             with negative parts may take it a little out of [0, 1]
enum class Aov : uint32_t {
  albedo,
  normal,
  depth,
  position,
  id,
  variance,
  samples,
  origin,
  primitive,
  alpha
};

/// How many nodes `origin` tells at most.
inline constexpr size_t kOriginDepth = 8;

/// The names of --aovs, in the order of Aov: all but alpha, which changes light and is asked for by
/// --transparent-background.
const std::vector<std::string>& aov_names();

/// A set of AOVs. A value; its bits are those of FrameSettings.aovs.
class AovSet {
 public:
  constexpr AovSet() = default;
  /// All of those bits that mean something.
  explicit AovSet(uint32_t bits);
  /// Whether all bits mean something.
  static bool knows(uint32_t bits) { return AovSet(bits).bits() == bits; }
  /// All that leave the channels of light as they are.
  static AovSet all() { return AovSet(bit(Aov::alpha) - 1); }

  AovSet with(Aov aov) const { return AovSet(bits_ | bit(aov)); }
  /// Alpha, if it is among them, and nothing else.
  AovSet only_alpha() const { return AovSet(bits_ & bit(Aov::alpha)); }
  bool has(Aov aov) const { return (bits_ & bit(aov)) != 0; }
  bool empty() const { return bits_ == 0; }
  std::vector<Aov> members() const;
  uint32_t bits() const { return bits_; }
  /// Whether any is of surfaces.
  bool needs_surfaces() const;

  /// Numbers a pixel of a film with these: its light, then each of them.
  int channels() const;
  /// The first channel of one that is among them.
  int first_channel(Aov aov) const;
  /// By which files call the channels: "R", "G", "B", "albedo.R" ...
  std::vector<std::string> channel_names() const;

  friend bool operator==(const AovSet&, const AovSet&) = default;

 private:
  static constexpr uint32_t bit(Aov aov) { return uint32_t{1} << static_cast<uint32_t>(aov); }

  uint32_t bits_ = 0;
};

}  // namespace tessera
