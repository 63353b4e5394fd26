#pragma once

#include <string>
#include <string_view>

#include "web/http_message.h"

namespace tessera {

/// A file of a page, which is part of the program. CMake's tessera_embed() makes of a folder's
/// files a function std::optional<EmbeddedFile> NAME(std::string_view path), by the path of a
/// request such as "/page.css". "/" is index.html; a file that is gzipped, "page.js.gz", has the
/// path and the type of "page.js".
struct EmbeddedFile {
  std::string_view type;
  std::string_view content;
  bool is_gzipped = false;
};

HttpResponse response_of(const EmbeddedFile& file);
/// The response with another Content-Security-Policy than the server's, and a nonce: each
/// kNonceMark in the file, which is not gzipped, and in `policy` is replaced by the same new random
/// text.
HttpResponse response_with_nonce(const EmbeddedFile& file, std::string_view policy);
inline constexpr std::string_view kNonceMark = "{{nonce}}";

/// 128 random bits of the system in 32 hexadecimal digits: a nonce, a token.
std::string random_hex();

}  // namespace tessera
