#pragma once

#include <cstdint>
#include <deque>
#include <map>
#include <memory>
#include <nlohmann/json_fwd.hpp>
#include <optional>
#include <string>
#include <vector>

#include "base/monotonic.h"
#include "studio/page_message.h"
#include "studio/studio_orders.h"

namespace tessera {

/// Full pictures that pages ask for, one after another: read, traced, finished and written, each
/// frame in turn. A state machine like OpenDocuments. Not thread-safe.
class RenderQueue {
 public:
  /// That are not over yet.
  static constexpr size_t kMostJobs = 64;
  /// Of those that are over the newest stay in the list.
  static constexpr size_t kMostOver = 64;
  /// Pictures stay in memory for exports, the newest ones, until they are more than this.
  static constexpr uint64_t kKeptBytes = uint64_t{256} << 20;
  /// Of the files that a job wrote the newest are named in the list, which is sent for each frame.
  static constexpr size_t kMostNamed = 8;
  static constexpr Time kBetweenLists = std::chrono::milliseconds(250);

  /// `orders` is where orders are put; it must outlive this. The folders are those of
  /// command_line().
  RenderQueue(StudioOrders& orders, std::string folder, std::string assets)
      : orders_(orders), folder_(std::move(folder)), assets_(std::move(assets)) {}

  /// Whether add() would take it now; else the client is told why not.
  bool accepts(ClientId client, const page::Render& wish);
  /// `texts`: as they are now, which is what is rendered.
  void add(ClientId client, const page::Render& wish, const OpenTexts& texts);
  void order(ClientId client, const page::RenderOrder& order);

  /// Of an order that names one of its jobs.
  void take(std::shared_ptr<const SceneReading> reading);
  void take(uint64_t job, const JobProgress& progress);
  void take(const FrameEnd& end);
  void take(const FrameFinished& finished);

  /// Orders what is due, and returns whether pages are to be sent list() anew.
  bool tick(Time now);
  Time deadline() const { return deadline_; }
  nlohmann::json list() const;

  /// The last picture of the job, as it is to be exported; nothing where there is none.
  std::optional<ExportFile> picture(uint64_t job) const;
  /// The same of a frame that is being traced, still without its picture.
  std::optional<ExportFile> unfinished_picture(uint64_t job) const;

 private:
  enum class State { queued, reading, tracing, finishing, done, failed, cancelled };
  struct Job {
    uint64_t number = 0;
    page::Render wish;
    OpenTexts texts;
    std::shared_ptr<const RenderOptions> options;
    std::shared_ptr<AnimationFiles> animations{};  ///< null: it is no animation
    int next = 0;                                  ///< frame, counted from the first one
    State state = State::queued;
    bool is_paused = false;
    bool is_cancelled = false;  ///< once it may end
    FullFrame frame{};          ///< that is being traced or was last
    JobProgress progress{};
    std::shared_ptr<const RenderedPicture> picture{};
    std::deque<std::string> written{};  ///< the newest
    size_t written_count = 0;           ///< of all
    std::string why{};
    double seconds = 0;  ///< of the frames that were traced

    int frames() const { return wish.frames ? wish.frames->last - wish.frames->first + 1 : 1; }
    std::optional<int> next_number() const {
      return wish.frames ? std::optional(wish.frames->first + next) : wish.frame;
    }
    bool is_over() const { return state >= State::done; }
  };

  std::string fault_of(const page::Render& wish) const;
  static std::string_view name_of(const Job& job);
  nlohmann::json json_of(uint64_t number, const Job& job) const;
  Job* active(State state, uint64_t job);
  void end(Job& job, State state, std::string why = {});
  void pause(uint64_t number, Job& job);
  void cancel(uint64_t number, Job& job);
  void begin_next();
  void drop_old_pictures();
  /// How many jobs are over.
  size_t count_over() const;

  StudioOrders& orders_;
  std::string folder_;
  std::string assets_;
  std::map<uint64_t, Job> jobs_;
  uint64_t last_job_ = 0;
  uint64_t active_ = 0;  ///< that threads work for; 0: none
  bool is_changed_ = false, is_progressed_ = false;
  Time next_list_{};
  Time deadline_ = Time::max();
};

}  // namespace tessera
