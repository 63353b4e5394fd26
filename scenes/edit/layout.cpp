#include "scenes/edit/layout.h"

#include <fmt/format.h>

namespace tessera::edit {

bool Layout::ends_line(uint32_t offset) const {
  uint32_t at = offset;
  while (at < text_.size() && is_blank(text_[at])) ++at;
  const std::string_view rest = text_.substr(at);
  return rest.empty() || is_space(rest.front()) ||
         (!comment_.empty() && rest.starts_with(comment_));
}

bool Layout::has_own_lines(SourceRange piece) const {
  return begins_line(text_, piece.begin) && ends_line(piece.end);
}

TextEdit Layout::behind(SourceRange sibling, std::string_view made) const {
  if (!has_own_lines(sibling)) return {{sibling.end, sibling.end}, fmt::format(" {}", made)};
  const uint32_t at = line_end(text_, sibling.end);
  return {{at, at},
          fmt::format("{}{}{}", line_ending(text_, sibling.end), indentation(text_, sibling.begin),
                      made)};
}

TextEdit Layout::before(SourceRange sibling, std::string_view made) const {
  const uint32_t at = sibling.begin;
  if (!begins_line(text_, at)) return {{at, at}, fmt::format("{} ", made)};
  return {{at, at}, fmt::format("{}{}{}", made, line_ending(text_, at), indentation(text_, at))};
}

TextEdit Layout::inside(SourceRange body, uint32_t holder, std::string_view made,
                        std::string_view unit) const {
  const std::string_view there = text_of(text_, body);
  const uint32_t at = body.begin;
  if (there.find_first_of("\r\n") != std::string_view::npos)
    return {
        {at, at},
        fmt::format("{}{}{}{}", line_ending(text_, at), indentation(text_, holder), unit, made)};
  const bool has_blank = !there.empty() && is_blank(there.front());
  return {{at, at}, fmt::format(" {}{}", made, has_blank ? "" : " ")};
}

TextEdit Layout::at_end(std::string_view made) const {
  const auto end = static_cast<uint32_t>(text_.size());
  const std::string_view ending = line_ending(text_, end);
  const bool is_free = line_begin(text_, end) == end;
  return {{end, end}, fmt::format("{}{}{}", is_free ? "" : ending, made, ending)};
}

TextEdit Layout::without(SourceRange piece) const {
  uint32_t after = piece.end;
  while (after < text_.size() && is_blank(text_[after])) ++after;
  const bool ends = after >= text_.size() || text_[after] == '\n' || text_[after] == '\r';
  const bool begins = begins_line(text_, piece.begin);
  if (begins && ends) return {{line_begin(text_, piece.begin), next_line(text_, piece.end)}, ""};
  if (begins) return {{piece.begin, after}, ""};
  uint32_t begin = piece.begin;
  while (begin > 0 && is_blank(text_[begin - 1])) --begin;
  const bool has_blank = after > piece.end || ends;
  return {{has_blank ? begin : piece.begin, piece.end}, ""};
}

}  // namespace tessera::edit
