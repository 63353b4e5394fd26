#pragma once

#include <atomic>
#include <chrono>
#include <condition_variable>
#include <cstdint>
#include <functional>
#include <map>
#include <memory>
#include <mutex>
#include <string>
#include <thread>
#include <vector>

#include "client/submitted_job.h"
#include "front/farm_access.h"
#include "studio/render_orders.h"

namespace tessera {

/// Has full pictures traced by a farm elsewhere, each frame as a job of that farm. The jobs outlive
/// a lost connection: what the farm has finished meanwhile is fetched once it answers again. They
/// are deleted there when they are fetched or cancelled. Methods may be called by any thread.
class FarmFrames {
 public:
  /// How the farm is: whether it answers, and its jobs.
  struct News {
    std::string trouble{};  ///< why it does not answer; empty: it does
    std::string jobs{};     ///< the object of `tessera status --json`; empty: not known
    friend bool operator==(const News&, const News&) = default;
  };
  using Picture = std::shared_ptr<const RenderedPicture>;
  /// Called by the thread of this object, and to be quick.
  struct Events {
    std::function<void(FrameEnd)> end;
    std::function<void(uint64_t job, const JobProgress&)> progress;
    std::function<void(const News&)> news;
  };
  /// Reads the keys and begins to connect. Throws usage_error for a key that is missing or wrong.
  FarmFrames(const FarmConnection& connection, Events events);
  /// What has not ended then stays at the farm.
  ~FarmFrames();
  FarmFrames(const FarmFrames&) = delete;
  FarmFrames& operator=(const FarmFrames&) = delete;

  /// Goes on with a frame that was ended but keeps its tiles.
  void start(const TraceFrame& order);
  /// Its end is not told any more.
  void end(const EndFrame& order);
  /// Calls `take`, on the thread of this object, with the light that is done; null: there is none.
  void ask_picture(uint64_t job, std::function<void(Picture)> take);

 private:
  using Clock = std::chrono::steady_clock;
  static constexpr std::chrono::milliseconds kBetweenLooks{200}, kBetweenLists{1000};

  /// A frame at the farm, or on its way there.
  struct Task {
    FullFrame frame{};
    std::shared_ptr<const SubmittedJob> submission{};  ///< the same one until the farm has it
    uint64_t job = 0;                                  ///< of the farm; 0: not submitted yet
    bool is_dropped = false;
    bool shall_pause = false, is_paused = false;
    Clock::time_point begun = Clock::now();
  };
  using Request = std::function<void()>;

  void add(Request request);
  void run();
  void look();
  /// Does what is to be done for the task; whether nothing is any more.
  bool advance(uint64_t number, Task& task);
  void submit(uint64_t number, Task& task);
  void drop(const Task& task);
  /// Orders what a job that has ended, or is not there any more, need not do.
  void order(const Task& task, v1::JobQuery::Action action);
  bool follow(uint64_t number, Task& task);
  void show(uint64_t number, const std::function<void(Picture)>& take);
  void tell(News news);

  Events events_;
  FarmAccess farm_;
  std::atomic<bool> is_ending_{false};

  // Of the thread.
  std::map<uint64_t, Task> tasks_;  ///< by the queue's number
  News told_;
  Clock::time_point next_list_{};

  std::mutex mutex_;
  std::condition_variable changed_;
  std::vector<Request> requests_;
  std::thread thread_;  ///< last, so that it begins when all else is there
};

}  // namespace tessera
