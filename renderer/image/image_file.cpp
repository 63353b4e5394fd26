#include "renderer/image/image_file.h"

#include <dlfcn.h>
#include <fmt/format.h>
#include <sys/mman.h>
#include <sys/stat.h>
#include <unistd.h>

#include <algorithm>
#include <array>
#include <cerrno>
#include <cstring>
#include <future>
#include <mutex>
#include <optional>

#include "base/error.h"
#include "base/file.h"
#include "base/version.h"
#include "renderer/image/image_module.h"

namespace tessera {

namespace fs = std::filesystem;

namespace {

struct Format {
  const char* ending;
  const char* name;  ///< as OpenImageIO calls it; null: it can not write it, we do
  bool is_float;
};

constexpr std::array<Format, 13> kFormats{{{"png", "png", false},
                                           {"exr", "openexr", true},
                                           {"jpg", "jpeg", false},
                                           {"jpeg", "jpeg", false},
                                           {"bmp", "bmp", false},
                                           {"tif", "tiff", false},
                                           {"tiff", "tiff", false},
                                           {"tga", "targa", false},
                                           {"ppm", "pnm", false},
                                           {"webp", "webp", false},
                                           {"hdr", "hdr", true},
                                           {"pfm", nullptr, true},
                                           {"sgi", "sgi", false}}};

const Format& format_of(const fs::path& path) {
  std::string ending = path.extension().string();
  if (!ending.empty()) ending.erase(0, 1);
  std::transform(ending.begin(), ending.end(), ending.begin(),
                 [](unsigned char c) { return static_cast<char>(std::tolower(c)); });
  std::vector<std::string> known;
  for (const Format& format : kFormats) {
    if (ending == format.ending) return format;
    known.emplace_back(format.ending);
  }
  throw usage_error(
      fmt::format("{}: '{}' is no image format that can be written; expected one of {}{}",
                  path.string(), ending, fmt::join(known, ", "), suggestion(ending, known)));
}

// ------------------------------------------------------------------------------------- the module

const ImageModule* load_module() {
  const fs::path folder = fs::read_symlink("/proc/self/exe").parent_path();
  std::string cause;
  for (const char* place : {"tessera_image.so", "../lib/tessera/tessera_image.so"}) {
    const std::string file = (folder / place).string();
    void* const handle = dlopen(file.c_str(), RTLD_LAZY | RTLD_LOCAL);
    if (!handle) {
      if (cause.empty()) cause = dlerror();
      continue;
    }
    const auto entry = reinterpret_cast<ImageModuleEntry>(dlsym(handle, kImageModuleEntry));
    if (const ImageModule* module = entry ? entry(kImageModuleVersion) : nullptr) return module;
    cause = fmt::format("{} is of another version", file);
  }
  throw render_error(fmt::format("the image module can not be loaded: {}", cause));
}

std::shared_future<const ImageModule*> module_future() {
  static std::mutex mutex;
  static std::shared_future<const ImageModule*> future;
  const std::lock_guard lock(mutex);
  if (!future.valid()) future = std::async(std::launch::async, load_module).share();
  return future;
}

// ----------------------------------------------------------------------------------- the encoding

/// A file in memory for the encoders, which write files only: several of them take a full disk for
/// success, and one ends the process.
class MemoryFile {
 public:
  /// `most_bytes` is never exceeded: a limit on file sizes, which holds here too, shows now.
  explicit MemoryFile(uint64_t most_bytes) : file_(memfd_create("picture", MFD_CLOEXEC)) {
    if (file_ < 0 || ftruncate(file_, static_cast<off_t>(most_bytes)) != 0 ||
        ftruncate(file_, 0) != 0) {
      const std::string why = std::strerror(errno);
      if (file_ >= 0) close(file_);
      throw render_error(why);
    }
  }
  MemoryFile(const MemoryFile&) = delete;
  MemoryFile& operator=(const MemoryFile&) = delete;
  ~MemoryFile() {
    if (mapped_ != MAP_FAILED) munmap(mapped_, size_);
    close(file_);
  }

  std::string path() const { return fmt::format("/proc/self/fd/{}", file_); }

  /// What was written; lives as long as this.
  std::string_view bytes() {
    struct stat status {};
    if (fstat(file_, &status) != 0) throw render_error(std::strerror(errno));
    size_ = static_cast<size_t>(status.st_size);
    if (size_ == 0) throw render_error("the encoder wrote nothing");
    mapped_ = mmap(nullptr, size_, PROT_READ, MAP_SHARED, file_, 0);
    if (mapped_ == MAP_FAILED) throw render_error(std::strerror(errno));
    return {static_cast<const char*>(mapped_), size_};
  }

