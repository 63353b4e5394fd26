#include "studio/part_teller.h"

#include <nlohmann/json.hpp>
#include <utility>

#include "studio/page_answer.h"
#include "studio/picks.h"
#include "studio/view_filter.h"

namespace tessera {

SourceMap& PartTeller::map_of(const std::shared_ptr<const SceneReading>& reading) {
  if (!map_ || &map_->reading() != reading.get())
    map_ = std::make_unique<SourceMap>(reading, folder_);
  return *map_;
}

bool PartTeller::tell(const TellCenters& order) {
  send_(page_answer(order.client, "centers", centers_json(map_of(order.reading))));
  return !waiting_.empty();
}

bool PartTeller::tell(const TellParts& order) {
  const PartQuestion& question = order.question;
  SourceMap& map = map_of(question.reading);
  if (!question.whole) {
    send_(picked_answer(question, *order.film, map));
    return !waiting_.empty();
  }
  PartPicture picture = part_picture(question, *order.film, map);
  // The page gets the table before the frame.
  send_(std::move(picture.chains));
  BandQueue& waiting = waiting_[question.view];
  waiting.clear();
  waiting.add(picture.frame, pixels_of(std::move(picture.numbers), picture.frame.rect.width()),
              question.deflate);
  return catch_up();
}

}  // namespace tessera
