#pragma once

#include <array>
#include <cstddef>
#include <cstdint>

#include "renderer/shading/material.h"

namespace tessera {

/// Whether what is behind a surface of this material is filled with it, up to the surface's back.
/// What lets light straight through, and takes nothing of it, has alpha or a hole instead.
inline bool fills(const Material& material) {
  return !material.thin && (material.refracted() > 0 || !is_black(material.absorption));
}

/// The solids that a point is inside of. The one that was entered last displaces the others, until
/// it is left. Of more than kMost inside of each other the outermost are forgotten. A value.
class Media {
 public:
  static constexpr size_t kMost = 6;

  Media() = default;
  // Nearly always there are none, or one.
  Media(const Media& other) { *this = other; }
  Media& operator=(const Media& other) {
    count_ = other.count_;
    if (count_ > 0) [[unlikely]]
      solids_ = other.solids_;
    return *this;
  }

  /// Per metre.
  const Color& absorption() const { return count_ == 0 ? kBlack : *solids_[count_ - 1].absorption; }

  /// `absorption` is of the scene, whose solids are told by their instances.
  void enter(uint32_t instance, const Color& absorption);
  void leave(uint32_t instance);
  /// What a ray from here finds out by meeting the back of a surface: that it is inside of this
  /// solid, around all others if that was not known; and what fills it there.
  void note_inside(uint32_t instance, const Color& absorption);

 private:
  struct Solid {
    uint32_t instance;
    const Color* absorption;
  };
  /// One behind the place of the innermost of that instance; 0: there is none.
  size_t find(uint32_t instance) const;
  void insert(size_t place, const Solid& solid);

  uint32_t count_ = 0;
  std::array<Solid, kMost> solids_;
};

}  // namespace tessera
