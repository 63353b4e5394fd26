#pragma once

#include <map>
#include <string>
#include <variant>
#include <vector>

#include "studio/studio_session.h"

namespace tessera {

/// The files and drafts of a studio in memory. What it is asked for is done at once.
struct FakeDisk {
  std::map<std::string, std::string> files;
  std::map<std::string, TextDraft> drafts{};
  std::string draft_failure{};  ///< why none can be kept; empty: it can
  /// Of programs that ended, the newest first.
  std::map<std::string, std::vector<KeptDraft>> left{};
  std::vector<FileTask> others{};  ///< that are not done here

  void carry_out(const FileTask& task, StudioSession& session) {
    if (const auto* const open = std::get_if<OpenFile>(&task)) {
      if (!files.contains(open->file)) {
        return session.take(FileFailed{open->client, "open", open->file, "not there"});
      }
      FileOpened opened{.client = open->client,
                        .file = open->file,
                        .document = Document(files[open->file]),
                        .version = version_of(open->file),
                        .drafts = left[open->file]};
      if (drafts.contains(open->file))
        opened.drafts.insert(opened.drafts.begin(), {"own", drafts[open->file]});
      session.take(opened);
    } else if (const auto* const save = std::get_if<SaveFile>(&task)) {
      FileSaved saved{save->client, save->file, save->as, save->document, {}};
      if (save->is_new && files.contains(save->file))
        return session.take(FileFailed{save->client, "save", save->file, "there is one"});
      if (save->expected && !files.contains(save->file)) {
        saved.result.state = FileState::deleted;
        return session.take(saved);
      }
      if (save->expected && save->expected->hash != version_of(save->file).hash) {
        saved.result.state = FileState::changed;
      } else {
        files[save->file] = save->document.bytes();
        drop_drafts(save->file, save->drafts);
      }
      saved.result.version = version_of(save->file);
      session.take(saved);
    } else if (const auto* const look = std::get_if<LookAtFile>(&task)) {
      FileLookedAt changed{look->file, FileState::same, look->known, version_of(look->file),
                           std::nullopt};
      if (!look->always && look->known.hash == changed.version.hash) return session.take(changed);
      changed.state = FileState::changed;
      changed.content.emplace();
      changed.content->bytes = files[look->file];
      changed.content->version = changed.version;
      session.take(changed);
    } else if (const auto* const check = std::get_if<CheckOutputs>(&task)) {
      for (const std::string& name : check->wish.outputs) {
        if (files.contains(name))
          return session.take(FileFailed{.client = check->client,
                                         .request = "render",
                                         .file = check->wish.file,
                                         .why = name,
                                         .number = check->wish.number,
                                         .existing = {name, 1}});
      }
      session.take(*check);
    } else if (const auto* const draft = std::get_if<KeepDraft>(&task)) {
      if (!draft_failure.empty())
        return session.take(FileFailed{0, "draft", draft->file, draft_failure});
      drafts[draft->file] = {"", draft->file, draft->base, 0, draft->document.text()};
      session.take(DraftKept{draft->file});
    } else if (const auto* const drop = std::get_if<DropDrafts>(&task)) {
      drop_drafts(drop->file, drop->programs);
    } else if (const auto* const refused = std::get_if<DropOffered>(&task)) {
      drop_left(refused->file, refused->program);
    } else if (!std::holds_alternative<RemoveUnfinished>(task) &&
               !std::holds_alternative<NoteOpened>(task)) {
      others.push_back(task);
    }
  }
  void drop_drafts(const std::string& file, const std::vector<std::string>& programs) {
    drafts.erase(file);
    for (const std::string& program : programs) drop_left(file, program);
  }
  void drop_left(const std::string& file, const std::string& program) {
    std::erase_if(left[file], [&](const KeptDraft& kept) { return kept.program == program; });
  }
  FileVersion version_of(const std::string& file) { return {Digest::of(files[file]), FileStamp{}}; }

  /// Carries out what the session orders until nothing is due. Files are done here; `handle` gets
  /// every other order and returns whether the session was told something.
  template <typename Handle>
  void carry_out_all(StudioSession& session, Time now, const Handle& handle) {
    for (bool again = true; again;) {
      again = false;
      for (StudioOrder& order : session.tick(now)) {
        if (const auto* const task = std::get_if<FileTask>(&order)) {
          carry_out(*task, session);
          again = true;
        } else if (handle(order)) {
          again = true;
        }
      }
    }
  }
};

}  // namespace tessera
