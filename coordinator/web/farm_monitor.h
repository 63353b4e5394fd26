#pragma once

#include <cstdint>
#include <functional>
#include <map>
#include <memory>
#include <mutex>
#include <optional>
#include <utility>
#include <vector>

#include "base/monotonic.h"
#include "coordinator/jobs/farm_snapshot.h"
#include "proto/tessera/v1/farm.pb.h"

namespace tessera {

class Coordinator;

/// How the farm was in one second, for graphs.
struct FarmSample {
  double at = 0;  ///< seconds since the coordinator was started
  double tiles_per_second = 0, result_bytes_per_second = 0;
  uint64_t workers = 0, threads = 0, tiles_held = 0;
  uint64_t coordinator_bytes = 0, worker_bytes = 0;  ///< resident memory
};

/// The farm as it was last seen; never changes.
struct FarmShown {
  FarmSnapshot snapshot;
  std::shared_ptr<const std::vector<FarmSample>> history;  ///< one a second, of ten minutes
};

/// One frame as it was last seen; never changes.
struct FrameShown {
  int32_t number = 0;                           ///< by which users know it
  std::vector<TileSnapshot> tiles;              ///< none where it is not being traced
  std::shared_ptr<const PreviewImage> preview;  ///< null: nothing yet
  /// By tile, whether it was done when the preview was made; null as that is.
  std::shared_ptr<const std::vector<bool>> pictured;
};

/// Stands between the thread of a coordinator, which shows itself to it, and those who watch. What
/// is shown is made once for all of them and only where somebody asks, and takes a small share of
/// that thread, however many watch and however they behave.
class FarmMonitor {
 public:
  /// To be called often on the coordinator's thread: shows what is due, and does what was ordered.
  void look(Coordinator& coordinator, Time now);

  // From any thread. Replies are called by look(), on its thread, and are to be quick.
  /// Null before the first look.
  std::shared_ptr<const FarmShown> farm() const;
  /// When look() was last called.
  Time last_look() const;
  using FrameReply = std::function<void(std::shared_ptr<const FrameShown>)>;
  /// Asks for a frame as it is. Each of these is false where too much waits for that already.
  bool watch(uint64_t job, uint32_t frame, FrameReply reply);
  /// Asks the coordinator once for what nobody watches, such as a timeline or a whole picture.
  using Question = std::function<void(Coordinator&, Time now)>;
  bool ask(Question question);
  using OrderReply = std::function<void(const v1::JobStatus&)>;
  bool order(v1::JobQuery query, OrderReply reply);
  using NewsReply = std::function<void(uint64_t news)>;
  /// Waits until Coordinator::news() is not `known`, or for some seconds.
  bool ask_news(uint64_t known, NewsReply reply);

  /// What was asked of the coordinator's thread so far.
  struct Work {
    uint64_t looks = 0, snapshots = 0, tile_lists = 0, previews = 0, orders = 0;
  };
  Work work() const;

 private:
  using FrameKey = std::pair<uint64_t, uint32_t>;  ///< job, frame
  struct Watched {
    std::shared_ptr<const FrameShown> shown = std::make_shared<FrameShown>();
    Time wanted{}, next_tiles{}, previewed{};
    bool preview_is_final = false;
    std::vector<FrameReply> waiting;
  };
  struct FrameQuestion {
    FrameKey key;
    FrameReply reply;
  };
  struct Order {
    v1::JobQuery query;
    OrderReply reply;
  };
  struct NewsQuestion {
    uint64_t known = 0;
    std::optional<Time> until;  ///< nothing: as yet not looked at
    NewsReply reply;
  };
  struct Inbox {
    std::vector<NewsQuestion> news;
    std::vector<FrameQuestion> frames;
    std::vector<Question> questions;
    std::vector<Order> orders;
  };

  void carry_out(std::vector<Order> orders, Coordinator& coordinator, Time now);
  void show_farm(const Coordinator& coordinator, Time now);
  void sample(const FarmSnapshot& snapshot, Time now);
  void note_watchers(std::vector<FrameQuestion> questions, Time now);
  /// False where all that are watched are waited for.
  bool make_room();
  void show_tiles(Coordinator& coordinator, Time now);
  void tell_news(Time now);
  void show_oldest_preview(Coordinator& coordinator, Time now);
  void tell_watchers();

  // Of the thread of look().
  Time next_snapshot_{}, next_sample_{}, next_preview_{}, next_question_{}, next_orders_{};
  Time next_news_{}, next_first_preview_{};  ///< what need not wait for its turn, but for its share
  uint64_t news_ = 0;                        ///< that was shown
  FarmSnapshot::Counters sampled_;
  double sampled_at_ = 0;
  std::shared_ptr<const std::vector<FarmSample>> history_;
  std::map<FrameKey, Watched> watched_;

  mutable std::mutex mutex_;
  Inbox inbox_;
  std::shared_ptr<const FarmShown> farm_;
  Time last_look_{};
  Work work_;
};

}  // namespace tessera
