#include "studio/studio.h"

#include <spdlog/spdlog.h>

#include <atomic>
#include <future>
#include <map>
#include <mutex>
#include <tuple>
#include <utility>
#include <vector>

#include "base/error.h"
#include "base/program_folder.h"
#include "base/version.h"
#include "image/image_file.h"
#include "scenes/import/asset_folder.h"
#include "studio/exporter.h"
#include "studio/farm_frames.h"
#include "studio/files/draft_store.h"
#include "studio/files/folder.h"
#include "studio/files/samples.h"
#include "studio/files/studio_settings.h"
#include "studio/frame_runner.h"
#include "studio/new_scene.h"
#include "studio/page_answer.h"
#include "studio/page_server.h"
#include "studio/part_teller.h"
#include "studio/pass_runner.h"
#include "studio/picture_comparison.h"
#include "studio/picture_files.h"
#include "studio/picture_stream.h"
#include "studio/scene_reading.h"
#include "studio/source_reader.h"
#include "studio/studio_monitor.h"
#include "studio/studio_session.h"
#include "studio/worker_queue.h"
#include "web/embedded_file.h"

namespace tessera {
namespace {

constexpr Time kBetweenCatchUps = std::chrono::milliseconds(50);

}  // namespace

class Studio::Impl {
 public:
  Impl(const StudioOptions& options, std::function<void()> wake)
      : wake_(std::move(wake)),
        folder_(options.folder,
                options.is_read_only ? Folder::Access::read_only : Folder::Access::read_write),
        drafts_(options.is_read_only ? nullptr : open_drafts()),
        settings_(StudioSettings::default_folder()),
        samples_(Samples::folder_beside(program_folder())),
        places_{.folder = folder_.path().string(),
                .assets = options.assets,
                .samples = samples_.folder().string(),
                .cache = &cache_},
        parts_(places_.folder, sinks(), sender()),
        runner_({.tiles = [this](PassTiles tiles) { show(std::move(tiles)); },
                 .end = [this](PassEnd end) { ended_.push_back(std::move(end)); },
                 .progress =
                     [this](uint32_t serial, const JobProgress& progress) {
                       session_->take(serial, progress);
                     }}),
        frames_({.end = [this](FrameEnd end) { session_->take(end); },
                 .progress =
                     [this](uint64_t job, const JobProgress& progress) {
                       session_->take_progress(job, progress);
                     }}),
        monitor_(options.log),
        pictures_(sinks(),
                  [this](const ViewId& view, const Legend& legend) {
                    post(Answer{page_answer(view.client, "legend", legend_json(view, legend))});
                  }),
        exports_(folder_, sinks(), [this](SendText told) { post(Answer{std::move(told)}); }),
        comparer_(sinks(), sender()) {
    server_ = std::make_unique<PageServer>(
        PageServer::Options{options.address, options.token_file, options.public_address},
        [this](PageEvent event) { post(std::move(event)); });
    session_ = std::make_unique<StudioSession>(
        StudioFacts{.folder = folder_.path().string(),
                    .assets = options.assets.empty() ? "" : whole_path(options.assets).string(),
                    .file = scene_to_open(folder_, options.file),
                    .version = kBuild,
                    .settings = settings_.general().dump(),
                    .workspace = settings_.of_folder(folder_.path()).dump(),
                    .run = random_hex(),
                    .samples_folder = samples_.folder().string(),
                    .samples = samples_.names(),
                    .recent_folders = settings_.recent_folders(),
                    .is_read_only = options.is_read_only,
                    .workers = options.workers,
                    .worker_command = options.worker_command,
                    .deflate = !server_->is_local()},
        [this](const std::string& token) { return server_->role_of(token); });
    if (!options.farm.endpoint.empty()) connect_to(options.farm);
  }
  ~Impl() {
    // Nobody posts any more once the threads have ended.
    server_->stop();
    end_files();
    farm_.reset();
    file_thread_.reset();
    reading_thread_.reset();
    picture_thread_.reset();
    export_thread_.reset();
  }

