// The image codec's module for all that its program does not do by itself: the only code that links
// OpenImageIO, whose hundreds of libraries take 0.2 s to load.
#include <OpenImageIO/color.h>
#include <OpenImageIO/imagebuf.h>
#include <OpenImageIO/imagebufalgo.h>
#include <OpenImageIO/imageio.h>
#include <sys/mman.h>
#include <sys/stat.h>
#include <unistd.h>

#include <algorithm>
#include <cerrno>
#include <cstdlib>
#include <cstring>
#include <memory>
#include <string>
#include <utility>
#include <vector>

#include "base/error.h"
#include "renderer/image/plain/icc_profile.h"
#include "renderer/image/plain/image_answer.h"
#include "renderer/image/plain/plain_formats.h"

namespace tessera {

namespace {

/// The path of a descriptor of this process, under which the sandbox lets memory be opened.
std::string path_of(int descriptor) {
  return OIIO::Strutil::sprintf("/proc/self/fd/%d", descriptor);
}

/// A file in memory for the encoders, which write files only: several of them take a full disk for
/// success, and one ends the process.
class MemoryFile {
 public:
  MemoryFile() : file_(memfd_create("picture", MFD_CLOEXEC)) {
    if (file_ < 0) fail_image(std::strerror(errno));
  }
  MemoryFile(const MemoryFile&) = delete;
  MemoryFile& operator=(const MemoryFile&) = delete;
  ~MemoryFile() { close(file_); }

  std::string path() const { return path_of(file_); }

  /// A limit on file sizes, which holds here too, shows now.
  void check_room(uint64_t bytes) const {
    if (ftruncate(file_, static_cast<off_t>(bytes)) != 0 || ftruncate(file_, 0) != 0) {
      fail_image(std::strerror(errno));
    }
  }

