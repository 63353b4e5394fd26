#include "renderer/shading/media.h"

#include <algorithm>

namespace tessera {

size_t Media::find(uint32_t instance) const {
  size_t place = count_;
  while (place > 0 && solids_[place - 1].instance != instance) --place;
  return place;
}

void Media::insert(size_t place, const Solid& solid) {
  const auto begin = solids_.begin();
  if (count_ == kMost) {
    if (place == 0) return;
    std::copy(begin + 1, begin + static_cast<ptrdiff_t>(place), begin);
    solids_[place - 1] = solid;
    return;
  }
  std::copy_backward(begin + static_cast<ptrdiff_t>(place), begin + static_cast<ptrdiff_t>(count_),
                     begin + static_cast<ptrdiff_t>(count_) + 1);
  solids_[place] = solid;
  ++count_;
}

void Media::enter(uint32_t instance, const Color& absorption) {
  insert(count_, {instance, &absorption});
}

void Media::leave(uint32_t instance) {
  const size_t place = find(instance);
  if (place == 0) return;
  std::copy(solids_.begin() + static_cast<ptrdiff_t>(place),
            solids_.begin() + static_cast<ptrdiff_t>(count_),
            solids_.begin() + static_cast<ptrdiff_t>(place) - 1);
  --count_;
}

void Media::note_inside(uint32_t instance, const Color& absorption) {
  const size_t place = find(instance);
  if (place == 0) {
    insert(0, {instance, &absorption});
  } else {
    solids_[place - 1].absorption = &absorption;
  }
}

}  // namespace tessera