  const PageServer& server() const { return *server_; }

  void look(Coordinator& coordinator, Time now) {
    runner_.look(coordinator, now);
    frames_.look(coordinator, now);
    for (PassEnd& end : std::exchange(ended_, {})) finish(std::move(end));
    std::vector<Event> events;
    {
      const std::lock_guard lock(mutex_);
      events.swap(events_);
    }
    for (Event& event : events) {
      std::visit([&](auto& what) { take(what, now); }, event);
    }
    // What cannot be begun ends at once, which may lead to further orders.
    do {
      for (PassEnd& end : std::exchange(ended_, {})) finish(std::move(end));
      for (StudioOrder& order : session_->tick(now)) {
        std::visit([&](auto& what) { carry_out(what, coordinator, now); }, order);
      }
    } while (!ended_.empty());
    if ((behind_ || downloading_ || parts_behind_ || compared_behind_) && now >= next_catch_up_) {
      next_catch_up_ = now + kBetweenCatchUps;
      picture_thread_->add([this] { behind_ = pictures_.catch_up(); });
      reading_thread_->add([this] { parts_behind_ = parts_.catch_up(); });
      export_thread_->add([this] {
        downloading_ = exports_.catch_up();
        compared_behind_ = comparer_.catch_up();
      });
    }
    for (SendText& message : monitor_.look(coordinator, session_->pages(), now))
      server_->send(message.client, std::move(message.text));
  }

 private:
  using Reading = std::shared_ptr<const SceneReading>;
  using ReadKey =
      std::tuple<uint64_t, bool, std::string, int, ViewFilter>;  ///< job, is_sample, file, frame
  struct Answer {
    SendText text;
  };
  using Outlined = std::shared_ptr<const FileOutline>;
  struct FrameProgress {
    uint64_t job = 0;
    JobProgress progress;
  };
  using Event = std::variant<PageEvent, FileResult, Reading, Answer, Outlined, FrameFinished,
                             FrameEnd, FrameProgress, FarmFrames::News, RequestDone, OutputRefused>;

  void connect_to(const FarmConnection& farm) {
    farm_endpoint_ = farm.endpoint;
    take_news({});
    farm_ = std::make_unique<FarmFrames>(
        farm, FarmFrames::Events{.end = [this](FrameEnd end) { post(std::move(end)); },
                                 .progress =
                                     [this](uint64_t job, const JobProgress& progress) {
                                       post(FrameProgress{job, progress});
                                     },
                                 .news = [this](const FarmFrames::News& news) { post(news); }});
  }
  void take_news(const FarmFrames::News& news) {
    nlohmann::json farm{{"endpoint", farm_endpoint_}};
    if (!news.trouble.empty()) farm["trouble"] = news.trouble;
    if (!news.jobs.empty()) farm.update(nlohmann::json::parse(news.jobs));
    session_->set_farm(std::move(farm));
  }

  PictureStream::Sinks sinks() {
    return [this](ClientId client) { return server_->sink_of(client); };
  }
  /// Texts by it overtake those that are posted.
  std::function<void(SendText)> sender() {
    return [this](SendText told) { server_->send(told.client, std::move(told.text)); };
  }
  template <typename What>
  void post(What what) {
    {
      const std::lock_guard lock(mutex_);
      events_.emplace_back(std::move(what));
    }
    wake_();
  }

