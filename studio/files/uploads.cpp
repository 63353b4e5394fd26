#include "studio/files/uploads.h"

#include <fmt/format.h>

#include <algorithm>

#include "base/error.h"
#include "studio/files/file_kind.h"

namespace tessera {

void Uploads::begin(uint64_t owner, uint32_t number, const std::string& name, uint64_t size) {
  if (!is_read_by_scenes(name))
    throw render_error(
        fmt::format("'{}' is no file of a kind that is read: a scene, a model or a picture", name));
  if (size > kMostBytes)
    throw render_error(
        fmt::format("'{}' has {} bytes; expected at most {} MiB", name, size, kMostBytes >> 20));
  const auto is_mine = [owner](const auto& each) { return each.first.first == owner; };
  if (std::count_if(open_.begin(), open_.end(), is_mine) >= static_cast<std::ptrdiff_t>(kMostOpen))
    throw render_error(fmt::format("'{}': {} files are on their way already", name, kMostOpen));
  const std::string free = folder_.free_name(name);
  const auto [at, is_new] =
      open_.try_emplace({owner, number}, Upload{folder_.start(free), free, size, 0});
  if (!is_new) throw render_error(fmt::format("'{}': number {} is taken", name, number));
}

Uploads::State Uploads::append(uint64_t owner, uint32_t number, std::string_view bytes,
                               bool is_last) {
  auto taken = open_.extract({owner, number});
  if (taken.empty()) throw render_error(fmt::format("no file with number {} is expected", number));
  Upload& upload = taken.mapped();
  const uint64_t received = upload.received + bytes.size();
  if (received > upload.size || (is_last && received != upload.size))
    throw render_error(
        fmt::format("'{}': {} bytes came; expected {}", upload.name, received, upload.size));
  upload.file.append(bytes);
  upload.received = received;
  State state{upload.name, received, is_last};
  if (is_last) {
    upload.file.finish();
  } else {
    open_.insert(std::move(taken));
  }
  return state;
}

void Uploads::drop(uint64_t owner) {
  std::erase_if(open_, [owner](const auto& each) { return each.first.first == owner; });
}

}  // namespace tessera
