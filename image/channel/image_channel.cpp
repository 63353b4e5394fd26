#include "image/channel/image_channel.h"

#include <sys/socket.h>
#include <sys/uio.h>

#include <cerrno>
#include <cstring>

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

namespace {

/// A message of one piece that a descriptor may come with.
struct MessageWithDescriptor {
  MessageWithDescriptor(const void* bytes, size_t size) : piece{const_cast<void*>(bytes), size} {
    header.msg_iov = &piece;
    header.msg_iovlen = 1;
    header.msg_control = control;
    header.msg_controllen = sizeof control;
  }
  iovec piece;
  alignas(cmsghdr) char control[CMSG_SPACE(sizeof(int))] = {};
  msghdr header{};
};

}  // namespace

bool ImageChannel::send_with(const void* bytes, size_t size, int descriptor) {
  MessageWithDescriptor message(bytes, size);
  cmsghdr* const control = CMSG_FIRSTHDR(&message.header);
  control->cmsg_level = SOL_SOCKET;
  control->cmsg_type = SCM_RIGHTS;
  control->cmsg_len = CMSG_LEN(sizeof descriptor);
  std::memcpy(CMSG_DATA(control), &descriptor, sizeof descriptor);
  ssize_t sent = -1;
  do {
    sent = sendmsg(socket_, &message.header, MSG_NOSIGNAL);
  } while (sent < 0 && may_go_on());
  return sent > 0 &&
         send_bytes(static_cast<const char*>(bytes) + sent, size - static_cast<size_t>(sent));
}

bool ImageChannel::receive_with(void* bytes, size_t size, int& descriptor) {
  descriptor = -1;
  MessageWithDescriptor message(bytes, size);
  ssize_t received = -1;
  do {
    received = recvmsg(socket_, &message.header, MSG_CMSG_CLOEXEC);
  } while (received < 0 && may_go_on());
  if (received <= 0) return false;
  const cmsghdr* const control = CMSG_FIRSTHDR(&message.header);
  if (control && control->cmsg_level == SOL_SOCKET && control->cmsg_type == SCM_RIGHTS &&
      control->cmsg_len == CMSG_LEN(sizeof descriptor))
    std::memcpy(&descriptor, CMSG_DATA(control), sizeof descriptor);
  return receive_bytes(static_cast<char*>(bytes) + received, size - static_cast<size_t>(received));
}

bool ImageChannel::may_go_on() const { return errno == EINTR || (errno == EAGAIN && is_alive_()); }

}  // namespace tessera
