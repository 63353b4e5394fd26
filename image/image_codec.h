#pragma once

#include <sys/types.h>

#include <functional>
#include <mutex>
#include <optional>
#include <string>
#include <vector>

#include "base/blob.h"
#include "base/error.h"
#include "base/owned_descriptor.h"
#include "image/channel/image_channel.h"
#include "image/channel/sealed_memory.h"
#include "renderer/math/stored_samples.h"

namespace tessera {

/// Our end of the image codec: starts its process when it is first needed, and again after it has
/// crashed over a file. One for the whole program, since its libraries take so long to load; the
/// process lives no longer. Any thread; calls wait for one another.
class ImageCodec {
 public:
  static ImageCodec& shared();
  /// Another process, for convert_colors alone: files that an OpenColorIO configuration names can
  /// be anywhere, and nothing that decodes other people's files may open any.
  static ImageCodec& for_colors();

  /// Throws a render error where its program is missing.
  static void check_installed();
  /// Starts the process without waiting for it; where `loads_all`, with OpenImageIO, which takes
  /// 0.2 s to load.
  void start(bool loads_all);

  struct Answer {
    PixelLayout layout;
    BlobData payload;
    SampleMeaning meaning{};           ///< of what was decoded
    std::vector<std::string> names{};  ///< of channels
    std::string part{};                ///< as ImageReply has it
    std::string damage{};              ///< likewise
    float gamma = 0;                   ///< likewise
  };
  /// What the codec answers in place of what it was asked for: its cause, as a render error.
  struct Refusal : Error {
    using Error::Error;
  };
  /// `request.payload_bytes` is filled in. Throws Refusal, or a render error where no answer comes.
  Answer call(ImageRequest request, std::string_view payload);
  /// Has `file` decoded, which is sealed; under the same conditions.
  Answer decode(ImageRequest request, SealedMemory file);

  ImageCodec(const ImageCodec&) = delete;
  ImageCodec& operator=(const ImageCodec&) = delete;
  ~ImageCodec();

 private:
  explicit ImageCodec(bool converts_colors) : converts_colors_(converts_colors) {}
  /// How a request goes to the process; false: it is gone.
  using Sending = std::function<bool(ImageChannel&)>;
  Answer call_by(const ImageRequest& request, const Sending& send);
  void start_locked();
  /// Nothing: it is not all there.
  std::optional<Answer> receive_answer(ImageChannel& channel, const ImageRequest& request);
  /// Nothing: the process is gone.
  std::optional<Answer> try_call(const ImageRequest& request, const Sending& send);
  void tell_sandbox(const ImageReply& reply);
  /// Waits for the process, which is ending or made to; its status as waitpid() tells it.
  int end_locked();

  const bool converts_colors_;
  std::string configuration_;  ///< as color_configuration(), that the process has
  std::mutex mutex_;
  pid_t process_ = 0;           ///< 0: not running
  bool loads_all_ = false;      ///< it was told to
  bool knows_sandbox_ = false;  ///< what it lacks has been logged
  OwnedDescriptor socket_;
};

}  // namespace tessera
