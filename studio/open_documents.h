#pragma once

#include <cstdint>
#include <functional>
#include <map>
#include <optional>
#include <set>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "base/monotonic.h"
#include "studio/page_message.h"
#include "studio/scene_reading.h"
#include "studio/studio_orders.h"

namespace tessera {

/// The documents that pages have open: who edits which, what is saved and what is not. A state
/// machine: messages, results of file tasks and instants come in, orders come out. Not thread-safe.
class OpenDocuments {
 public:
  static constexpr size_t kMostOpen = 32;
  /// So much of what is typed may be lost where the program is killed.
  static constexpr Time kDraftAfter = std::chrono::seconds(1);
  static constexpr Time kBetweenLooks = std::chrono::seconds(1);

  /// `orders` is where orders are put; it must outlive this. `may_edit` tells it of a client that
  /// was welcomed; who may not becomes nobody's editor.
  OpenDocuments(StudioOrders& orders, std::function<bool(ClientId)> may_edit)
      : orders_(orders), may_edit_(std::move(may_edit)) {}

  void open(ClientId client, const std::string& file);
  /// A page that connected again: of the texts that it has it is sent those that differ; of others
  /// it is told the version alone.
  void resume(ClientId client, ClientId before, const page::Hello& hello);
  /// Of a discarded text who else reads it is sent what the disk has.
  void close(ClientId client, const page::Close& close);
  void leave(ClientId client);
  void take_over(ClientId client, const std::string& file);
  void edit(ClientId client, const page::Edit& edit, Time now);
  void save(ClientId client, const page::Save& save);
  void reload(ClientId client, const std::string& file);
  void recover(ClientId client, const page::Recover& recover);

  void take(const FileOpened& opened);
  void take(const FileSaved& saved);
  void take(const FileLookedAt& changed);
  void take(const DraftKept& kept);
  void take(const FileFailed& failed);
  /// Keeps drafts and looks at files, where that is due.
  void tick(Time now);
  Time deadline() const;
  /// Keeps drafts of all that was typed since the last ones.
  void keep_drafts();

  /// A number that is another once any text is another one.
  uint64_t revision() const { return revision_; }
  OpenTexts texts() const;
  /// Null where the file is not open.
  const Document* document(const std::string& file) const;
  using Readers = std::set<ClientId>;
  void for_each(const std::function<void(const std::string& file, const Document& document,
                                         const Readers& readers)>& visit) const;
  /// Documents that were saved since the last call, by name.
  std::vector<std::string> take_saved() { return std::move(saved_); }

 private:
  static constexpr std::string_view kReadOnly = "the studio is read-only";

  struct OpenDocument {
    Document document;
    FileVersion on_disk;                    ///< that the document was read from or saved to
    uint64_t clean_version = 1;             ///< of the document, which the disk has
    ClientId editor = 0;                    ///< 0: nobody
    Readers readers;                        ///< the editor too
    std::vector<KeptDraft> drafts{};        ///< of programs that ended; the first one is offered
    std::vector<std::string> recovered{};   ///< who put those that the text was made of
    std::optional<Time> undrafted_since{};  ///< the first key that no draft has
    FileState state = FileState::same;      ///< of the disk, as was told
    std::string failure{};                  ///< of the last look at the file, as was told
    bool is_looked_at = false;              ///< a look at the file is under way
    /// Once that has ended the file is read, unless it is this version.
    std::optional<FileVersion> read_next{};
    bool has_draft_failed = false;  ///< the last one, which is due again
    std::string draft_failure{};    ///< of the last draft, as was told
    bool is_saving = false;         ///< a save is under way: the next ones have to know its result
    std::vector<std::pair<ClientId, page::Save>> saves_waiting{};

    bool is_dirty() const { return document.version() != clean_version; }
    const TextDraft* offered() const { return drafts.empty() ? nullptr : &drafts.front().draft; }
  };

  /// Has the file opened for the client, which has a text of that hash already; empty: none.
  void open(ClientId client, const std::string& file, const std::string& known_text);
  void send_document(ClientId client, const std::string& file, const OpenDocument& open);
  /// Sends the version alone where the client has the text and may edit it.
  void send_what_lacks(ClientId client, const std::string& file, const OpenDocument& open,
                       const std::string& known_text);
  void tell_readers(const OpenDocument& open, std::string_view kind, const nlohmann::json& fields,
                    ClientId but = 0);
  void refuse(ClientId client, std::string_view request, const std::string& file,
              std::string_view why);
  /// Null, and the client is told, where the file is not open.
  OpenDocument* find(ClientId client, std::string_view request, const std::string& file);
  /// Makes the text that of the file, and sends it to who reads it. Returns false where it cannot.
  bool follow_disk(const std::string& file, OpenDocument& open, const FileContent& content);
  /// Has the file read whatever it is, once the look that is under way has ended.
  void read_again(const std::string& file, OpenDocument& open, const FileVersion& known);
  void look_at(OpenDocument& open, const LookAtFile& task);
  void note_looked(const std::string& file, OpenDocument& open);
  void note_saved(const FileSaved& saved);
  /// None is under way.
  void begin_save(ClientId client, const page::Save& save, OpenDocument& open);
  /// The save that was under way has ended.
  void note_save_ended(const std::string& file);
  void keep_draft(const std::string& file, OpenDocument& open);
  /// What nobody reads and nothing waits for is closed.
  void close_unread(const std::string& file);
  void forget_reader(const std::string& file, ClientId client);

  StudioOrders& orders_;
  std::function<bool(ClientId)> may_edit_;
  std::map<std::string, OpenDocument> open_;
  /// Files that are being read: who waits for that, and the hash of the text that they have of it.
  std::map<std::string, std::map<ClientId, std::string>> opening_;
  uint64_t revision_ = 0;
  std::vector<std::string> saved_;
  Time next_look_{};
};

}  // namespace tessera