 private:
  int file_;
  size_t size_ = 0;
  void* mapped_ = MAP_FAILED;
};

std::vector<ImageModule::Attribute> attributes_of(const ImageMetadata& metadata,
                                                  const std::string& software) {
  using Attribute = ImageModule::Attribute;
  return {{"Software", Attribute::text, software.c_str(), 0, 0},
          {"tessera:SceneDigest", Attribute::text, metadata.scene_digest.c_str(), 0, 0},
          {"tessera:Seed", Attribute::integer, nullptr, static_cast<int>(metadata.seed), 0},
          {"tessera:Samples", Attribute::integer, nullptr,
           static_cast<int>(metadata.samples_per_pixel), 0},
          {"tessera:RenderSeconds", Attribute::real, nullptr, 0,
           static_cast<float>(metadata.render_seconds)}};
}

/// Portable float map: little-endian floats, rows from the bottom.
std::string encode_pfm(const Film& film) {
  std::string bytes = fmt::format("PF\n{} {}\n-1.0\n", film.width(), film.height());
  bytes.reserve(bytes.size() + film.values().size_bytes());
  const auto row_size = static_cast<size_t>(film.width()) * kFilmChannels;
  for (int y = film.height() - 1; y >= 0; --y) {
    const auto row = film.values().subspan(static_cast<size_t>(y) * row_size, row_size);
    bytes.append(reinterpret_cast<const char*>(row.data()), row.size_bytes());
  }
  return bytes;
}

/// No encoder makes more of incompressible values, headers and metadata included.
uint64_t most_encoded_bytes(const Film& film, bool is_float) {
  const uint64_t raw = film.values().size() * (is_float ? sizeof(float) : 1);
  return 2 * raw + 64 * 1024;
}

void encode_by_module(const std::string& path, const Format& format, const Film& film,
                      const OutputSettings& settings, const ImageMetadata& metadata) {
  // The module is perhaps still being loaded: first do what does not need it.
  std::vector<uint8_t> bytes;
  if (!format.is_float) bytes = to_8_bit(film, settings);
  const std::string software = fmt::format("tessera {}", kVersion);
  const auto attributes = attributes_of(metadata, software);
  const void* const pixels =
      format.is_float ? static_cast<const void*>(film.values().data()) : bytes.data();
  const ImageModule::Picture picture{pixels,          film.width(),      film.height(),
                                     format.is_float, attributes.data(), attributes.size()};
  std::array<char, 1024> error{};
  if (!module_future().get()->write(path.c_str(), format.name, picture, error.data(),
                                    error.size())) {
    throw render_error(error.data());
  }
}

float* allocate_values(void* context, int width, int height) {
  auto& image = *static_cast<RgbImage*>(context);
  if (width < 1 || height < 1 || int64_t{width} * height > kMaxFramePixels) return nullptr;
  image.width = width;
  image.height = height;
  image.values.resize(static_cast<size_t>(width) * static_cast<size_t>(height) * kFilmChannels);
  return image.values.data();
}

void* allocate_texels(void* context, const ImageModule::Layout& layout) {
  auto& image = *static_cast<TextureImage*>(context);
  const bool legal = layout.width >= 1 && layout.height >= 1 && layout.width <= kMaxFrameSide &&
                     layout.height <= kMaxFrameSide &&
                     int64_t{layout.width} * layout.height <= kMaxFramePixels;
  if (!legal) return nullptr;
  image.width = static_cast<uint32_t>(layout.width);
  image.height = static_cast<uint32_t>(layout.height);
  image.channels = static_cast<uint32_t>(layout.channels);
  image.bits = static_cast<uint32_t>(layout.bits);
  image.texels.resize(size_t{image.width} * image.height * image.channels * (image.bits / 8));
  return image.texels.data();
}

[[noreturn]] void fail_to_read(const fs::path& path, const char* cause) {
  throw scene_error(SourcePlace{path.string()}, fmt::format("can not be read: {}", cause),
                    "an image file");
}

}  // namespace

void preload_image_module() { module_future(); }

void check_writable(const fs::path& path) {
  format_of(path);
  check_output_file(path.string());
}

void write_image(const fs::path& path, const Film& film, const OutputSettings& settings,
                 const ImageMetadata& metadata) {
  const Format& format = format_of(path);
  if (!format.name) return write_output_file(path.string(), encode_pfm(film));
  std::optional<MemoryFile> encoded;
  std::string_view bytes;
  try {
    encoded.emplace(most_encoded_bytes(film, format.is_float));
    encode_by_module(encoded->path(), format, film, settings, metadata);
    bytes = encoded->bytes();
  } catch (const Error& error) {
    throw render_error(fmt::format("'{}' cannot be written: {}", path.string(), error.what()));
  }
  write_output_file(path.string(), bytes);
}

RgbImage read_image(const fs::path& path) {
  RgbImage image;
  std::array<char, 1024> error{};
  if (!module_future().get()->read(path.c_str(), allocate_values, &image, error.data(),
                                   error.size())) {
    fail_to_read(path, error.data());
  }
  return image;
}

TextureImage read_texture_image(const fs::path& path) {
  TextureImage image;
  std::array<char, 1024> error{};
  if (!module_future().get()->read_texels(path.c_str(), allocate_texels, &image, error.data(),
                                          error.size())) {
    fail_to_read(path, error.data());
  }
  return image;
}

}  // namespace tessera
