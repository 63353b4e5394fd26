// The image codec: a process that reads and writes pictures for the one that started it, over the
// socket that is its standard input, until that is closed. The only code that links OpenImageIO:
// whose hundreds of libraries load beside the rendering here, in an address space that nothing else
// waits for, and whose decoders cannot take the renderer down with them.
#include <OpenImageIO/color.h>
#include <OpenImageIO/imagebuf.h>
#include <OpenImageIO/imagebufalgo.h>
#include <OpenImageIO/imageio.h>
#include <OpenImageIO/strutil.h>
#include <sys/mman.h>
#include <sys/resource.h>
#include <sys/stat.h>
#include <unistd.h>

#include <algorithm>
#include <cerrno>
#include <csignal>
#include <cstdlib>
#include <cstring>
#include <exception>
#include <memory>
#include <new>
#include <stdexcept>
#include <string>
#include <utility>
#include <vector>

#include "base/error.h"
#include "renderer/image/channel/image_channel.h"

namespace tessera {

namespace {

struct Answer {
  PixelLayout layout;
  std::vector<char> payload;
};

[[noreturn]] void fail(const std::string& cause) { throw std::runtime_error(cause); }

/// A file in memory for the encoders, which write files only: several of them take a full disk for
/// success, and one ends the process. It serves the decoders the same way.
class MemoryFile {
 public:
  MemoryFile() : file_(memfd_create("picture", MFD_CLOEXEC)) {
    if (file_ < 0) fail(std::strerror(errno));
  }
  MemoryFile(const MemoryFile&) = delete;
  MemoryFile& operator=(const MemoryFile&) = delete;
  ~MemoryFile() { close(file_); }

  std::string path() const { return OIIO::Strutil::sprintf("/proc/self/fd/%d", file_); }

  /// A limit on file sizes, which holds here too, shows now.
  void check_room(uint64_t bytes) const {
    if (ftruncate(file_, static_cast<off_t>(bytes)) != 0 || ftruncate(file_, 0) != 0) {
      fail(std::strerror(errno));
    }
  }

  void fill(const std::vector<char>& bytes) const {
    check_room(bytes.size());
    for (size_t at = 0; at < bytes.size();) {
      const ssize_t written = write(file_, bytes.data() + at, bytes.size() - at);
      if (written <= 0) fail(std::strerror(errno));
      at += static_cast<size_t>(written);
    }
  }

  std::vector<char> bytes() const {
    struct stat status {};
    if (fstat(file_, &status) != 0) fail(std::strerror(errno));
    std::vector<char> bytes(static_cast<size_t>(status.st_size));
    for (size_t at = 0; at < bytes.size();) {
      const ssize_t got =
          pread(file_, bytes.data() + at, bytes.size() - at, static_cast<off_t>(at));
      if (got <= 0) fail(std::strerror(errno));
      at += static_cast<size_t>(got);
    }
    return bytes;
  }

