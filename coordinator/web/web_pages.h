#pragma once

#include <optional>
#include <string>
#include <string_view>

namespace tessera {

/// A file of coordinator/web/page, which are part of the program.
struct WebPage {
  std::string_view type;
  std::string_view content;
};
/// By the path of a request, such as "/page.css"; nothing for any other.
std::optional<WebPage> find_web_page(std::string_view path);

}  // namespace tessera
