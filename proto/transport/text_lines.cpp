#include "proto/transport/text_lines.h"

#include <algorithm>
#include <utility>

namespace tessera {

std::vector<TextLine> text_lines(std::string_view text) {
  constexpr std::string_view kBlank = " \t\r\v\f";
  std::vector<TextLine> lines;
  int number = 0;
  while (!text.empty()) {
    const size_t end = text.find('\n');
    std::string_view rest = text.substr(0, end);
    text.remove_prefix(end == std::string_view::npos ? text.size() : end + 1);
    rest = rest.substr(0, rest.find('#'));
    TextLine line{++number, {}};
    for (size_t at = 0; (at = rest.find_first_not_of(kBlank, at)) != std::string_view::npos;) {
      const size_t stop = std::min(rest.find_first_of(kBlank, at), rest.size());
      line.words.push_back({rest.substr(at, stop - at), static_cast<int>(at) + 1});
      at = stop;
    }
    if (!line.words.empty()) lines.push_back(std::move(line));
  }
  return lines;
}

}  // namespace tessera
