#include "renderer/image/image_file.h"

#include <dlfcn.h>
#include <fcntl.h>
#include <fmt/format.h>
#include <unistd.h>

#include <algorithm>
#include <array>
#include <cerrno>
#include <cstring>
#include <fstream>
#include <future>
#include <mutex>
#include <optional>

#include "base/error.h"
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

// -------------------------------------------------------------------------------- safe appearance

std::string system_cause() { return std::strerror(errno); }

/// Where the file will really lie: a link is written through, not replaced.
fs::path destination(const fs::path& path) {
  std::error_code ignored;
  return fs::is_symlink(path, ignored) ? fs::weakly_canonical(path) : path;
}

fs::path temporary_beside(const fs::path& path) {
  return path.parent_path() /
         fmt::format(".{}.{}.tmp{}", path.stem().string(), getpid(), path.extension().string());
}

/// Removes its file unless it was renamed.
class TemporaryFile {
 public:
  explicit TemporaryFile(fs::path path) : path_(std::move(path)) {}
  TemporaryFile(const TemporaryFile&) = delete;
  TemporaryFile& operator=(const TemporaryFile&) = delete;
  ~TemporaryFile() {
    if (!kept_) unlink(path_.c_str());
  }
  const fs::path& path() const { return path_; }

  bool sync_and_rename(const fs::path& to) {
    if (!sync(path_, O_RDONLY) || std::rename(path_.c_str(), to.c_str()) != 0) return false;
    kept_ = true;
    // The name itself is durable once its folder is; some file systems can not sync one.
    sync(to.has_parent_path() ? to.parent_path() : fs::path("."), O_RDONLY | O_DIRECTORY);
    return true;
  }

 private:
  static bool sync(const fs::path& path, int flags) {
    const int file = open(path.c_str(), flags | O_CLOEXEC);
    if (file < 0) return false;
    const bool done = fsync(file) == 0;
    close(file);
    return done;
  }

  fs::path path_;
  bool kept_ = false;
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
bool write_pfm(const fs::path& path, const Film& film) {
  std::ofstream file(path, std::ios::binary);
  file << fmt::format("PF\n{} {}\n-1.0\n", film.width(), film.height());
  const auto row_size = static_cast<size_t>(film.width()) * kFilmChannels;
  for (int y = film.height() - 1; y >= 0; --y) {
    const auto row = film.values().subspan(static_cast<size_t>(y) * row_size, row_size);
    file.write(reinterpret_cast<const char*>(row.data()),
               static_cast<std::streamsize>(row.size_bytes()));
  }
  file.close();
  return !file.fail();
}

void write_by_module(const fs::path& path, const Format& format, const Film& film,
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
  const fs::path place = destination(path);
  std::error_code ignored;
  const fs::file_status status = fs::status(place, ignored);
  if (fs::exists(status) && !fs::is_regular_file(status)) {
    throw usage_error(fmt::format("{}: can not be written: it is no regular file", path.string()));
  }
  if (fs::exists(status) && access(place.c_str(), W_OK) != 0) {
    throw usage_error(fmt::format("{}: can not be written: {}", path.string(), system_cause()));
  }
  const TemporaryFile probe(temporary_beside(place));
  const int file = open(probe.path().c_str(), O_WRONLY | O_CREAT | O_CLOEXEC, 0666);
  if (file < 0) {
    throw usage_error(fmt::format("{}: can not be written: {}", path.string(), system_cause()));
  }
  close(file);
}

void write_image(const fs::path& path, const Film& film, const OutputSettings& settings,
                 const ImageMetadata& metadata) {
  const Format& format = format_of(path);
  const fs::path place = destination(path);
  TemporaryFile temporary(temporary_beside(place));
  std::string cause;
  try {
    if (format.name) {
      write_by_module(temporary.path(), format, film, settings, metadata);
    } else if (!write_pfm(temporary.path(), film)) {
      cause = system_cause();
    }
    if (cause.empty() && !temporary.sync_and_rename(place)) cause = system_cause();
  } catch (const Error& error) {
    cause = error.what();
  }
  if (!cause.empty()) {
    throw render_error(fmt::format("{}: can not be written: {}", path.string(), cause));
  }
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
