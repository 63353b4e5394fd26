#include "web/embedded_file.h"

#include <fmt/format.h>
#include <sys/random.h>

#include <array>
#include <memory>
#include <string>

#include "base/error.h"

namespace tessera {
namespace {

std::string replaced(std::string_view text, std::string_view mark, std::string_view by) {
  std::string result;
  while (true) {
    const size_t at = text.find(mark);
    result += text.substr(0, at);
    if (at == std::string_view::npos) return result;
    result += by;
    text.remove_prefix(at + mark.size());
  }
}

}  // namespace

HttpResponse response_of(const EmbeddedFile& file) {
  HttpResponse response{
      200, std::string(file.type), std::make_shared<const std::string>(file.content), {}};
  if (file.is_gzipped) response.headers.emplace_back("Content-Encoding", "gzip");
  return response;
}

HttpResponse response_with_nonce(const EmbeddedFile& file, std::string_view policy) {
  const std::string nonce = random_hex();
  HttpResponse response = response_of(file);
  response.body = std::make_shared<const std::string>(replaced(file.content, kNonceMark, nonce));
  response.headers.emplace_back("Content-Security-Policy", replaced(policy, kNonceMark, nonce));
  return response;
}

std::string random_hex() {
  std::array<unsigned char, 16> bytes{};
  // So few come at once, or not at all.
  if (getrandom(bytes.data(), bytes.size(), 0) != static_cast<ssize_t>(bytes.size())) {
    throw temporary_error("the system has no random numbers");
  }
  return fmt::format("{:02x}", fmt::join(bytes, ""));
}

}  // namespace tessera
