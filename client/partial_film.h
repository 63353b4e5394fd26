#pragma once

#include <optional>
#include <vector>

#include "base/monotonic.h"
#include "proto/tessera/v1/farm.pb.h"
#include "renderer/film/film.h"

namespace tessera {

/// The light of a frame that a coordinator elsewhere has traced so far: asks for what is new, and
/// keeps it. Has no socket, thread or clock.
class PartialFilm {
 public:
  /// `frame` names the job and the frame; `crop` is that of the job.
  PartialFilm(v1::DoneTilesQuery frame, const PixelRect& crop);

  /// What to ask now: where more is known to be there, at once, else ten times a second, and again
  /// each second where no answer comes.
  std::optional<v1::DoneTilesQuery> question(Time now);
  /// The rectangles that `answer` brings and that no answer before has brought. None for one that
  /// does not answer the last question or is not of this film.
  std::vector<PixelRect> on_answer(const v1::DoneTiles& answer, Time now);
  /// Whether the last answer had all that there was.
  bool is_up_to_date() const { return up_to_date_; }
  /// The rest of the crop, in as many rectangles as it takes.
  std::vector<PixelRect> missing() const;
  /// Black where nothing has come.
  const Film& film() const { return film_; }

 private:
  bool take(const v1::DoneTiles::Piece& piece);

  v1::DoneTilesQuery query_;
  Film film_;
  std::vector<bool> came_;  ///< by pixel of the crop
  Time next_question_{};
  bool waits_ = false;  ///< for the answer to query_
  bool up_to_date_ = false;
};

}  // namespace tessera