 private:
  int file_;
};

/// For the formats that can tell where a crop lies; the others hold the crop alone.
void set_window(const ImageWindow& window, OIIO::ImageSpec& spec) {
  if (window.frame_width <= 0 || window.frame_height <= 0) return;
  spec.x = window.x;
  spec.y = window.y;
  spec.full_width = window.frame_width;
  spec.full_height = window.frame_height;
}

OIIO::ImageSpec make_spec(const ImageRequest& request) {
  const bool is_float = request.layout.bits == 32;
  OIIO::ImageSpec spec(request.layout.width, request.layout.height, request.layout.channels,
                       is_float ? OIIO::TypeDesc::FLOAT : OIIO::TypeDesc::UINT8);
  spec.attribute("oiio:ColorSpace", is_float ? "Linear" : "sRGB");
  const ImageAttributes& attributes = request.attributes;
  const std::pair<const char*, std::string> texts[] = {
      {"tessera:SceneDigest", attributes.scene_digest},
      {"tessera:Colors", attributes.colors},
      {"tessera:Seed", std::to_string(attributes.seed)},
      {"tessera:Samples", std::to_string(attributes.samples_per_pixel)},
      {"tessera:RenderSeconds", OIIO::Strutil::sprintf("%.3f", attributes.render_seconds)}};
  // Not every format has room for names of ours, and PNG for texts only.
  std::string description;
  for (const auto& [name, text] : texts) {
    spec.attribute(name, text);
    description += OIIO::Strutil::sprintf("%s%s=%s", description.empty() ? "" : " ", name, text);
  }
  spec.attribute("Software", attributes.software);
  spec.attribute("ImageDescription", description);
  return spec;
}

Answer encode(const ImageRequest& request, const std::vector<char>& pixels) {
  if (!request.layout.is_legal() || request.layout.bytes() != pixels.size()) {
    fail("the pixels do not fit their layout");
  }
  const MemoryFile file;
  file.check_room(most_encoded_bytes(pixels.size()));
  const auto output = OIIO::ImageOutput::create(request.format);
  if (!output) fail(OIIO::geterror());
  OIIO::ImageSpec spec = make_spec(request);
  if (output->supports("displaywindow")) set_window(request.window, spec);
  if (!output->open(file.path(), spec) || !output->write_image(spec.format, pixels.data()) ||
      !output->close()) {
    fail(output->geterror());
  }
  Answer answer{{}, file.bytes()};
  if (answer.payload.empty()) fail("the encoder wrote nothing");
  return answer;
}

/// Room for a picture of the layout in `answer`, whose size is checked first.
void* make_room(Answer& answer, int most_channels) {
  if (!answer.layout.is_legal(most_channels)) fail("its size is out of range");
  answer.payload.resize(answer.layout.bytes());
  return answer.payload.data();
}

/// A reader that leaves colours as the file has them.
std::unique_ptr<OIIO::ImageInput> open(const std::string& path) {
  OIIO::ImageSpec config;
  config.attribute("oiio:UnassociatedAlpha", 1);
  auto input = OIIO::ImageInput::open(path, &config);
  if (!input) fail(OIIO::geterror());
  return input;
}

/// The first channels, as many as the layout has, which it checks.
void read_pixels(OIIO::ImageInput& input, OIIO::TypeDesc type, int most_channels, Answer& answer) {
  void* const pixels = make_room(answer, most_channels);
  // Some readers fill in what a truncated file lacks, and merely say so.
  if (!input.read_image(0, 0, 0, answer.layout.channels, type, pixels) || input.has_error()) {
    fail(input.geterror());
  }
}

Answer decode_all(const std::string& path) {
  const auto input = open(path);
  const OIIO::ImageSpec& spec = input->spec();
  Answer answer{{spec.width, spec.height, spec.nchannels, 32}, {}};
  read_pixels(*input, OIIO::TypeDesc::FLOAT, PixelLayout::kMostChannels, answer);
  std::string names;
  for (int i = 0; i < spec.nchannels; ++i) names.append(spec.channel_name(i)).push_back('\0');
  if (names.size() > PixelLayout::kLongestNames) fail("its channels have too long names");
  answer.payload.insert(answer.payload.end(), names.begin(), names.end());
  return answer;
}

Answer decode(const std::string& path) {
  const auto input = open(path);
  const OIIO::ImageSpec& spec = input->spec();
  // Integers of 16 bits are more than half floats hold.
  const OIIO::TypeDesc type = spec.format == OIIO::TypeDesc::UINT8  ? OIIO::TypeDesc::UINT8
                              : spec.format == OIIO::TypeDesc::HALF ? OIIO::TypeDesc::HALF
                                                                    : OIIO::TypeDesc::FLOAT;
  const int channels = std::min(spec.nchannels, 4);
  Answer answer{{spec.width, spec.height, channels, static_cast<int>(type.basesize()) * 8}, {}};
  read_pixels(*input, type, channels, answer);
  return answer;
}

/// `name` if it is among those known; the cause tells them.
void check_name(const char* what, const std::string& name, const std::vector<std::string>& known) {
  if (std::find(known.begin(), known.end(), name) != known.end()) return;
  std::string list;
  for (const std::string& entry : known) list += (list.empty() ? "" : ", ") + entry;
  fail("the OpenColorIO configuration has no " + std::string(what) + " '" + name +
       "'; expected one of " + list + suggestion(name, known));
}

OIIO::ColorProcessorHandle color_processor(const OIIO::ColorConfig& config,
                                           const ColorNames& names) {
  std::vector<std::string> spaces = config.getColorSpaceNames();
  for (const std::string& role : config.getRoles()) spaces.push_back(role);
  check_name("colour space or role", names.input, spaces);
  if (names.color_space[0]) {
    check_name("colour space or role", names.color_space, spaces);
    return config.createColorProcessor(names.input, names.color_space);
  }
  std::string display = names.display, view = names.view;
  if (display.empty()) display = config.getDefaultDisplayName();
  check_name("display", display, config.getDisplayNames());
  if (view.empty()) view = config.getDefaultViewName(display);
  check_name(("view of " + display).c_str(), view, config.getViewNames(display));
  return config.createDisplayTransform(display, view, names.input);
}

Answer convert_colors(const ImageRequest& request, std::vector<char> pixels) {
  const PixelLayout& layout = request.layout;
  const bool fits = layout.is_legal() && layout.channels == 3 && layout.bits == 32 &&
                    layout.bytes() == pixels.size();
  if (!fits) fail("the pixels do not fit their layout");
  // Where $OCIO does not name one that can be read, OpenImageIO takes another one.
  const char* const file = std::getenv("OCIO");
  if (!file || !*file) fail("$OCIO is not set");
  OIIO::ColorConfig config(file);
  if (config.has_error()) fail(config.geterror());
  const OIIO::ColorProcessorHandle processor = color_processor(config, request.colors);
  if (!processor) fail(config.geterror());
  OIIO::ImageSpec spec(layout.width, layout.height, 3, OIIO::TypeDesc::FLOAT);
  OIIO::ImageBuf image(spec, pixels.data());
  if (!OIIO::ImageBufAlgo::colorconvert(image, image, processor.get(), false, {}, 1)) {
    fail(image.geterror());
  }
  return {layout, std::move(pixels)};
}

Answer answer_to(const ImageRequest& request, std::vector<char> payload) {
  if (request.version != ImageRequest::kVersion) fail("the image codec is of another version");
  const auto path = [&payload] { return std::string(payload.begin(), payload.end()); };
  switch (request.call) {
    case ImageRequest::encode:
      return encode(request, payload);
    case ImageRequest::decode_all:
      return decode_all(path());
    case ImageRequest::decode_file:
      return decode(path());
    case ImageRequest::convert_colors:
      return convert_colors(request, std::move(payload));
    case ImageRequest::decode_bytes: {
      const MemoryFile file;
      file.fill(payload);
      return decode(file.path());
    }
  }
  fail("the image codec does not know what it is asked for");
}

/// A file over which a decoder would work for ever ends this process.
void limit_processor_time() {
  constexpr rlim_t kSecondsPerPicture = 120;
  rusage used{};
  rlimit limit{};
  if (getrusage(RUSAGE_SELF, &used) != 0 || getrlimit(RLIMIT_CPU, &limit) != 0) return;
  const auto so_far = static_cast<rlim_t>(used.ru_utime.tv_sec + used.ru_stime.tv_sec);
  limit.rlim_cur = std::min(limit.rlim_max, so_far + kSecondsPerPicture);
  setrlimit(RLIMIT_CPU, &limit);
}

bool serve_one(ImageChannel& channel) {
  ImageRequest request;
  if (!channel.receive(request)) return false;
  limit_processor_time();
  std::vector<char> payload(request.payload_bytes);
  if (!channel.receive_bytes(payload.data(), payload.size())) return false;
  Answer answer;
  std::string cause;
  try {
    answer = answer_to(request, std::move(payload));
  } catch (const std::bad_alloc&) {
    cause = "there is not enough memory for it";
  } catch (const std::exception& error) {
    cause = error.what();
    if (cause.empty()) cause = "OpenImageIO does not tell why";
    std::replace(cause.begin(), cause.end(), '\n', ' ');
  }
  if (!cause.empty()) return channel.send(ImageReply{0, {}, cause.size()}, cause);
  const ImageReply reply{1, answer.layout, answer.payload.size()};
  return channel.send(reply, {answer.payload.data(), answer.payload.size()});
}

}  // namespace

}  // namespace tessera

int main() {
  std::signal(SIGXFSZ, SIG_IGN);
  tessera::ImageChannel channel(STDIN_FILENO);
  while (tessera::serve_one(channel)) {
  }
  // Nothing is left to be written; taking the libraries down in order would only cost time.
  _exit(0);
}