  /// Does it on that thread. The session is told that it is done, whatever became of it.
  template <typename Work>
  void work_for(WorkerQueue& thread, RequestId request, Work work) {
    thread.add([this, request = std::move(request), work = std::move(work)] {
      try {
        work();
      } catch (...) {
        post(RequestDone{request});
        throw;
      }
      post(RequestDone{request});
    });
  }
  void do_later(FileTask task) {
    file_thread_->add([this, task = std::move(task)] {
      auto result = do_file_task(task, {folder_, drafts_.get(), settings_, samples_, uploads_});
      if (result) post(std::move(*result));
    });
  }
  /// What pages sent last is not lost.
  void end_files() {
    take_last_events();
    session_->keep_drafts();
    for (StudioOrders tasks = session_->take_file_tasks(); !tasks.empty();
         tasks = session_->take_file_tasks()) {
      for (StudioOrder& task : tasks) do_later(std::move(std::get<FileTask>(task)));
      std::promise<void> done;
      file_thread_->add([&done] { done.set_value(); });
      done.get_future().wait();
      take_last_events();
    }
  }
  void take_last_events() {
    const Time now = monotonic_now();
    std::vector<Event> events;
    {
      const std::lock_guard lock(mutex_);
      events.swap(events_);
    }
    for (Event& event : events) {
      if (auto* const of_page = std::get_if<PageEvent>(&event)) take(*of_page, now);
      auto* const of_file = std::get_if<FileResult>(&event);
      if (!of_file) continue;
      // No page hears of it any more.
      if (const auto* const failed = std::get_if<FileFailed>(of_file))
        spdlog::error("'{}' ({}): {}", failed->file, failed->request, failed->why);
      take(*of_file, now);
    }
  }

  void take(PageEvent& event, Time now) {
    switch (event.kind) {
      case PageEvent::Kind::connected:
        return session_->connect(event.client, now);
      case PageEvent::Kind::message:
        return session_->receive(event.client, event.text, now);
      case PageEvent::Kind::binary:
        return session_->receive_binary(event.client, event.text, now);
      case PageEvent::Kind::closed:
        session_->disconnect(event.client);
        picture_thread_->add([this, client = event.client] { pictures_.forget(client); });
    }
  }
  void take(FileResult& result, Time) { session_->take(result); }
  void take(Reading& reading, Time now) { session_->take(std::move(reading), now); }
  void take(FrameFinished& finished, Time) { session_->take(finished); }
  void take(FrameEnd& end, Time) { session_->take(end); }
  void take(FrameProgress& news, Time) { session_->take_progress(news.job, news.progress); }
  void take(FarmFrames::News& news, Time) { take_news(news); }
  void take(Outlined& outline, Time) { session_->take(std::move(outline)); }
  void take(const RequestDone& done, Time) { session_->take(done); }
  void take(const OutputRefused& refused, Time) { session_->take(refused); }
  void take(Answer& answer, Time) { server_->send(answer.text.client, answer.text.text); }

