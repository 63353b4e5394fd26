#include <algorithm>
#include <utility>

#include "studio/open_documents.h"
#include "studio/page_answer.h"

// Of OpenDocuments: what is saved, and drafts of what is not.

namespace tessera {
namespace {

std::string_view why_not_saved(FileState state) {
  return state == FileState::deleted
             ? "the file is no longer on the disk; saving once more writes it anew"
             : "another program has changed the file; keep your text, or load the file's";
}

}  // namespace

void OpenDocuments::save(ClientId client, const page::Save& save) {
  OpenDocument* const open = find(client, "save", save.file);
  if (!open) return;
  if (!may_edit_(client)) return refuse(client, "save", save.file, kReadOnly);
  if (!open->document.is_editable())
    return refuse(client, "save", save.file, open->document.why_not_editable());
  if (!open->is_saving) return begin_save(client, save, *open);
  const std::pair waiting(client, save);
  // Asked for again it is answered once.
  if (std::ranges::find(open->saves_waiting, waiting) == open->saves_waiting.end())
    open->saves_waiting.push_back(waiting);
}

void OpenDocuments::begin_save(ClientId client, const page::Save& save, OpenDocument& open) {
  if (open.state == FileState::changed && !save.force && save.as.empty()) {
    orders_.push_back(
        page_answer(client, "disk", {{"file", save.file}, {"state", name_of(open.state)}}));
    return refuse(client, "save", save.file, why_not_saved(open.state));
  }
  SaveFile task{.client = client,
                .file = save.file,
                .as = save.as,
                .document = open.document,
                .drafts = open.recovered};
  // Whoever forces it means what was told of the disk last, and no later change.
  if (save.as.empty()) {
    task.is_new = open.state == FileState::deleted;
    if (!task.is_new) task.expected = open.on_disk;
  }
  open.is_saving = true;
  orders_.push_back(FileTask(std::move(task)));
}

void OpenDocuments::note_save_ended(const std::string& file) {
  const auto at = open_.find(file);
  if (at == open_.end()) return;
  OpenDocument& open = at->second;
  open.is_saving = false;
  while (!open.is_saving && !open.saves_waiting.empty()) {
    const auto [client, save] = std::move(open.saves_waiting.front());
    open.saves_waiting.erase(open.saves_waiting.begin());
    begin_save(client, save, open);
  }
  close_unread(file);
}

void OpenDocuments::take(const FileSaved& saved) {
  note_saved(saved);
  note_save_ended(saved.file);
}

void OpenDocuments::note_saved(const FileSaved& saved) {
  const auto at = open_.find(saved.file);
  if (saved.result.state != FileState::same) {
    if (at != open_.end()) {
      at->second.state = saved.result.state;
      // The page is told at once what its text would go over.
      if (saved.result.state == FileState::changed)
        read_again(saved.file, at->second, at->second.on_disk);
    }
    orders_.push_back(page_answer(saved.client, "disk",
                                  {{"file", saved.file}, {"state", name_of(saved.result.state)}}));
    return refuse(saved.client, "save", saved.file, why_not_saved(saved.result.state));
  }
  const uint64_t version = saved.document.version();
  if (at != open_.end() && saved.as.empty()) {
    OpenDocument& open = at->second;
    open.on_disk = saved.result.version;
    open.clean_version = version;
    open.state = FileState::same;
    if (!open.is_dirty()) open.undrafted_since.reset();
  }
  saved_.push_back(saved.as.empty() ? saved.file : saved.as);
  nlohmann::json fields{
      {"file", saved.file}, {"version", version}, {"hash", saved.result.version.hash.hex()}};
  if (!saved.as.empty()) fields["as"] = saved.as;
  orders_.push_back(page_answer(saved.client, "saved", std::move(fields)));
}

void OpenDocuments::recover(ClientId client, const page::Recover& recover) {
  OpenDocument* const open = find(client, "recover", recover.file);
  if (!open || open->editor != client || open->drafts.empty()) return;
  std::string program = std::move(open->drafts.front().program);
  open->drafts.erase(open->drafts.begin());
  if (recover.take) {
    open->recovered.push_back(std::move(program));
  } else {
    orders_.push_back(FileTask(DropOffered{recover.file, std::move(program)}));
  }
  if (const TextDraft* const next = open->offered()) {
    nlohmann::json fields = draft_json(*next);
    fields["file"] = recover.file;
    orders_.push_back(page_answer(client, "draft", std::move(fields)));
  }
}

void OpenDocuments::take(const DraftKept& kept) {
  if (const auto at = open_.find(kept.file); at != open_.end()) at->second.draft_failure.clear();
}

void OpenDocuments::keep_draft(const std::string& file, OpenDocument& open) {
  open.undrafted_since.reset();
  if (open.is_dirty())
    orders_.push_back(FileTask(KeepDraft{file, open.document, open.on_disk.hash}));
}

void OpenDocuments::keep_drafts() {
  for (auto& [file, open] : open_) {
    if (open.undrafted_since) keep_draft(file, open);
  }
}

}  // namespace tessera
