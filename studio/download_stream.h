#pragma once

#include <cstdint>
#include <functional>
#include <list>
#include <memory>
#include <string>

#include "studio/picture_stream.h"

namespace tessera {

/// Sends files to pages in chunks, as fast as each page takes them. Used by one thread.
class DownloadStream {
 public:
  static constexpr size_t kChunkBytes = size_t{1} << 20;

  /// `sink_of` gives null for a page that is gone.
  explicit DownloadStream(PictureStream::Sinks sink_of) : sink_of_(std::move(sink_of)) {}

  /// Begins to send the file, and returns the number that its chunks have.
  uint32_t add(ClientId client, std::shared_ptr<const std::string> content);
  /// Sends what the pages take. Returns whether there is more.
  bool catch_up();

 private:
  struct Download {
    ClientId client = 0;
    uint32_t number = 0;
    std::shared_ptr<const std::string> content;
    size_t sent = 0;
  };
  /// Whether it is at its end, or the page is gone.
  bool advance(Download& download);

  PictureStream::Sinks sink_of_;
  std::list<Download> downloads_;
  uint32_t last_number_ = 0;
};

}  // namespace tessera
