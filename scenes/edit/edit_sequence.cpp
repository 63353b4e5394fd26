#include "scenes/edit/edit_sequence.h"

#include <utility>

namespace tessera::edit {

void EditSequence::apply(const Change& change) {
  if (refusal_) return;
  refusal_ = change.refusal;
  if (refusal_ || change.edits.empty()) return;
  Outline made = outline(now_.language(), apply_edits(now_.text(), change.edits));
  if (entity_ >= made.entities().size()) {
    refusal_ = Refusal{"a text with mistakes", "one whose parts stay what they are", {}};
    return;
  }
  for (size_t i = change.edits.size(); i-- > 0;)
    replace(change.edits[i].range, change.edits[i].text);
  now_ = std::move(made);
}

size_t EditSequence::split(uint32_t offset) {
  uint32_t at = 0;
  for (size_t i = 0; i < pieces_.size(); ++i) {
    const uint32_t size = pieces_[i].size();
    if (offset == at) return i;
    if (offset < at + size) {
      Piece behind = pieces_[i];
      const uint32_t cut = offset - at;
      Piece& before = pieces_[i];
      if (before.is_old) {
        before.old.end = behind.old.begin += cut;
      } else {
        before.made.resize(cut);
        behind.made.erase(0, cut);
      }
      pieces_.insert(pieces_.begin() + static_cast<ptrdiff_t>(i) + 1, std::move(behind));
      return i + 1;
    }
    at += size;
  }
  return pieces_.size();
}

void EditSequence::replace(SourceRange range, const std::string& text) {
  const size_t begin = split(range.begin);
  const size_t end = split(range.end);
  pieces_.erase(pieces_.begin() + static_cast<ptrdiff_t>(begin),
                pieces_.begin() + static_cast<ptrdiff_t>(end));
  pieces_.insert(pieces_.begin() + static_cast<ptrdiff_t>(begin), Piece{false, {}, text});
}

Change EditSequence::finish() const {
  Change change;
  change.refusal = refusal_;
  if (refusal_) return change;
  change.entity = static_cast<int>(entity_);
  uint32_t at = 0;
  std::string made;
  const auto flush = [&](uint32_t to) {
    if (to > at || !made.empty()) change.edits.push_back({{at, to}, made});
    made.clear();
    at = to;
  };
  for (const Piece& piece : pieces_) {
    if (!piece.is_old) {
      made += piece.made;
    } else if (piece.old.size() > 0) {
      flush(piece.old.begin);
      at = piece.old.end;
    }
  }
  flush(static_cast<uint32_t>(first_->text().size()));
  return change;
}

}  // namespace tessera::edit