  void carry_out(SendText& order, Coordinator&, Time) {
    server_->send(order.client, std::move(order.text));
  }
  void carry_out(const CloseClient& order, Coordinator&, Time) {
    server_->close(order.client, order.code, order.reason);
  }
  void carry_out(FileTask& order, Coordinator&, Time) { do_later(std::move(order)); }
  void carry_out(ReadOrder& order, Coordinator&, Time now) {
    const auto open = order.texts.find(order.file);
    const bool is_edited = open != order.texts.end() && open->second.version() > 1;
    if (is_edited && order.job == 0) monitor_.latency().note_texts(order.revision, now);
    read(std::move(order));
  }
  void carry_out(SourceOrder& order, Coordinator&, Time) {
    RequestId request{order.client, page::name_of(order.request.what)};
    work_for(*reading_thread_, std::move(request),
             [this, asked = std::move(order)] { post(Answer{sources_.answer(asked)}); });
  }
  void carry_out(OutlineOrder& order, Coordinator&, Time) {
    reading_thread_->add([this, asked = std::move(order)] {
      post(std::make_shared<const FileOutline>(sources_.outline(asked)));
    });
  }
  void carry_out(const TraceAside& order, Coordinator& coordinator, Time now) {
    runner_.start(coordinator, order.order, now);
  }
  void carry_out(TellParts& order, Coordinator&, Time) {
    reading_thread_->add([this, told = std::move(order)] { parts_behind_ = parts_.tell(told); });
  }
  void carry_out(TellCenters& order, Coordinator&, Time) {
    RequestId request{order.client, "centers"};
    work_for(*reading_thread_, std::move(request),
             [this, told = std::move(order)] { parts_behind_ = parts_.tell(told); });
  }
  void carry_out(TracePass& order, Coordinator& coordinator, Time now) {
    begin(std::move(order), coordinator, now);
  }
  void carry_out(const EndPass& order, Coordinator& coordinator, Time now) {
    runner_.interrupt(coordinator, order.serial, now);
    view_of_.erase(order.serial);
  }
  void carry_out(const ChangeOutput& order, Coordinator&, Time) {
    picture_thread_->add([this, order] {
      try {
        if (order.output.color_management) check_color_management(*order.output.color_management);
      } catch (const Error& error) {
        return post(OutputRefused{order.view, order.output, error.what()});
      }
      pictures_.set_output(order.view, order.output, order.channel);
      behind_ = true;
    });
  }
  void carry_out(const ForgetView& order, Coordinator&, Time) {
    picture_thread_->add([this, order] { pictures_.forget(order.view); });
  }
  void carry_out(const TraceFrame& order, Coordinator& coordinator, Time now) {
    farm_ ? farm_->start(order) : frames_.start(coordinator, order, now);
  }
  void carry_out(const EndFrame& order, Coordinator& coordinator, Time now) {
    farm_ ? farm_->end(order) : frames_.end(coordinator, order, now);
  }
  void carry_out(const FinishFrame& order, Coordinator&, Time) {
    export_thread_->add([this, order] { post(finish_frame(order, folder_)); });
  }
  void carry_out(const ExportFile& order, Coordinator&, Time) {
    export_thread_->add([this, order] {
      exports_.make(order);
      downloading_ = true;
    });
  }
  void carry_out(const ExportUnfinished& order, Coordinator& coordinator, Time) {
    export_unfinished(order, coordinator);
  }
  void carry_out(const ExportView& order, Coordinator&, Time) {
    picture_thread_->add([this, order] {
      const auto whole = pictures_.whole({order.client, order.pane});
      export_thread_->add([this, order, whole] {
        exports_.make({.client = order.client,
                       .number = order.number,
                       .frame = whole.frame ? *whole.frame : FullFrame{},
                       .output = whole.output,
                       .goal = order.goal},
                      whole.film);
        downloading_ = true;
      });
    });
  }
  void carry_out(const PinPicture& order, Coordinator&, Time) {
    picture_thread_->add([this, order] {
      const auto film = pictures_.pin(order.view, order.what);
      behind_ = true;
      post(Answer{pinned_answer(order, film.get())});
    });
  }
  void carry_out(const ComparePictures& order, Coordinator&, Time) {
    picture_thread_->add([this, order] {
      const RequestId request{order.view.client, "compare"};
      try {
        const auto pair = pictures_.pair(order.view);
        work_for(*export_thread_, request,
                 [this, order, pair] { compared_behind_ = comparer_.compare(order, pair); });
      } catch (...) {
        post(RequestDone{request});
        throw;
      }
    });
  }
  void carry_out(const ProbePixel& order, Coordinator&, Time) {
    picture_thread_->add([this, order] {
      const auto value = pictures_.value_at(order.view, order.x, order.y);
      post(Answer{page_answer(order.view.client, "probed",
                              probed_json(order.view, order.x, order.y, value))});
    });
  }

  /// Newer texts replace those that wait to be read.
  void read(ReadOrder order) {
    const std::lock_guard lock(orders_mutex_);
    const ReadKey key(order.job, order.is_sample, order.file, order.frame, order.filter);
    const bool is_waiting = orders_.contains(key);
    orders_.insert_or_assign(key, std::move(order));
    if (is_waiting) return;
    reading_thread_->add([this, key] {
      ReadOrder next;
      {
        const std::lock_guard taking(orders_mutex_);
        next = std::move(orders_.extract(key).mapped());
      }
      post(Reading(std::make_shared<const SceneReading>(read_for_studio(next, places_))));
    });
  }

