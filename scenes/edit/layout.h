#pragma once

#include <string>
#include <string_view>

#include "scenes/edit/source_text.h"

namespace tessera::edit {

/// Where pieces of code stand beside each other, in languages without commas between them.
class Layout {
 public:
  /// `comment`: what a comment to the end of the line begins with.
  Layout(std::string_view text, std::string_view comment) : text_(text), comment_(comment) {}

  /// `made` behind a sibling: on a line of its own where the sibling has one, else after a blank.
  TextEdit behind(SourceRange sibling, std::string_view made) const;
  /// `made` before a sibling.
  TextEdit before(SourceRange sibling, std::string_view made) const;
  /// `made` between brackets that hold nothing but comments; `holder` begins what they are of.
  TextEdit inside(SourceRange body, uint32_t holder, std::string_view made,
                  std::string_view unit) const;
  /// `made` on a line of its own at the end of the text.
  TextEdit at_end(std::string_view made) const;
  /// Takes a piece out, with its lines where it has them for itself.
  TextEdit without(SourceRange piece) const;

  bool has_own_lines(SourceRange piece) const;

 private:
  bool ends_line(uint32_t offset) const;

  std::string_view text_, comment_;
};

}  // namespace tessera::edit
