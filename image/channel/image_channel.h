#pragma once

#include <cstddef>
#include <cstdint>
#include <functional>
#include <optional>
#include <string>
#include <string_view>
#include <utility>

namespace tessera {

/// Pixels as they lie in memory: rows from the top, tightly packed.
struct PixelLayout {
  int32_t width = 0, height = 0;
  int32_t channels = 0;
  int32_t bits = 0;  ///< of a channel: 8 unsigned, 32 float; 16 to encode unsigned, else half float

  uint64_t bytes() const;
  /// Whether the sides are in 1..kMostSide, the pixels at most kMostPixels, their numbers at most
  /// four times as many, the channels in 1..most_channels and the bits one of the three.
  bool is_legal(int32_t most_channels = 4) const;

  static constexpr int32_t kMostSide = 65536;
  static constexpr int64_t kMostPixels = int64_t{1} << 28;
  static constexpr int32_t kMostChannels = 1024;  ///< of any file
  static constexpr uint64_t kLongestNames = 64 * 1024;
};

/// No encoder makes more of so many bytes of incompressible pixels, headers included.
constexpr uint64_t most_encoded_bytes(uint64_t pixel_bytes) { return 2 * pixel_bytes + 64 * 1024; }

/// Where the pixels lie in the frame that they were cropped from.
struct ImageWindow {
  int32_t x = 0, y = 0;                       ///< of the first pixel
  int32_t frame_width = 0, frame_height = 0;  ///< 0: the pixels are the frame
};

/// What an image tells of its making. Texts end with a zero.
struct ImageAttributes {
  char software[32] = {};
  char scene_digest[72] = {};
  char denoiser[40] = {};  ///< empty: none
  char colors[24] = {};    ///< what the scene's numbers stand for
  uint32_t seed = 0;
  uint32_t samples_per_pixel = 0;
};

/// Names of the OpenColorIO configuration in $OCIO. Texts end with a zero.
struct ColorNames {
  char input[128] = {};        ///< the colour space of the pixels, or its role
  char display[128] = {};      ///< empty: the configuration's default
  char view[128] = {};         ///< empty: the display's default
  char color_space[128] = {};  ///< if not empty, what is asked for in place of a view
};

/// Asks the image codec, a process of its own, for one thing. Both ends are of one build and of one
/// machine, so messages are structs as they lie in memory, each followed by its payload. A file to
/// decode comes as the descriptor of sealed memory instead: the codec opens no file by itself.
struct ImageRequest {
  enum Call : uint32_t {
    encode,      ///< payload: pixels, 3 channels, 4 with alpha or those named, colours multiplied
                 ///< by alpha if they are floats; the reply: the file's bytes
    decode_all,  ///< of a file: all channels in the fewest bits that hold them, and their names
    decode,      ///< of a file: its color_channels_of() in the fewest bits that hold them, and the
                 ///< names of the other channels
    convert_colors,  ///< payload: pixels of 3 floats; the reply: the same by OpenColorIO
    load             ///< gets no reply: OpenImageIO will be needed, and takes a while to load
  };
  uint32_t version = kVersion;
  Call call = encode;
  char format[16] = {};  ///< encode, decode: as OpenImageIO calls it
  PixelLayout layout;    ///< encode, convert_colors
  ImageWindow window;    ///< encode
  ImageAttributes attributes;
  char channel_names[256] = {};  ///< encode: separated by commas; empty: R, G, B, A
  ColorNames colors;             ///< convert_colors
  uint32_t to_srgb = 0;          ///< decode: an embedded colour profile is heeded
  uint64_t payload_bytes = 0;    ///< or, of a file to decode, those of the memory

  bool decodes() const { return call == decode_all || call == decode; }
  static constexpr uint32_t kVersion = 17;
};

/// The program's argument where it shall convert colours, for which it may read files, and decode
/// none.
inline constexpr const char* kConvertsColors = "colors";

/// Before the payload, which follows or, where it `is_shared`, is all of the memory that comes with
/// this: sealed, so that nobody can change it. Then come names of channels.
struct ImageReply {
  uint32_t done = 0;  ///< else the payload is the cause, a text
  uint32_t is_shared = 0;
  uint32_t holds_files = 0, holds_calls = 0;  ///< which halves of its sandbox the codec is in
  PixelLayout layout;
  uint32_t from_integers = 0, is_associated = 0;  ///< of what was decoded, as SampleMeaning
  float gamma = 0;           ///< that a PNG says its codes have, 1 being linear; 0: as sRGB
  char part[64] = {};        ///< of OpenEXR that was read, where it is not the first
  char damage[200] = {};     ///< what is wrong with a file that was read as far as it goes
  uint64_t names_bytes = 0;  ///< of the names of channels, each ended by a zero
  uint64_t payload_bytes = 0;
};

/// One end of the socket pair between a program and its image codec. Blocking; one thread at a
/// time. False: the other end is gone, or `is_alive`, asked whenever the socket's own time limit
/// has passed, says so.
class ImageChannel {
 public:
  explicit ImageChannel(
      int socket, std::function<bool()> is_alive = [] { return true; })
      : socket_(socket), is_alive_(std::move(is_alive)) {}

  template <typename Message>
  bool send(const Message& message, std::string_view payload) {
    return send_bytes(&message, sizeof message) && send_bytes(payload.data(), payload.size());
  }
  /// With `descriptor`, which stays the caller's, and without a payload.
  template <typename Message>
  bool send(const Message& message, int descriptor) {
    return send_with(&message, sizeof message, descriptor);
  }
  /// `descriptor` becomes the caller's; -1: none came.
  template <typename Message>
  bool receive(Message& message, int& descriptor) {
    return receive_with(&message, sizeof message, descriptor);
  }
  bool send_bytes(const void* bytes, size_t size);
  bool receive_bytes(void* bytes, size_t size);

 private:
  bool send_with(const void* bytes, size_t size, int descriptor);
  bool receive_with(void* bytes, size_t size, int& descriptor);
  bool may_go_on() const;

  int socket_;
  std::function<bool()> is_alive_;
};

}  // namespace tessera