  void begin(TracePass trace, Coordinator& coordinator, Time now) {
    view_of_[trace.order.serial] = trace.view;
    picture_thread_->add(
        [this, view = trace.view, picture = trace.picture] { pictures_.begin(view, picture); });
    monitor_.latency().note_pass(trace.order.serial, trace.order.reading->revision);
    runner_.start(coordinator, trace.order, now);
  }

  void show(PassTiles tiles) {
    const auto view = view_of_.find(tiles.serial);
    if (view == view_of_.end()) return;
    monitor_.latency().note_pixels(tiles.serial, monotonic_now());
    session_->take(tiles);
    picture_thread_->add(
        [this, view = view->second, shared = std::make_shared<const PassTiles>(std::move(tiles))] {
          pictures_.add(view, *shared);
          behind_ = true;
        });
  }

  void finish(PassEnd end) {
    const auto view = view_of_.extract(end.serial);
    if (!view.empty() && end.film) {
      picture_thread_->add(
          [this, view = view.mapped(), serial = end.serial, film = end.film, frame = end.frame] {
            pictures_.finish(view, serial, frame->options->denoise ? denoised(*frame, *film) : film,
                             frame);
            behind_ = true;
          });
    }
    session_->take(end);
  }

  void export_unfinished(const ExportUnfinished& order, const Coordinator& coordinator) {
    const auto make = [this, file = order.file](const std::shared_ptr<const Film>& film) {
      export_thread_->add([this, file, film] {
        exports_.make(file, film);
        downloading_ = true;
      });
    };
    if (!farm_) return make(frames_.film(coordinator, order.job));
    farm_->ask_picture(order.job, [make](const FarmFrames::Picture& picture) {
      make(picture ? std::shared_ptr<const Film>(picture, &picture->film) : nullptr);
    });
  }

  std::function<void()> wake_;
  Folder folder_;
  std::unique_ptr<DraftStore> drafts_;
  Uploads uploads_{folder_};  ///< of the file thread
  StudioSettings settings_;
  Samples samples_;
  ReadCache cache_{uint64_t{512} << 20};  ///< of the reading thread
  ReadingPlaces places_;
  SourceReader sources_;  ///< of the reading thread
  PartTeller parts_;      ///< likewise
  std::unique_ptr<PageServer> server_;
  std::unique_ptr<StudioSession> session_;
  PassRunner runner_;
  std::vector<PassEnd> ended_;          ///< that the session was not told of yet
  std::map<uint32_t, ViewId> view_of_;  ///< by serial
  FrameRunner frames_;
  std::string farm_endpoint_;  ///< of farm_
  StudioMonitor monitor_;
  PictureStream pictures_;    ///< of the picture thread
  Exporter exports_;          ///< of the export thread
  PictureComparer comparer_;  ///< likewise
  std::atomic<bool> downloading_{false}, parts_behind_{false}, compared_behind_{false};
  std::atomic<bool> behind_{false};  ///< some page may not have got all its pixels
  Time next_catch_up_{};
  std::mutex mutex_;
  std::vector<Event> events_;
  std::mutex orders_mutex_;
  std::map<ReadKey, ReadOrder> orders_;  ///< that wait to be read

  // Last, so that they end first.
  std::unique_ptr<WorkerQueue> file_thread_ = std::make_unique<WorkerQueue>();
  std::unique_ptr<WorkerQueue> reading_thread_ = std::make_unique<WorkerQueue>();
  std::unique_ptr<WorkerQueue> export_thread_ = std::make_unique<WorkerQueue>();
  std::unique_ptr<WorkerQueue> picture_thread_ = std::make_unique<WorkerQueue>();
  std::unique_ptr<FarmFrames> farm_;  ///< that traces full pictures; null: our coordinator does
};

Studio::Studio(const StudioOptions& options, std::function<void()> wake)
    : impl_(std::make_unique<Impl>(options, std::move(wake))) {}

Studio::~Studio() = default;

std::string Studio::url() const { return impl_->server().url(); }

const std::string& Studio::token() const { return impl_->server().token(); }

void Studio::look(Coordinator& coordinator, Time now) { impl_->look(coordinator, now); }

}  // namespace tessera