  std::vector<char> bytes() const {
    struct stat status {};
    if (fstat(file_, &status) != 0) fail_image(std::strerror(errno));
    std::vector<char> bytes(static_cast<size_t>(status.st_size));
    for (size_t at = 0; at < bytes.size();) {
      const ssize_t got =
          pread(file_, bytes.data() + at, bytes.size() - at, static_cast<off_t>(at));
      if (got <= 0) fail_image(std::strerror(errno));
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
  const std::string names = request.channel_names;
  if (!names.empty()) {
    spec.channelnames = OIIO::Strutil::splits(names, ",");
    if (spec.channelnames.size() != static_cast<size_t>(spec.nchannels)) {
      fail_image("the channels do not fit their names");
    }
  }
  spec.attribute("oiio:ColorSpace", is_float ? "Linear" : "sRGB");
  for (const auto& [name, text] : image_texts(request.attributes)) {
    spec.attribute(name == "Description" ? "ImageDescription" : name, text);
  }
  // Else OpenImageIO says when it was written, and the same picture is another file each time.
  spec.attribute("DateTime", "");
  return spec;
}

ImageAnswer encode(const ImageRequest& request, const std::vector<char>& pixels) {
  if (!request.layout.is_legal(PixelLayout::kMostChannels) ||
      request.layout.bytes() != pixels.size()) {
    fail_image("the pixels do not fit their layout");
  }
  const MemoryFile file;
  file.check_room(most_encoded_bytes(pixels.size()));
  const auto output = OIIO::ImageOutput::create(request.format);
  if (!output) fail_image(OIIO::geterror());
  OIIO::ImageSpec spec = make_spec(request);
  if (output->supports("displaywindow")) set_window(request.window, spec);
  if (!output->open(file.path(), spec) || !output->write_image(spec.format, pixels.data()) ||
      !output->close()) {
    fail_image(output->geterror());
  }
  ImageAnswer answer{{}, file.bytes()};
  if (answer.payload.empty()) fail_image("the encoder wrote nothing");
  return answer;
}

/// Room for a picture of the layout in `answer`, whose size is checked first.
void* make_room(ImageAnswer& answer, int most_channels) {
  if (!answer.layout.is_legal(most_channels)) fail_image("its size is out of range");
  answer.payload.resize(answer.layout.bytes());
  return answer.payload.data();
}

/// A reader of that format alone, whatever the file may be, which leaves colours as it has them.
std::unique_ptr<OIIO::ImageInput> open(const std::string& format, int file) {
  // Asked for a format that it does not have, OpenImageIO would try all that it has.
  const auto formats = OIIO::Strutil::splits(OIIO::get_string_attribute("input_format_list"), ",");
  if (std::find(formats.begin(), formats.end(), format) == formats.end()) {
    fail_image("OpenImageIO is built without the format '" + format + "' here");
  }
  auto input = OIIO::ImageInput::create(format);
  if (!input) fail_image(OIIO::geterror());
  OIIO::ImageSpec config, spec;
  config.attribute("oiio:UnassociatedAlpha", 1);
  if (!input->open(path_of(file), spec, config)) fail_image(input->geterror());
  return input;
}

/// The first channels, as many as the layout has, which it checks.
void read_pixels(OIIO::ImageInput& input, OIIO::TypeDesc type, int most_channels,
                 ImageAnswer& answer) {
  void* const pixels = make_room(answer, most_channels);
  // Some readers fill in what a truncated file lacks, and merely say so.
  if (!input.read_image(0, 0, 0, answer.layout.channels, type, pixels) || input.has_error()) {
    fail_image(input.geterror());
  }
}

ImageAnswer decode_all(const std::string& format, int file) {
  const auto input = open(format, file);
  const OIIO::ImageSpec& spec = input->spec();
  ImageAnswer answer{{spec.width, spec.height, spec.nchannels, 32}, {}};
  read_pixels(*input, OIIO::TypeDesc::FLOAT, PixelLayout::kMostChannels, answer);
  std::string names;
  for (int i = 0; i < spec.nchannels; ++i) names.append(spec.channel_name(i)).push_back('\0');
  if (spec.channelformat(0).is_floating_point()) names += ImageRequest::kFloats;
  if (names.size() > PixelLayout::kLongestNames) fail_image("its channels have too long names");
  answer.payload.insert(answer.payload.end(), names.begin(), names.end());
  return answer;
}

ImageAnswer decode(const std::string& format, int file, bool to_srgb) {
  const auto input = open(format, file);
  const OIIO::ImageSpec& spec = input->spec();
  // Integers of 16 bits are more than half floats hold.
  const OIIO::TypeDesc type = spec.format == OIIO::TypeDesc::UINT8  ? OIIO::TypeDesc::UINT8
                              : spec.format == OIIO::TypeDesc::HALF ? OIIO::TypeDesc::HALF
                                                                    : OIIO::TypeDesc::FLOAT;
  const int channels = std::min(spec.nchannels, 4);
  ImageAnswer answer{{spec.width, spec.height, channels, static_cast<int>(type.basesize()) * 8},
                     {}};
  read_pixels(*input, type, channels, answer);
  const bool has_colors = answer.layout.bits == 8 && channels >= 3;
  const OIIO::ParamValue* const profile =
      to_srgb && has_colors ? spec.find_attribute("ICCProfile") : nullptr;
  if (profile) {
    const auto conversion =
        SrgbConversion::from({static_cast<const unsigned char*>(profile->data()),
                              static_cast<size_t>(profile->datasize())});
    if (conversion) conversion->convert(answer.payload, static_cast<size_t>(channels));
  }
  return answer;
}

/// `name` if it is among those known; the cause tells them.
void check_name(const char* what, const std::string& name, const std::vector<std::string>& known) {
  if (std::find(known.begin(), known.end(), name) != known.end()) return;
  std::string list;
  for (const std::string& entry : known) list += (list.empty() ? "" : ", ") + entry;
  fail_image("the OpenColorIO configuration has no " + std::string(what) + " '" + name +
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

ImageAnswer convert_colors(const ImageRequest& request, std::vector<char> pixels) {
  const PixelLayout& layout = request.layout;
  const bool fits = layout.is_legal() && layout.channels == 3 && layout.bits == 32 &&
                    layout.bytes() == pixels.size();
  if (!fits) fail_image("the pixels do not fit their layout");
  // Where $OCIO does not name one that can be read, OpenImageIO takes another one.
  const char* const file = std::getenv("OCIO");
  if (!file || !*file) fail_image("$OCIO is not set");
  OIIO::ColorConfig config(file);
  if (config.has_error()) fail_image(config.geterror());
  const OIIO::ColorProcessorHandle processor = color_processor(config, request.colors);
  if (!processor) fail_image(config.geterror());
  OIIO::ImageSpec spec(layout.width, layout.height, 3, OIIO::TypeDesc::FLOAT);
  OIIO::ImageBuf image(spec, pixels.data());
  if (!OIIO::ImageBufAlgo::colorconvert(image, image, processor.get(), false, {}, 1)) {
    fail_image(image.geterror());
  }
  return {layout, std::move(pixels)};
}

}  // namespace

}  // namespace tessera

/// Throws std::exception with the cause. `file`: the memory of a file to decode.
extern "C" __attribute__((visibility("default"))) void tessera_answer_image(
    const tessera::ImageRequest& request, std::vector<char> payload, int file,
    tessera::ImageAnswer& answer) {
  using namespace tessera;
  switch (request.call) {
    case ImageRequest::load:
      return;
    case ImageRequest::encode:
      answer = encode(request, payload);
      return;
    case ImageRequest::decode_all:
      answer = decode_all(request.format, file);
      return;
    case ImageRequest::decode:
      answer = decode(request.format, file, request.to_srgb != 0);
      return;
    case ImageRequest::convert_colors:
      answer = convert_colors(request, std::move(payload));
      return;
  }
  fail_image("the image codec does not know what it is asked for");
}
