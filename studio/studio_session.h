#pragma once

#include <cstdint>
#include <functional>
#include <map>
#include <memory>
#include <nlohmann/json.hpp>
#include <string>
#include <string_view>
#include <vector>

#include "base/digest.h"
#include "base/monotonic.h"
#include "base/silence.h"
#include "studio/latest_requests.h"
#include "studio/live_views.h"
#include "studio/open_documents.h"
#include "studio/picks.h"
#include "studio/render_queue.h"
#include "studio/source_edits.h"
#include "studio/studio_orders.h"

namespace tessera {

/// What a studio begins with. `settings` and `workspace` follow what the page keeps; the rest
/// stays.
struct StudioFacts {
  std::string folder;            ///< the opened one, absolute
  std::string assets{};          ///< holds what scenes name, absolute; empty: the opened one does
  std::string file;              ///< to open first; empty: none
  std::string version;           ///< of the program
  std::string settings;          ///< what the page kept before, as JSON
  std::string workspace{};       ///< likewise of this folder
  std::string run{};             ///< a secret of this run, by which it knows the ids that it gave
  std::string samples_folder{};  ///< absolute
  std::vector<std::string> samples{};         ///< files of that
  std::vector<std::string> recent_folders{};  ///< opened before, absolute, the newest first
  bool is_read_only = false;
  int workers = 0;
  std::string worker_command{};  ///< that has another process trace for it; empty: none does
  bool deflate = false;          ///< pixels go over a network
};

/// What a token lets its bearer do.
enum class StudioRole { none, viewer, editor };

/// All that pages, texts and views of one studio are: takes messages of pages, results of the
/// threads around it and the time, and gives orders. Has no socket, file, thread or clock. Whatever
/// a page sends makes it throw nothing. Not thread-safe.
class StudioSession {
 public:
  using RoleOf = std::function<StudioRole(const std::string& token)>;
  StudioSession(StudioFacts facts, RoleOf role_of);

  void connect(ClientId client, Time now);
  void receive(ClientId client, std::string_view message, Time now);
  /// Of a binary frame.
  void receive_binary(ClientId client, std::string_view frame, Time now);
  void disconnect(ClientId client);

  void take(const FileResult& result);
  void take(std::shared_ptr<const SceneReading> reading, Time now);
  void take(std::shared_ptr<const FileOutline> outline) { sources_.take(std::move(outline)); }
  void take(const RequestDone& done) { requests_.take(done); }
  void take(const PassEnd& end);
  void take(uint32_t serial, const JobProgress& progress);
  void take(const PassTiles& tiles) { views_.take(tiles); }
  void take(const OutputRefused& refused) { views_.take(refused); }
  void take(const FrameEnd& end) { renders_.take(end); }
  void take(const FrameFinished& finished) { renders_.take(finished); }
  /// How the farm elsewhere is that traces full pictures, for all pages.
  void set_farm(nlohmann::json farm);
  void take_progress(uint64_t job, const JobProgress& progress) { renders_.take(job, progress); }

  /// What is due by now. To be called after each of the above and at deadline().
  StudioOrders tick(Time now);
  Time deadline() const;
  /// Orders drafts of all that is not saved.
  void keep_drafts() { documents_.keep_drafts(); }
  /// What is to be done with files before the program ends, such as to save them.
  StudioOrders take_file_tasks();
  /// The pages that have said who they are.
  std::vector<ClientId> pages() const;
  /// Sends the message to all pages.
  void tell_all(std::string_view kind, const nlohmann::json& fields);

  static constexpr Time kHelloWithin = std::chrono::seconds(2);
  static constexpr size_t kMostClients = 32;
  /// Clients that have not said hello yet.
  static constexpr size_t kMostUnknown = 8;
  static constexpr size_t kMostHelloBytes = size_t{64} << 10;
  /// So many at once, and so many a second after them.
  struct FlowLimit {
    int at_once;
    int per_second;
  };
  static constexpr FlowLimit kMostMessages{.at_once = 400, .per_second = 200};
  /// Of pages that come, whichever: to come anew frees nobody from the limit above for long.
  static constexpr FlowLimit kMostWelcomes{.at_once = 64, .per_second = 64};
  /// Of files on their way, not written yet.
  static constexpr int kMostChunksWaiting = 4;

 private:
  /// What comes, held against a limit by the generic cell rate algorithm (ITU-T I.371).
  class Flow {
   public:
    /// Counts one more, unless that is too many; whether it is.
    bool exceeds(const FlowLimit& limit, Time now);

   private:
    Time settled_{};  ///< when all that came would have come at the limit's rate
  };
  struct Client {
    StudioRole role = StudioRole::none;
    Silence silence{Time{0}};  ///< since it connected, until its hello
    std::string id;            ///< of its page, which it keeps when it resumes
    Flow messages{};
    int chunks_waiting = 0;
  };

  /// Ends its connection, with the reason.
  void shut_out(ClientId client, uint16_t code, std::string_view why);
  /// Gives the views the texts as they are now.
  void show_texts();
  void handle(ClientId client, const page::Message& message, Time now);
  /// The id of the page that was the client when it first connected.
  std::string id_of(ClientId client) const;
  /// Whether id_of() gave it in this run.
  bool is_of_this_run(const std::string& id) const;
  void welcome(ClientId client, const page::Hello& hello);
  void create(ClientId client, const page::Create& create);
  void render(ClientId client, const page::Render& wish);
  void put(ClientId client, const page::Put& put);
  void note_chunk_written(ClientId client);
  void tell(const UploadProgress& progress);
  /// Of a failed upload.
  void tell(const FileFailed& failed);
  bool may_edit(ClientId client) const;
  bool may_say(ClientId client, const page::Message& message) const;
  void export_file(ClientId client, const page::Export& wish);

  StudioFacts facts_;
  RoleOf role_of_;
  StudioOrders orders_;
  LatestRequests requests_;
  OpenDocuments documents_;
  SourceEdits sources_;
  LiveViews views_;
  Picks picks_;
  RenderQueue renders_;
  nlohmann::json farm_;  ///< null: there is none
  std::map<ClientId, Client> clients_;
  Flow welcomes_;
  uint64_t shown_revision_ = 0;
  Time deadline_ = Time::max();
};

}  // namespace tessera
