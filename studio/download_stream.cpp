#include "studio/download_stream.h"

#include <algorithm>
#include <span>

namespace tessera {

uint32_t DownloadStream::add(ClientId client, std::shared_ptr<const std::string> content) {
  downloads_.push_back({client, ++last_number_, std::move(content)});
  return last_number_;
}

bool DownloadStream::catch_up() {
  downloads_.remove_if([this](Download& download) { return advance(download); });
  return !downloads_.empty();
}

bool DownloadStream::advance(Download& download) {
  const auto sink = sink_of_(download.client);
  if (!sink) return true;
  const std::string& content = *download.content;
  do {
    const size_t count = std::min(kChunkBytes, content.size() - download.sent);
    const bool is_last = download.sent + count == content.size();
    const PixelFrame frame{.kind = PixelFrame::Kind::chunk,
                           .serial = download.number,
                           .rect = {},
                           .flags = is_last ? PixelFrame::kLastPieceOfPass : uint16_t{0}};
    const auto* const bytes = reinterpret_cast<const uint8_t*>(content.data()) + download.sent;
    const std::span<const uint8_t> chunk(bytes, count);
    if (!sink->send(std::make_shared<const std::string>(encode_pixel_frame(frame, chunk, false))))
      return false;
    download.sent += count;
  } while (download.sent < content.size());
  return true;
}

}  // namespace tessera
