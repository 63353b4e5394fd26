#pragma once

#include <functional>
#include <string>
#include <vector>

#include "scenes/edit/edit.h"

namespace tessera::edit {

/// Several changes one after the other, each of the text that those before it made, as one change
/// of the first text.
class EditSequence {
 public:
  explicit EditSequence(const Outline& outline) : first_(&outline), now_(outline) {
    pieces_.push_back({true, {0, static_cast<uint32_t>(outline.text().size())}, ""});
  }

  const Outline& now() const { return now_; }
  /// From now on a change is refused that leaves no entity of that number, as one may of a text
  /// with mistakes.
  void keep(int entity) { entity_ = static_cast<size_t>(entity); }
  /// Nothing more is done once one was refused.
  void apply(const Change& change);
  template <typename Make>
  void then(const Make& make) {
    if (!refusal_) apply(make(now_));
  }
  Change finish() const;

 private:
  /// A stretch of the first text, or new text.
  struct Piece {
    bool is_old = true;
    SourceRange old;
    std::string made;
    uint32_t size() const { return is_old ? old.size() : static_cast<uint32_t>(made.size()); }
  };
  void replace(SourceRange range, const std::string& text);
  /// Makes `offset` of the present text a border between pieces; the index of the one behind it.
  size_t split(uint32_t offset);

  const Outline* first_;
  Outline now_;
  size_t entity_ = 0;
  std::vector<Piece> pieces_;
  std::optional<Refusal> refusal_;
};

}  // namespace tessera::edit
