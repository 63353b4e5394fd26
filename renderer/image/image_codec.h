#pragma once

#include <sys/types.h>

#include <mutex>
#include <optional>
#include <string>

#include "base/blob.h"
#include "base/error.h"
#include "base/owned_descriptor.h"
#include "renderer/image/channel/image_channel.h"

namespace tessera {

/// Our end of the image codec: starts its process when it is first needed, and again after it has
/// crashed over a file. One for the whole program, since its libraries take so long to load; the
/// process lives no longer. Any thread; calls wait for one another.
class ImageCodec {
 public:
  static ImageCodec& shared();

  /// Throws a render error where its program is missing.
  static void check_installed();
  /// Starts the process without waiting for it; where `loads_all`, with OpenImageIO, which takes
  /// 0.2 s to load.
  void start(bool loads_all);

  struct Answer {
    PixelLayout layout;
    BlobData payload;
  };
  /// What the codec answers in place of what it was asked for: its cause, as a render error.
  struct Refusal : Error {
    using Error::Error;
  };
  /// `request.payload_bytes` is filled in. Throws Refusal, or a render error where no answer comes.
  Answer call(ImageRequest request, std::string_view payload);

  ImageCodec(const ImageCodec&) = delete;
  ImageCodec& operator=(const ImageCodec&) = delete;
  ~ImageCodec();

 private:
  ImageCodec() = default;
  void start_locked();
  /// Nothing: it is not all there.
  static std::optional<Answer> receive_answer(ImageChannel& channel, const ImageRequest& request);
  /// Nothing: the process is gone.
  std::optional<Answer> try_call(const ImageRequest& request, std::string_view payload);
  /// Waits for the process, which is ending or made to; its status as waitpid() tells it.
  int end_locked();

  std::mutex mutex_;
  pid_t process_ = 0;       ///< 0: not running
  bool loads_all_ = false;  ///< it was told to
  OwnedDescriptor socket_;
};

}  // namespace tessera
