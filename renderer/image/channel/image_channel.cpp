#include "renderer/image/channel/image_channel.h"

#include <sys/socket.h>

#include <algorithm>
#include <cerrno>

namespace tessera {

uint64_t PixelLayout::bytes() const {
  return static_cast<uint64_t>(width) * static_cast<uint64_t>(height) *
         static_cast<uint64_t>(channels) * static_cast<uint64_t>(bits / 8);
}

bool PixelLayout::is_legal(int32_t most_channels) const {
  if (width < 1 || height < 1 || width > kMostSide || height > kMostSide) return false;
  const int64_t pixels = int64_t{width} * height;
  return pixels <= kMostPixels && channels >= 1 && channels <= most_channels &&
         pixels * channels <= 4 * kMostPixels && (bits == 8 || bits == 16 || bits == 32);
}

bool ImageChannel::send_bytes(const void* bytes, size_t size) {
  const char* next = static_cast<const char*>(bytes);
  while (size > 0) {
    const ssize_t sent = ::send(socket_, next, size, MSG_NOSIGNAL);
    if (sent < 0 && may_go_on()) continue;
    if (sent <= 0) return false;
    next += sent;
    size -= static_cast<size_t>(sent);
  }
  return true;
}

bool ImageChannel::receive_bytes(void* bytes, size_t size) {
  char* next = static_cast<char*>(bytes);
  while (size > 0) {
    const ssize_t received = ::recv(socket_, next, size, 0);
    if (received < 0 && may_go_on()) continue;
    if (received <= 0) return false;
    next += received;
    size -= static_cast<size_t>(received);
  }
  return true;
}

void ImageStream::begin(const PixelLayout& layout) {
  left_ = layout.bytes();
  channel_.send(ImageReply{1, layout, *left_}, {});
}

void ImageStream::add(std::string_view pixels) {
  channel_.send_bytes(pixels.data(), pixels.size());
  *left_ -= pixels.size();
}

void ImageStream::end(bool holds) {
  const std::string nothing(size_t{64} << 10, '\0');
  while (*left_ > 0) add(std::string_view(nothing).substr(0, std::min(*left_, nothing.size())));
  channel_.send(ImageVerdict{holds}, {});
  left_.reset();
}

bool ImageChannel::may_go_on() const { return errno == EINTR || (errno == EAGAIN && is_alive_()); }

}  // namespace tessera
