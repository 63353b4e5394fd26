#include "renderer/accel/plane_soa.h"

#include "base/error.h"

namespace tessera {

void PlaneSoA::add(const Plane& plane, Cull cull) {
  TESSERA_CHECK(count < kMost, "more planes than fit");
  for (int a = 0; a < 3; ++a) normal[a][count] = plane.normal()[a];
  offset[count] = plane.offset();
  if (cull != Cull::front) from_front |= 1u << count;
  if (cull != Cull::back) from_behind |= 1u << count;
  ++count;
}

}  // namespace tessera
