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
#include <array>
#include <cerrno>
#include <cstdlib>
#include <cstring>
#include <memory>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "base/error.h"
#include "image/plain/icc_profile.h"
#include "image/plain/image_answer.h"
#include "image/plain/plain_formats.h"
#include "renderer/math/stored_samples.h"

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
  void check_size(uint64_t bytes) const {
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
  const auto type = is_float                    ? OIIO::TypeDesc::FLOAT
                    : request.layout.bits == 16 ? OIIO::TypeDesc::UINT16
                                                : OIIO::TypeDesc::UINT8;
  OIIO::ImageSpec spec(request.layout.width, request.layout.height, request.layout.channels, type);
  if (!is_float) spec.attribute("oiio:UnassociatedAlpha", 1);
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
  file.check_size(most_encoded_bytes(pixels.size()));
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

/// Memory for a picture of the layout in `answer`, whose size is checked first.
void* make_pixels(ImageAnswer& answer, int most_channels) {
  if (!answer.layout.is_legal(most_channels)) fail_image("its size is out of range");
  answer.payload.resize(answer.layout.bytes());
  return answer.payload.data();
}

/// What a fourth channel that OpenImageIO calls A is.
enum class Alpha {
  coverage,
  coverage_if_any,  ///< where no header says what it is: nothing, if it is 0 all over
  nothing,
};

/// A file that is read.
struct Picture {
  std::unique_ptr<OIIO::ImageInput> input;
  std::string format;
  Alpha alpha = Alpha::coverage;

  const OIIO::ImageSpec& spec() const { return input->spec(); }
};

/// What the header of a Windows bitmap says of the fourth byte of a pixel.
Alpha alpha_of_bitmap(int file) {
  constexpr uint32_t kBitFields = 3;       // BITMAPINFOHEADER, biCompression
  constexpr uint32_t kWithAlphaMask = 56;  // bytes of the first header that has a mask for alpha
  std::array<uint8_t, 70> header{};
  if (pread(file, header.data(), header.size(), 0) != static_cast<ssize_t>(header.size())) {
    return Alpha::coverage_if_any;
  }
  const auto number_at = [&](size_t at) {
    return uint32_t{header[at]} | uint32_t{header[at + 1]} << 8 | uint32_t{header[at + 2]} << 16 |
           uint32_t{header[at + 3]} << 24;
  };
  if (number_at(30) != kBitFields || number_at(14) < kWithAlphaMask) return Alpha::coverage_if_any;
  return number_at(66) == 0 ? Alpha::nothing : Alpha::coverage;
}

/// What the attributes type of Truevision TGA 2.0 says. Version 1 has none.
Alpha alpha_of_targa(const OIIO::ImageSpec& spec) {
  constexpr int kUseful = 3;
  // OpenImageIO tells a type of 3, or an alpha that the header of version 1 has, by that attribute.
  if (spec.get_int_attribute("oiio:UnassociatedAlpha") != 0) return Alpha::coverage;
  if (spec.get_int_attribute("targa:version") < 2) return Alpha::coverage_if_any;
  return spec.get_int_attribute("targa:alpha_type") < kUseful ? Alpha::nothing : Alpha::coverage;
}

Alpha alpha_of(const std::string& format, const OIIO::ImageSpec& spec, int file) {
  if (format == "bmp") return alpha_of_bitmap(file);
  return format == "targa" ? alpha_of_targa(spec) : Alpha::coverage;
}

/// Refuses what OpenImageIO 2.4 reads wrongly without a word.
void check_tiff(const OIIO::ImageSpec& spec) {
  const int photometric = spec.get_int_attribute("tiff:PhotometricInterpretation", -1);
  const bool has_alpha = spec.alpha_channel >= 0;
  if (photometric == 0 && has_alpha) fail_image("TIFF of inverted greys with alpha is not known");
  if (photometric == 3 && has_alpha) fail_image("TIFF of a palette with alpha is not known");
  if (spec.get_string_attribute("tiff:ColorSpace") == "color separated") {
    fail_image("TIFF of " + std::to_string(spec.nchannels) + " inks is not known");
  }
}

/// A reader of that format alone, whatever the file may be, which leaves colours as it has them.
Picture open(const std::string& format, int file) {
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
  if (format == "tiff") check_tiff(spec);
  const Alpha alpha = alpha_of(format, spec, file);
  return {std::move(input), format, alpha};
}

/// The channels from `first` on, as many as the layout has, which it checks.
void read_pixels(OIIO::ImageInput& input, OIIO::TypeDesc type, int first, ImageAnswer& answer) {
  void* const pixels = make_pixels(answer, PixelLayout::kMostChannels);
  const int end = first + answer.layout.channels;
  // Some readers fill in what a truncated file lacks, and merely say so.
  if (!input.read_image(input.current_subimage(), 0, first, end, type, pixels) ||
      input.has_error()) {
    fail_image(input.geterror());
  }
}

constexpr const char* kUnused = "unused";  ///< a channel that no header gives a meaning

/// OpenImageIO calls the channels of formats that have no names R, G, B and A by their number.
bool is_grey(const Picture& picture) {
  if (picture.format == "sgi" || picture.format == "targa") return picture.spec().nchannels == 2;
  const int photometric = picture.spec().get_int_attribute("tiff:PhotometricInterpretation", 2);
  return picture.format == "tiff" && photometric <= 1;
}

std::vector<std::string> channel_names(const Picture& picture) {
  const OIIO::ImageSpec& spec = picture.spec();
  std::vector<std::string> names;
  for (int i = 0; i < spec.nchannels; ++i) names.push_back(spec.channel_name(i));
  if (is_grey(picture)) {
    const int alpha = picture.format == "tiff" ? spec.alpha_channel : 1;
    for (int i = 0; i < spec.nchannels; ++i) {
      names[static_cast<size_t>(i)] = i == 0 ? "Y" : i == alpha ? "A" : kUnused;
    }
  }
  if (picture.alpha == Alpha::nothing && names.back() == "A") names.back() = kUnused;
  return names;
}

/// Whether the colours that OpenImageIO gives are multiplied by alpha, as the file says or, for
/// WebP, as OpenImageIO 2.4 does by itself.
bool is_associated(const Picture& picture) {
  constexpr int kPremultiplied = 4;  // Truevision TGA 2.0, attributes type
  const OIIO::ImageSpec& spec = picture.spec();
  const std::string& format = picture.format;
  if (spec.get_int_attribute("oiio:UnassociatedAlpha") != 0) return false;
  if (format == "targa") return spec.get_int_attribute("targa:alpha_type") == kPremultiplied;
  return format == "tiff" || format == "webp" || format == "heif";
}

SampleMeaning meaning_of(const Picture& picture, const ColorChannels& used) {
  const uint32_t channel = used.colors[0].value_or(used.alpha.value_or(0));
  return {
      .from_integers = !picture.spec().channelformat(static_cast<int>(channel)).is_floating_point(),
      .is_associated = used.alpha.has_value() && is_associated(picture)};
}

/// Channels of a file, nothing for one that it lacks.
using Order = std::vector<std::optional<uint32_t>>;

/// The type of the fewest bits that holds all of the channels.
OIIO::TypeDesc type_of(const OIIO::ImageSpec& spec, const Order& channels) {
  const auto all_are = [&](OIIO::TypeDesc type) {
    return std::all_of(channels.begin(), channels.end(), [&](const auto& channel) {
      return !channel || spec.channelformat(static_cast<int>(*channel)) == type;
    });
  };
  if (all_are(OIIO::TypeDesc::UINT8)) return OIIO::TypeDesc::UINT8;
  // Integers of 16 bits are more than half floats hold.
  return all_are(OIIO::TypeDesc::HALF) ? OIIO::TypeDesc::HALF : OIIO::TypeDesc::FLOAT;
}

/// Those channels of the picture, all of that type.
ImageAnswer read_channels(const Picture& picture, const Order& order, OIIO::TypeDesc type) {
  const OIIO::ImageSpec& spec = picture.spec();
  const size_t size = type.basesize();
  const int bits = static_cast<int>(size) * 8;
  uint32_t first = UINT32_MAX, last = 0;
  for (const auto& channel : order) {
    if (!channel) continue;
    first = std::min(first, *channel);
    last = std::max(last, *channel);
  }
  ImageAnswer read{{spec.width, spec.height, static_cast<int>(last - first) + 1, bits}, {}};
  read_pixels(*picture.input, type, static_cast<int>(first), read);
  const auto is_in_place = [&](uint32_t i) { return order[i] == first + i; };
  uint32_t in_place = 0;
  while (in_place < order.size() && is_in_place(in_place)) ++in_place;
  if (in_place == order.size()) return read;
  ImageAnswer answer{{spec.width, spec.height, static_cast<int>(order.size()), bits}, {}};
  make_pixels(answer, PixelLayout::kMostChannels);
  const size_t from_pixel = static_cast<size_t>(read.layout.channels) * size;
  const char* from = read.payload.data();
  for (char* to = answer.payload.data(); from != read.payload.data() + read.payload.size();
       from += from_pixel, to += order.size() * size) {
    for (size_t i = 0; i < order.size(); ++i) {
      if (order[i]) std::memcpy(to + i * size, from + (*order[i] - first) * size, size);
    }
  }
  return answer;
}

/// Whether alpha, the last channel of what was read, is nothing: no header says what it is, and it
/// is 0 in all of the pixels.
bool has_empty_alpha(const Picture& picture, const ImageAnswer& read) {
  if (picture.alpha != Alpha::coverage_if_any) return false;
  const auto size = static_cast<size_t>(read.layout.bits / 8);
  const size_t stride = static_cast<size_t>(read.layout.channels) * size;
  for (size_t end = stride; end <= read.payload.size(); end += stride) {
    for (size_t i = 1; i <= size; ++i)
      if (read.payload[end - i] != 0) return false;
  }
  return true;
}

ImageAnswer decode_all(const std::string& format, int file) {
  const Picture picture = open(format, file);
  std::vector<std::string> names = channel_names(picture);
  Order order;
  for (uint32_t i = 0; i < names.size(); ++i) order.emplace_back(i);
  ImageAnswer answer = read_channels(picture, order, type_of(picture.spec(), order));
  if (names.back() == "A" && has_empty_alpha(picture, answer)) names.back() = kUnused;
  answer.names = joined_names(names);
  answer.meaning = meaning_of(picture, color_channels_of(names));
  return answer;
}

/// The picture of those of its channels.
ImageAnswer read_used(const Picture& picture, const ColorChannels& used) {
  const Order order = used.in_order();
  return read_channels(picture, order, type_of(picture.spec(), order));
}

/// The colour and coverage of the picture, and in `names` its other channels.
ImageAnswer read_colors(const Picture& picture) {
  std::vector<std::string> names = channel_names(picture);
  ColorChannels used = color_channels_of(names);
  ImageAnswer answer = read_used(picture, used);
  if (used.alpha && has_empty_alpha(picture, answer)) {
    names[*used.alpha] = kUnused;
    used = color_channels_of(names);
    answer = read_used(picture, used);
  }
  const Order order = used.in_order();
  std::vector<std::string> others;
  for (uint32_t i = 0; i < names.size(); ++i) {
    if (std::find(order.begin(), order.end(), std::optional(i)) == order.end()) {
      others.push_back(names[i]);
    }
  }
  answer.meaning = meaning_of(picture, used);
  answer.names = joined_names(others);
  return answer;
}

ImageAnswer decode(const std::string& format, int file, bool to_srgb) {
  const Picture picture = open(format, file);
  ImageAnswer answer = read_colors(picture);
  const int channels = answer.layout.channels;
  const bool has_colors = answer.layout.bits == 8 && channels >= 3;
  const OIIO::ParamValue* const profile =
      to_srgb && has_colors ? picture.spec().find_attribute("ICCProfile") : nullptr;
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
