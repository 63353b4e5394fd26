#include "base/file.h"

#include <fmt/format.h>
#include <unistd.h>

#include <cerrno>
#include <cstdio>
#include <cstring>
#include <memory>
#include <system_error>

#include "base/error.h"

namespace tessera {
namespace {

namespace fs = std::filesystem;

struct CloseFile {
  void operator()(std::FILE* file) const { std::fclose(file); }
};
using FileHandle = std::unique_ptr<std::FILE, CloseFile>;

}  // namespace

uint64_t check_input_file(const std::string& path, uint64_t max_bytes) {
  std::error_code failure;
  const fs::file_status status = fs::status(path, failure);
  if (status.type() == fs::file_type::not_found)
    throw scene_error(fmt::format("{}: no such file", path));
  if (failure) throw scene_error(fmt::format("{}: {}", path, failure.message()));
  if (fs::is_directory(status))
    throw scene_error(fmt::format("{}: is a folder; expected a file", path));
  if (!fs::is_regular_file(status)) throw scene_error(fmt::format("{}: is no regular file", path));
  const uint64_t size = fs::file_size(path, failure);
  if (failure) throw scene_error(fmt::format("{}: {}", path, failure.message()));
  if (size == 0) throw scene_error(fmt::format("{}: the file is empty", path));
  if (size > max_bytes)
    throw scene_error(
        fmt::format("{}: the file has {} bytes; expected at most {}", path, size, max_bytes));
  return size;
}

std::string read_input_file(const std::string& path, uint64_t max_bytes) {
  const uint64_t size = check_input_file(path, max_bytes);
  const FileHandle file(std::fopen(path.c_str(), "rb"));
  if (!file) throw scene_error(fmt::format("{}: {}", path, std::strerror(errno)));
  std::string bytes(size, '\0');
  const size_t got = std::fread(bytes.data(), 1, size, file.get());
  if (std::ferror(file.get())) throw scene_error(fmt::format("{}: {}", path, std::strerror(errno)));
  bytes.resize(got);
  return bytes;
}

void write_output_file(const std::string& path, std::string_view bytes) {
  const std::string part = fmt::format("{}.{}.part", path, ::getpid());
  const auto fail = [&] {
    const std::string why = std::strerror(errno);
    std::remove(part.c_str());
    throw render_error(fmt::format("{}: cannot write: {}", path, why));
  };
  FileHandle file(std::fopen(part.c_str(), "wb"));
  if (!file) fail();
  if (std::fwrite(bytes.data(), 1, bytes.size(), file.get()) != bytes.size()) fail();
  if (std::fflush(file.get()) != 0 || ::fsync(::fileno(file.get())) != 0) fail();
  if (std::fclose(file.release()) != 0) fail();
  if (std::rename(part.c_str(), path.c_str()) != 0) fail();
}

std::optional<fs::path> resolve_inside(const fs::path& folder, const std::string& reference) {
  if (reference.empty() || reference.find('\0') != std::string::npos) return std::nullopt;
  const fs::path relative(reference);
  if (relative.is_absolute()) return std::nullopt;
  std::error_code failure;
  const fs::path root = fs::weakly_canonical(folder.empty() ? "." : folder, failure);
  if (failure) return std::nullopt;
  const fs::path target = fs::weakly_canonical(root / relative, failure);
  if (failure) return std::nullopt;
  const fs::path inside = target.lexically_relative(root);
  if (inside.empty() || *inside.begin() == "..") return std::nullopt;
  return target;
}

namespace {

/// The length of the well-formed UTF-8 sequence (RFC 3629) at `at`, or 0.
size_t utf8_sequence(std::string_view text, size_t at) {
  const auto byte = [&](size_t i) {
    return i < text.size() ? static_cast<unsigned char>(text[i]) : 0u;
  };
  const unsigned first = byte(at);
  if (first < 0x80) return 1;
  const size_t length = first >= 0xF0 ? 4 : first >= 0xE0 ? 3 : 2;
  if (first < 0xC2 || first > 0xF4) return 0;
  for (size_t i = 1; i < length; ++i)
    if ((byte(at + i) & 0xC0) != 0x80) return 0;
  const unsigned second = byte(at + 1);
  const bool overlong = (first == 0xE0 && second < 0xA0) || (first == 0xF0 && second < 0x90);
  const bool surrogate = first == 0xED && second > 0x9F;
  const bool too_large = first == 0xF4 && second > 0x8F;
  return overlong || surrogate || too_large ? 0 : length;
}

}  // namespace

size_t find_invalid_utf8(std::string_view text) {
  for (size_t at = 0; at < text.size();) {
    const size_t length = utf8_sequence(text, at);
    if (length == 0) return at;
    at += length;
  }
  return std::string_view::npos;
}

std::string to_utf8(std::string_view text) {
  std::string out;
  out.reserve(text.size());
  for (size_t at = 0; at < text.size();) {
    if (const size_t length = utf8_sequence(text, at)) {
      out.append(text.substr(at, length));
      at += length;
      continue;
    }
    const auto byte = static_cast<unsigned char>(text[at++]);
    out += static_cast<char>(0xC0 | byte >> 6);
    out += static_cast<char>(0x80 | (byte & 0x3F));
  }
  return out;
}

}  // namespace tessera
