#include "image/plain/exr_format.h"

#include <OpenEXR/Iex.h>
#include <OpenEXR/ImfChannelList.h>
#include <OpenEXR/ImfFrameBuffer.h>
#include <OpenEXR/ImfHeader.h>
#include <OpenEXR/ImfIO.h>
#include <OpenEXR/ImfInputPart.h>
#include <OpenEXR/ImfMultiPartInputFile.h>
#include <OpenEXR/ImfOutputFile.h>
#include <OpenEXR/ImfPartType.h>
#include <OpenEXR/ImfRgbaFile.h>
#include <OpenEXR/ImfStringAttribute.h>
#include <OpenEXR/ImfThreading.h>

#include <algorithm>
#include <cstring>
#include <sstream>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "image/plain/for_all.h"
#include "image/plain/plain_formats.h"
#include "renderer/math/stored_samples.h"

namespace tessera {
namespace {

constexpr int kMostParts = 64;  ///< that are looked at

/// How many threads work on blocks of one file, which libOpenEXR has made.
int thread_count() {
  static const int count = [] {
    Imf::setGlobalThreadCount(threads_of_picture());
    return threads_of_picture();
  }();
  return count;
}

class MemoryInput : public Imf::IStream {
 public:
  explicit MemoryInput(std::span<const char> bytes) : IStream("picture"), bytes_(bytes) {}

  bool read(char to[], int count) override {
    const auto wanted = static_cast<size_t>(count);
    if (wanted > bytes_.size() - at_) fail_image("the file ends too early");
    std::memcpy(to, bytes_.data() + at_, wanted);
    at_ += wanted;
    return at_ < bytes_.size();
  }
  uint64_t tellg() override { return at_; }
  void seekg(uint64_t at) override { at_ = std::min<uint64_t>(at, bytes_.size()); }

 private:
  std::span<const char> bytes_;
  size_t at_ = 0;
};

class MemoryOutput : public Imf::OStream {
 public:
  MemoryOutput() : OStream("picture") {}

  void write(const char from[], int count) override {
    const auto end = at_ + static_cast<size_t>(count);
    if (end > bytes_.size()) bytes_.resize(end);
    std::memcpy(bytes_.data() + at_, from, static_cast<size_t>(count));
    at_ = end;
  }
  uint64_t tellp() override { return at_; }
  void seekp(uint64_t at) override { at_ = at; }
  std::vector<char> take() { return std::move(bytes_); }

