#include "client/partial_film.h"

#include <algorithm>
#include <cstring>
#include <utility>

#include "job/job_messages.h"

namespace tessera {
namespace {

constexpr Time kTilesEvery = std::chrono::milliseconds(100);
constexpr Time kTilesAgain = std::chrono::seconds(1);

}  // namespace

PartialFilm::PartialFilm(v1::DoneTilesQuery frame, const PixelRect& crop)
    : query_(std::move(frame)), film_(crop), came_(static_cast<size_t>(crop.area())) {}

std::optional<v1::DoneTilesQuery> PartialFilm::question(Time now) {
  if (now < next_question_) return std::nullopt;
  if (!waits_) query_.set_question(query_.question() + 1);
  waits_ = true;
  next_question_ = now + kTilesAgain;
  return query_;
}

std::vector<PixelRect> PartialFilm::on_answer(const v1::DoneTiles& answer, Time now) {
  std::vector<PixelRect> fresh;
  if (!waits_ || answer.question() != query_.question()) return fresh;
  waits_ = false;
  up_to_date_ = !answer.more();
  next_question_ = answer.more() ? now : now + kTilesEvery;
  query_.set_run(answer.run());
  query_.set_revision(answer.revision());
  query_.set_rows(answer.rows());
  for (const v1::DoneTiles::Piece& piece : answer.pieces()) {
    if (take(piece)) fresh.push_back(rect_of(piece.rect()));
  }
  return fresh;
}

bool PartialFilm::take(const v1::DoneTiles::Piece& piece) {
  const PixelRect rect = rect_of(piece.rect()), &all = film_.rect();
  const bool within = !rect.empty() && rect.x0 >= all.x0 && rect.y0 >= all.y0 &&
                      rect.x1 <= all.x1 && rect.y1 <= all.y1;
  if (!within || piece.light().size() != film_bytes(rect, {})) return false;
  std::vector<float> light(piece.light().size() / sizeof(float));
  std::memcpy(light.data(), piece.light().data(), piece.light().size());
  film_.write(rect, rect.y0, rect.height(), light);
  bool fresh = false;
  for (int y = rect.y0; y < rect.y1; ++y) {
    const auto first = came_.begin() + (int64_t{y - all.y0} * all.width() + rect.x0 - all.x0);
    fresh |= std::find(first, first + rect.width(), false) != first + rect.width();
    std::fill_n(first, rect.width(), true);
  }
  return fresh;
}

std::vector<PixelRect> PartialFilm::missing() const {
  const PixelRect& all = film_.rect();
  std::vector<PixelRect> rects;
  std::vector<size_t> above, here;  // those that end at this row, and those that reach below it
  for (int y = all.y0; y < all.y1; ++y) {
    const auto row = came_.begin() + int64_t{y - all.y0} * all.width();
    const auto end = row + all.width();
    here.clear();
    for (auto from = std::find(row, end, false); from != end;) {
      const auto to = std::find(from, end, true);
      const PixelRect span{all.x0 + static_cast<int>(from - row), y,
                           all.x0 + static_cast<int>(to - row), y + 1};
      const auto same = std::find_if(above.begin(), above.end(), [&](size_t i) {
        return rects[i].x0 == span.x0 && rects[i].x1 == span.x1;
      });
      if (same == above.end()) {
        here.push_back(rects.size());
        rects.push_back(span);
      } else {
        here.push_back(*same);
        rects[*same].y1 = span.y1;
      }
      from = std::find(to, end, false);
    }
    std::swap(above, here);
  }
  return rects;
}

}  // namespace tessera
