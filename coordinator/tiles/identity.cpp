#include "coordinator/tiles/identity.h"

#include <fmt/format.h>

#include <algorithm>
#include <cstring>
#include <random>
#include <string_view>

#include "base/hex.h"

namespace tessera {
namespace {

std::string id_of(std::string_view what) {
  const Digest digest = Digest::of(what);
  return {reinterpret_cast<const char*>(digest.bytes.data()), kIdBytes};
}

}  // namespace

std::string draw_opening() {
  std::random_device random;
  std::string opening;
  while (opening.size() < kIdBytes) opening += static_cast<char>(random());
  return opening;
}

std::string job_id_of(const std::string& opening, uint64_t number) {
  return id_of(fmt::format("job {} {}", number, opening));
}

std::string frame_id_of(const std::string& job_id, uint64_t frame_number, const Digest& tile_key,
                        int tile_size) {
  return id_of(fmt::format("frame {} {} {} {}", frame_number, tile_key.hex(), tile_size, job_id));
}

std::string id_text(const std::string& id) {
  return hex_text({reinterpret_cast<const uint8_t*>(id.data()), id.size()});
}

uint64_t number_of(const std::string& id) {
  uint64_t number = 0;
  std::memcpy(&number, id.data(), std::min(sizeof number, id.size()));
  return std::max<uint64_t>(number, 1);
}

}  // namespace tessera