 private:
  std::vector<char> bytes_;
  size_t at_ = 0;
};

std::vector<std::string> names_to_write(const ImageRequest& request) {
  std::string given = request.channel_names;
  if (given.empty()) given = request.layout.channels == 4 ? "R,G,B,A" : "R,G,B";
  std::vector<std::string> names;
  std::istringstream rest(given);
  for (std::string name; std::getline(rest, name, ',');) names.push_back(name);
  if (names.size() != static_cast<size_t>(request.layout.channels)) {
    fail_image("the channels do not fit their names");
  }
  return names;
}

Imath::Box2i box_at(int x, int y, int width, int height) {
  return {{x, y}, {x + width - 1, y + height - 1}};
}

Imf::Header header_of(const ImageRequest& request) {
  const PixelLayout& layout = request.layout;
  const ImageWindow& window = request.window;
  const bool is_crop = window.frame_width > 0 && window.frame_height > 0;
  const auto data = is_crop ? box_at(window.x, window.y, layout.width, layout.height)
                            : box_at(0, 0, layout.width, layout.height);
  Imf::Header header(is_crop ? box_at(0, 0, window.frame_width, window.frame_height) : data, data);
  header.compression() = Imf::ZIP_COMPRESSION;
  for (const auto& [name, text] : image_texts(request.attributes)) {
    header.insert(name == "Description" ? "comments" : name, Imf::StringAttribute(text));
  }
  return header;
}

/// Adds the floats or half floats of a pixel's channels, in rows over `data` that begin at
/// `pixels`. Nothing is read into a channel without a name.
Imf::FrameBuffer frame_of(const std::vector<std::string>& names, Imf::PixelType type, char* pixels,
                          const Imath::Box2i& data) {
  const size_t size = type == Imf::HALF ? 2 : 4;
  const size_t pixel = size * names.size();
  const size_t row = pixel * (static_cast<size_t>(data.max.x - data.min.x) + 1);
  Imf::FrameBuffer frame;
  for (size_t i = 0; i < names.size(); ++i) {
    if (names[i].empty()) continue;
    frame.insert(names[i], Imf::Slice::Make(type, pixels + i * size, data, pixel, row));
  }
  return frame;
}

/// A part whose samples are one a channel and pixel.
bool is_flat(const Imf::Header& header) {
  return !header.hasType() || !Imf::isDeepData(header.type());
}

std::string name_of(const Imf::Header& header, int part) {
  return header.hasName() ? header.name() : std::to_string(part);
}

/// The names of a part's channels: layer by layer R, G, B and A, then the others by the alphabet.
std::vector<std::string> channel_names(const Imf::Header& header) {
  std::vector<std::string> names;
  for (auto channel = header.channels().begin(); channel != header.channels().end(); ++channel) {
    names.emplace_back(channel.name());
  }
  if (names.empty()) fail_image("it has no channels");
  const auto place = [](std::string_view name) {
    const size_t begin = name.rfind('.') + 1;
    const std::string_view channel = name.substr(begin);
    const size_t color =
        channel.size() == 1 ? std::string_view("RGBA").find(channel[0]) : channel.npos;
    return std::pair(name.substr(0, begin), color);
  };
  std::stable_sort(names.begin(), names.end(),
                   [&](const auto& a, const auto& b) { return place(a) < place(b); });
  return names;
}

/// Each as PART.CHANNEL.
std::vector<std::string> names_in_part(const Imf::MultiPartInputFile& file, int part) {
  std::vector<std::string> names = channel_names(file.header(part));
  for (std::string& name : names) name = name_of(file.header(part), part) + "." + name;
  return names;
}

int part_count(const Imf::MultiPartInputFile& file) { return std::min(file.parts(), kMostParts); }

/// The part whose name and channels fit a picture best.
int best_part(const Imf::MultiPartInputFile& file) {
  int best = -1, best_rank = 0;
  for (int part = 0; part < part_count(file); ++part) {
    if (!is_flat(file.header(part))) continue;
    const int rank = color_rank(names_in_part(file, part));
    if (best >= 0 && rank >= best_rank) continue;
    best = part;
    best_rank = rank;
  }
  if (best < 0) fail_image("it holds deep samples alone, which are not known");
  return best;
}

/// Where the pixels of a picture lie in those of its file.
struct Window {
  int x = 0, y = 0;  ///< of the first pixel that the file has
  int width = 0, height = 0;
};

/// The display window, where pixels that the file lacks are black and clear, or for a `crop` what
/// the file has of it; all of the file's pixels where none of them is in its display window.
Window window_of(const Imf::Header& header, bool crop, int channels, int bits) {
  const Imath::Box2i& display = header.displayWindow();
  const Imath::Box2i& data = header.dataWindow();
  const auto side = [](int min, int max) { return int64_t{max} - min + 1; };
  const PixelLayout all{
      static_cast<int>(std::min(side(data.min.x, data.max.x), int64_t{INT32_MAX})),
      static_cast<int>(std::min(side(data.min.y, data.max.y), int64_t{INT32_MAX})), channels, bits};
  if (!all.is_legal(PixelLayout::kMostChannels)) fail_image("its size is out of range");
  const Window whole{0, 0, all.width, all.height};
  if (!display.intersects(data)) return whole;
  if (crop) {
    const int x0 = std::max(data.min.x, display.min.x), x1 = std::min(data.max.x, display.max.x);
    const int y0 = std::max(data.min.y, display.min.y), y1 = std::min(data.max.y, display.max.y);
    return {data.min.x - x0, data.min.y - y0, x1 - x0 + 1, y1 - y0 + 1};
  }
  const int64_t width = side(display.min.x, display.max.x);
  const int64_t height = side(display.min.y, display.max.y);
  const bool fits = width <= PixelLayout::kMostSide && height <= PixelLayout::kMostSide;
  if (!fits) return whole;
  const PixelLayout shown{static_cast<int>(width), static_cast<int>(height), channels, bits};
  if (!shown.is_legal()) return whole;
  return {data.min.x - display.min.x, data.min.y - display.min.y, shown.width, shown.height};
}

/// Copies the rows of pixels over the data window to where they lie in `answer`.
void place_rows(std::span<const char> pixels, const Imath::Box2i& data, const Window& window,
                const PixelLayout& layout, std::span<char> answer) {
  const auto pixel = static_cast<size_t>(layout.channels) * static_cast<size_t>(layout.bits / 8);
  const int width = data.max.x - data.min.x + 1, height = data.max.y - data.min.y + 1;
  const int x0 = std::max(0, -window.x), y0 = std::max(0, -window.y);
  const int x1 = std::min(width, window.width - window.x);
  const int y1 = std::min(height, window.height - window.y);
  const auto at = [&](int x, int y, int row) {
    return (static_cast<size_t>(y) * static_cast<size_t>(row) + static_cast<size_t>(x)) * pixel;
  };
  for (int y = y0; y < y1 && x0 < x1; ++y) {
    std::memcpy(answer.data() + at(x0 + window.x, y + window.y, window.width),
                pixels.data() + at(x0, y, width), static_cast<size_t>(x1 - x0) * pixel);
  }
}

/// One part of a file, whose bytes have to outlive it.
class Part {
 public:
  Part(std::span<const char> bytes, Imf::MultiPartInputFile& file, int number)
      : bytes_(bytes), part_(file, number), number_(number), names_(channel_names(header())) {}

