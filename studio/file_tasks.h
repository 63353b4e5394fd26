#pragma once

#include <cstdint>
#include <map>
#include <memory>
#include <optional>
#include <string>
#include <utility>
#include <variant>
#include <vector>

#include "base/error.h"
#include "studio/client_id.h"
#include "studio/files/document.h"
#include "studio/files/draft_store.h"
#include "studio/files/folder.h"
#include "studio/files/samples.h"
#include "studio/files/studio_settings.h"
#include "studio/files/uploads.h"
#include "studio/page_message.h"

namespace tessera {

/// What is done with files, on a thread that may wait for a disk. Plain values.
struct ListFiles {
  ClientId client = 0;
};
struct OpenFile {
  ClientId client = 0;
  std::string file;
};
/// Writes `document` as it is, if its file still is `expected`; without that, whatever it is.
struct SaveFile {
  ClientId client = 0;
  std::string file;  ///< of the document
  std::string as;    ///< where it is to be new; empty: `file`
  Document document;
  std::optional<FileVersion> expected{};
  bool is_new = false;                ///< else: it is to be a file that is not there
  std::vector<std::string> drafts{};  ///< as of DropDrafts, where that is done
};
/// Looks whether the file still is that version, or reads it whatever it is.
struct LookAtFile {
  std::string file;
  FileVersion known;    ///< empty: nobody knows any
  bool always = false;  ///< the file is read also where it is that version
};
struct KeepDraft {
  std::string file;
  Document document;
  Digest base;
};
/// Of a text that is saved or discarded: this program's draft, and those that it was made of.
struct DropDrafts {
  std::string file;
  std::vector<std::string> programs;  ///< that put them and have ended
};
/// Of a draft that was offered, and is not wanted.
struct DropOffered {
  std::string file;
  std::string program;
};
/// Writes files that are not there yet; the name of the first one gets a number where it is taken.
/// Nothing is written where another is there with other bytes.
struct CreateFiles {
  ClientId client = 0;
  std::vector<std::pair<std::string, std::string>> files;  ///< names and bytes
};
/// Makes files as CreateFiles does: a copy of a sample, without a title, and of what it names.
struct CopySample {
  ClientId client = 0;
  std::string sample;
};
/// As of Uploads.
struct BeginUpload {
  ClientId client = 0;
  uint32_t number = 0;
  std::string name;
  uint64_t size = 0;
};
struct AppendUpload {
  ClientId client = 0;
  uint32_t number = 0;
  std::string bytes;
  bool is_last = false;
};
struct DropUploads {
  ClientId client = 0;
};
/// As of Folder::remove_unfinished().
struct RemoveUnfinished {};
struct KeepSettings {
  std::string json;
};
/// As of StudioSettings::keep_of_folder(), of the folder that is served.
struct KeepWorkspace {
  std::string json;
};
/// As of StudioSettings::note_opened(), likewise.
struct NoteOpened {};
/// Looks whether files of a full picture could be written now; its own result where that is so.
struct CheckOutputs {
  ClientId client = 0;
  page::Render wish;
  std::map<std::string, Document> texts;  ///< that are to be rendered
};
using FileTask =
    std::variant<ListFiles, OpenFile, SaveFile, LookAtFile, KeepDraft, DropDrafts, DropOffered,
                 CreateFiles, CopySample, BeginUpload, AppendUpload, DropUploads, RemoveUnfinished,
                 KeepSettings, KeepWorkspace, NoteOpened, CheckOutputs>;

struct FilesListed {
  ClientId client = 0;
  FileList list;
};
struct FileOpened {
  ClientId client = 0;
  std::string file;
  Document document;
  FileVersion version;
  std::vector<KeptDraft> drafts{};  ///< the newest first
};
struct FileSaved {
  ClientId client = 0;
  std::string file;  ///< of the document
  std::string as;
  Document document;  ///< what was written
  SaveResult result;
};
struct FilesCreated {
  ClientId client = 0;
  std::string file;  ///< the first of them
};
struct UploadProgress {
  ClientId client = 0;
  uint32_t number = 0;
  Uploads::State state;
};
struct DraftKept {
  std::string file;
};
/// How a file is that was looked at.
struct FileLookedAt {
  std::string file;
  FileState state = FileState::same;
  FileVersion known;    ///< as of the task
  FileVersion version;  ///< as it is now
  std::optional<FileContent> content;
};
/// A task that could not be done.
struct FileFailed {
  ClientId client = 0;  ///< 0: nobody asked
  std::string request;  ///< "open", "save" ...
  std::string file;
  std::string why;
  std::optional<uint32_t> upload{};  ///< its number
  uint64_t number = 0;               ///< of a page's order, as of page::Render
  ExistingFiles existing{};          ///< that it would have replaced without being asked to
};
using FileResult = std::variant<FilesListed, FileOpened, FileSaved, FilesCreated, UploadProgress,
                                DraftKept, FileLookedAt, CheckOutputs, FileFailed>;

/// Where tasks are done.
struct FilePlaces {
  const Folder& folder;
  DraftStore* drafts = nullptr;  ///< null: none are kept
  const StudioSettings& settings;
  const Samples& samples;
  Uploads& uploads;
};

/// The drafts of whoever runs the program; null where there is no place for any.
std::unique_ptr<DraftStore> open_drafts();

/// Does the task. Nothing where there is nothing to tell: a draft was dropped, say.
std::optional<FileResult> do_file_task(const FileTask& task, const FilePlaces& places);

}  // namespace tessera
