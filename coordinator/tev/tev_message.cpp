#include "coordinator/tev/tev_message.h"

#include <array>
#include <bit>
#include <cstdint>
#include <cstring>
#include <string_view>

namespace tessera {
namespace {

static_assert(std::endian::native == std::endian::little);

enum class Kind : uint8_t { create_image = 4, update_image_v3 = 6 };
constexpr std::array<std::string_view, kFilmChannels> kChannels = {"R", "G", "B"};

class Message {
 public:
  explicit Message(Kind kind) {
    put(uint32_t{0});  // the length
    put(kind);
    put(uint8_t{0});  // takes no focus
  }
  template <typename Number>
  void put(Number number) {
    put_bytes(&number, sizeof number);
  }
  void put(std::string_view text) {
    put_bytes(text.data(), text.size());
    put('\0');
  }
  void put_bytes(const void* bytes, size_t size) {
    const size_t at = bytes_.size();
    bytes_.resize(at + size);
    std::memcpy(bytes_.data() + at, bytes, size);
  }
  void put_channels() {
    put(int32_t{kFilmChannels});
    for (const std::string_view channel : kChannels) put(channel);
  }
  std::vector<std::byte> take() {
    const auto length = static_cast<uint32_t>(bytes_.size());
    std::memcpy(bytes_.data(), &length, sizeof length);
    return std::move(bytes_);
  }

 private:
  std::vector<std::byte> bytes_;
};

}  // namespace

std::vector<std::byte> tev_create_image(const std::string& name, int width, int height) {
  Message message(Kind::create_image);
  message.put(std::string_view(name));
  message.put(int32_t{width});
  message.put(int32_t{height});
  message.put_channels();
  return message.take();
}

std::vector<std::byte> tev_update_image(const std::string& name, const PixelRect& rect,
                                        std::span<const float> values) {
  Message message(Kind::update_image_v3);
  message.put(std::string_view(name));
  message.put_channels();
  for (const int side : {rect.x0, rect.y0, rect.width(), rect.height()}) message.put(int32_t{side});
  for (int64_t channel = 0; channel < kFilmChannels; ++channel) message.put(channel);
  for (int channel = 0; channel < kFilmChannels; ++channel) message.put(int64_t{kFilmChannels});
  message.put_bytes(values.data(), values.size_bytes());
  return message.take();
}

}  // namespace tessera