  const Imf::Header& header() const { return part_.header(); }
  /// Of all channels.
  const std::vector<std::string>& names() const { return names_; }

  /// The pixels of the channels with these names; one without a name is 0.
  ImageAnswer read(const std::vector<std::string>& names, bool crop, Imf::PixelType type) {
    return placed(static_cast<int>(names.size()), crop, type, [&](char* pixels) {
      for (const std::string& name : names) check_sampling(name);
      const Imath::Box2i& data = header().dataWindow();
      part_.setFrameBuffer(frame_of(names, type, pixels, data));
      part_.readPixels(data.min.y, data.max.y);
    });
  }

  /// Red, green and blue, and alpha where the file has it, of luminance and chroma; the latter is
  /// there for one of four pixels.
  ImageAnswer read_subsampled(bool has_alpha, bool crop) {
    if (number_ != 0) fail_image("its chroma is not that of the first part, which is not known");
    MemoryInput stream(bytes_);
    Imf::RgbaInputFile file(stream, thread_count());
    const size_t channels = has_alpha ? 4 : 3;
    return placed(static_cast<int>(channels), crop, Imf::HALF, [&](char* pixels) {
      const Imath::Box2i& data = header().dataWindow();
      const auto width = static_cast<size_t>(data.max.x - data.min.x) + 1;
      std::vector<Imf::Rgba> row(width);
      for (int y = data.min.y; y <= data.max.y; ++y) {
        file.setFrameBuffer(row.data() - data.min.x, 1, 0);
        file.readPixels(y);
        for (const Imf::Rgba& pixel : row) {
          std::memcpy(pixels, &pixel, channels * sizeof(half));
          pixels += channels * sizeof(half);
        }
      }
    });
  }

  /// Whether the colours are luminance and chroma, and the latter is not there for every pixel.
  bool has_subsampled_chroma(const ColorChannels& used) const {
    return used.kind == ColorChannels::Kind::luminance_chroma &&
           (is_subsampled(names_[*used.colors[1]]) || is_subsampled(names_[*used.colors[2]]));
  }

  /// That of the fewest bits which holds all of the channels.
  Imf::PixelType type_of(const std::vector<std::string>& names) const {
    const bool is_half = std::all_of(names.begin(), names.end(), [&](const std::string& name) {
      return name.empty() || header().channels()[name].type == Imf::HALF;
    });
    return is_half ? Imf::HALF : Imf::FLOAT;
  }

 private:
  bool is_subsampled(const std::string& name) const {
    const Imf::Channel* const channel = header().channels().findChannel(name);
    return channel && (channel->xSampling != 1 || channel->ySampling != 1);
  }
  void check_sampling(const std::string& name) const {
    if (is_subsampled(name))
      fail_image("its channel " + name + " is subsampled, which is not known");
  }

  /// What read_all(pixels) reads over the data window, in its place.
  template <typename ReadAll>
  ImageAnswer placed(int channels, bool crop, Imf::PixelType type, const ReadAll& read_all) {
    const int bits = type == Imf::HALF ? 16 : 32;
    const Imath::Box2i& data = header().dataWindow();
    const Window window = window_of(header(), crop, channels, bits);
    const PixelLayout all{data.max.x - data.min.x + 1, data.max.y - data.min.y + 1, channels, bits};
    ImageAnswer answer{{window.width, window.height, channels, bits}, {}};
    if (!answer.layout.is_legal(PixelLayout::kMostChannels)) fail_image("its size is out of range");
    const std::span<char> pixels = answer.make_room();
    const bool is_same =
        window.x == 0 && window.y == 0 && window.width == all.width && window.height == all.height;
    if (is_same) {
      read_all(pixels.data());
      return answer;
    }
    std::vector<char> read(all.bytes());
    read_all(read.data());
    place_rows(read, data, window, answer.layout, pixels);
    return answer;
  }

  std::span<const char> bytes_;
  Imf::InputPart part_;
  int number_;
  std::vector<std::string> names_;
};

/// The colours and coverage of the part, and in `names` its other channels.
ImageAnswer read_colors(Part& part) {
  const std::vector<std::string>& names = part.names();
  const ColorChannels used = color_channels_of(names);
  std::vector<std::string> order;
  for (const auto& index : used.in_order()) order.push_back(index ? names[*index] : "");
  ImageAnswer answer;
  if (part.has_subsampled_chroma(used)) {
    answer = part.read_subsampled(used.alpha.has_value(), false);
  } else {
    const bool has_chroma = used.kind == ColorChannels::Kind::luminance_chroma;
    answer = part.read(order, false, has_chroma ? Imf::FLOAT : part.type_of(order));
    if (has_chroma) {
      const std::span<char> pixels = answer.pixels();
      luminance_chroma_to_rgb(
          {reinterpret_cast<float*>(pixels.data()), pixels.size() / sizeof(float)}, used.count());
    }
  }
  std::vector<std::string> others;
  for (const std::string& name : names) {
    if (std::find(order.begin(), order.end(), name) == order.end()) others.push_back(name);
  }
  answer.names = joined_names(others);
  answer.meaning.is_associated = used.alpha.has_value();
  return answer;
}

/// All channels, in place of subsampled ones the colours that they stand for.
ImageAnswer read_all(Part& part) {
  std::vector<std::string> names = part.names();
  const ColorChannels used = color_channels_of(names);
  ImageAnswer answer;
  if (part.has_subsampled_chroma(used)) {
    answer = part.read_subsampled(used.alpha.has_value(), true);
    names = {"R", "G", "B"};
    if (used.alpha) names.emplace_back("A");
  } else {
    answer = part.read(names, true, part.type_of(names));
  }
  answer.names = joined_names(names);
  answer.meaning.is_associated = used.alpha.has_value();
  return answer;
}

ImageAnswer decode(std::span<const char> bytes, bool all) {
  Imf::Header::setMaxImageSize(PixelLayout::kMostSide, PixelLayout::kMostSide);
  Imf::Header::setMaxTileSize(PixelLayout::kMostSide, PixelLayout::kMostSide);
  MemoryInput stream(bytes);
  Imf::MultiPartInputFile file(stream, thread_count());
  const int best = best_part(file);
  Part part(bytes, file, best);
  ImageAnswer answer = all ? read_all(part) : read_colors(part);
  if (best != 0) answer.part = name_of(file.header(best), best);
  if (all) return answer;
  for (int other = 0; other < part_count(file); ++other) {
    if (other != best) answer.names += joined_names(names_in_part(file, other));
  }
  if (answer.names.size() > PixelLayout::kLongestNames) {
    fail_image("its channels have too long names");
  }
  return answer;
}

}  // namespace

ImageAnswer decode_exr(std::span<const char> file, bool all) {
  try {
    return decode(file, all);
  } catch (const Iex::BaseExc& error) {
    // libOpenEXR begins with the name of the file, which is ours.
    const std::string_view text = error.what(), name = "\"picture\". ";
    const size_t at = text.find(name);
    fail_image(std::string(at == text.npos ? text : text.substr(at + name.size())));
  }
}

std::optional<ImageAnswer> encode_exr(const ImageRequest& request, std::span<const char> pixels) {
  if (std::string_view(request.format) != "openexr") return std::nullopt;
  const PixelLayout& layout = request.layout;
  if (!layout.is_legal(PixelLayout::kMostChannels) || layout.bits != 32 ||
      layout.bytes() != pixels.size()) {
    fail_image("the pixels do not fit their layout");
  }
  const std::vector<std::string> names = names_to_write(request);
  Imf::Header header = header_of(request);
  for (const std::string& name : names) header.channels().insert(name, Imf::Channel(Imf::FLOAT));
  MemoryOutput stream;
  {
    Imf::OutputFile file(stream, header, thread_count());
    file.setFrameBuffer(
        frame_of(names, Imf::FLOAT, const_cast<char*>(pixels.data()), header.dataWindow()));
    file.writePixels(layout.height);
  }
  return ImageAnswer{{}, stream.take()};
}

}  // namespace tessera
