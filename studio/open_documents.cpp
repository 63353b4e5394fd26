#include "studio/open_documents.h"

#include <fmt/format.h>

#include <algorithm>
#include <span>
#include <utility>

#include "studio/page_answer.h"

namespace tessera {

namespace {

using Json = nlohmann::json;

}  // namespace

void OpenDocuments::refuse(ClientId client, std::string_view request, const std::string& file,
                           std::string_view why) {
  orders_.push_back(refusal(client, request, file, why));
}

void OpenDocuments::open(ClientId client, const std::string& file) { open(client, file, ""); }

void OpenDocuments::open(ClientId client, const std::string& file, const std::string& known_text) {
  if (const auto at = open_.find(file); at != open_.end()) {
    at->second.readers.insert(client);
    if (at->second.editor == 0 && may_edit_(client)) at->second.editor = client;
    return send_document(client, file, at->second);
  }
  if (!opening_.contains(file) && open_.size() + opening_.size() >= kMostOpen)
    return refuse(client, "open", file,
                  fmt::format("{} files are open; expected at most that many", kMostOpen));
  const auto [waiting, is_first] = opening_.try_emplace(file);
  waiting->second.insert_or_assign(client, known_text);
  if (is_first) orders_.push_back(FileTask(OpenFile{client, file}));
}

void OpenDocuments::resume(ClientId client, ClientId before, const page::Hello& hello) {
  for (const auto& [file, known] : hello.have) {
    const auto at = open_.find(file);
    if (at == open_.end()) {
      open(client, file, known.sha256);
      continue;
    }
    OpenDocument& open = at->second;
    open.readers.erase(before);
    open.readers.insert(client);
    if (open.editor == before) open.editor = 0;
    if (open.editor == 0 && may_edit_(client)) open.editor = client;
    send_what_lacks(client, file, open, known.sha256);
  }
}

void OpenDocuments::take(const FileOpened& opened) {
  const auto waiting = opening_.extract(opened.file);
  if (waiting.empty()) return;
  OpenDocument open{.document = opened.document,
                    .on_disk = opened.version,
                    .clean_version = opened.document.version(),
                    .readers = {},
                    .drafts = opened.drafts};
  for (const auto& [client, known_text] : waiting.mapped()) open.readers.insert(client);
  // What is on disk already is no loss.
  const std::string text = open.document.text();
  std::erase_if(open.drafts, [&](const KeptDraft& kept) {
    if (kept.draft.text != text) return false;
    orders_.push_back(FileTask(DropOffered{opened.file, kept.program}));
    return true;
  });
  if (open.readers.empty()) return;
  const auto editor = std::ranges::find_if(open.readers, may_edit_);
  if (editor != open.readers.end()) open.editor = *editor;
  ++revision_;
  const OpenDocument& kept = open_.insert_or_assign(opened.file, std::move(open)).first->second;
  for (const auto& [client, known_text] : waiting.mapped())
    send_what_lacks(client, opened.file, kept, known_text);
}

void OpenDocuments::send_what_lacks(ClientId client, const std::string& file,
                                    const OpenDocument& open, const std::string& known_text) {
  if (known_text.empty() || open.editor != client) return send_document(client, file, open);
  const std::string text = open.document.text();
  if (sha256_hex(std::as_bytes(std::span(text))) != known_text)
    return send_document(client, file, open);
  orders_.push_back(
      page_answer(client, "edited", {{"file", file}, {"version", open.document.version()}}));
}

void OpenDocuments::send_document(ClientId client, const std::string& file,
                                  const OpenDocument& open) {
  orders_.push_back(page_answer(
      client, "document",
      document_json(file, open.document, open.on_disk.hash, open.editor != client, open.is_dirty(),
                    open.editor == client ? open.offered() : nullptr)));
  if (open.state != FileState::same)
    orders_.push_back(
        page_answer(client, "disk", {{"file", file}, {"state", name_of(open.state)}}));
}

void OpenDocuments::tell_readers(const OpenDocument& open, std::string_view kind,
                                 const Json& fields, ClientId but) {
  for (const ClientId client : open.readers) {
    if (client != but) orders_.push_back(page_answer(client, kind, fields));
  }
}

OpenDocuments::OpenDocument* OpenDocuments::find(ClientId client, std::string_view request,
                                                 const std::string& file) {
  const auto at = open_.find(file);
  if (at != open_.end()) return &at->second;
  refuse(client, request, file, "the file is not open");
  return nullptr;
}

void OpenDocuments::close(ClientId client, const page::Close& close) {
  const auto at = open_.find(close.file);
  if (at == open_.end()) return;
  const ClientId editor = at->second.editor;
  if (!close.discard || (editor != client && editor != 0)) return forget_reader(close.file, client);
  Readers others = std::move(at->second.readers);
  others.erase(client);
  for (const auto& [waiting, save] : at->second.saves_waiting)
    refuse(waiting, "save", close.file, "the text was discarded");
  orders_.push_back(FileTask(DropDrafts{close.file, std::move(at->second.recovered)}));
  open_.erase(at);
  ++revision_;
  for (const ClientId other : others) open(other, close.file);
}

void OpenDocuments::leave(ClientId client) {
  std::vector<std::string> files;
  for (const auto& [file, open] : open_) files.push_back(file);
  for (const std::string& file : files) forget_reader(file, client);
  for (auto& [file, clients] : opening_) clients.erase(client);
}

void OpenDocuments::forget_reader(const std::string& file, ClientId client) {
  const auto at = open_.find(file);
  if (at == open_.end()) return;
  OpenDocument& open = at->second;
  open.readers.erase(client);
  if (open.editor == client) open.editor = 0;
  close_unread(file);
}

void OpenDocuments::close_unread(const std::string& file) {
  const auto at = open_.find(file);
  if (at == open_.end()) return;
  const OpenDocument& open = at->second;
  // What nobody saved stays open, for whoever comes back.
  if (!open.readers.empty() || open.is_dirty() || open.is_saving) return;
  open_.erase(at);
  ++revision_;
}

void OpenDocuments::take_over(ClientId client, const std::string& file) {
  OpenDocument* const open = find(client, "take_over", file);
  if (!open) return;
  if (!may_edit_(client)) return refuse(client, "take_over", file, kReadOnly);
  const ClientId before = std::exchange(open->editor, client);
  open->readers.insert(client);
  if (before != 0 && before != client) send_document(before, file, *open);
  send_document(client, file, *open);
}

void OpenDocuments::edit(ClientId client, const page::Edit& edit, Time now) {
  OpenDocument* const open = find(client, "edit", edit.file);
  if (!open) return;
  if (!may_edit_(client)) return refuse(client, "edit", edit.file, kReadOnly);
  if (open->editor != client)
    return refuse(client, "edit", edit.file, "another page edits the file; take it over first");
  // A page that edits another version than this one is sent what there is.
  if (edit.base != open->document.version()) return send_document(client, edit.file, *open);
  if (const auto why = open->document.apply(edit.changes)) {
    refuse(client, "edit", edit.file, *why);
    return send_document(client, edit.file, *open);
  }
  ++revision_;
  // It may have become what the other program wrote.
  if (open->state == FileState::changed) read_again(edit.file, *open, open->on_disk);
  if (!open->undrafted_since) open->undrafted_since = now;
  const uint64_t version = open->document.version();
  orders_.push_back(page_answer(client, "edited", {{"file", edit.file}, {"version", version}}));
  Json changes = Json::array();
  for (const TextChange& change : edit.changes)
    changes.push_back({change.from, change.to, change.text});
  tell_readers(*open, "change",
               {{"file", edit.file}, {"base", edit.base}, {"changes", changes}, {"why", "editor"}},
               client);
}

void OpenDocuments::reload(ClientId client, const std::string& file) {
  OpenDocument* const open = find(client, "reload", file);
  if (!open) return;
  // The page is sent the text of the disk, which it takes up as an edit that can be undone. Until
  // then a save goes by what is known of the disk, as before.
  read_again(file, *open, {});
}

void OpenDocuments::look_at(OpenDocument& open, const LookAtFile& task) {
  open.is_looked_at = true;
  orders_.push_back(FileTask(task));
}

void OpenDocuments::read_again(const std::string& file, OpenDocument& open,
                               const FileVersion& known) {
  if (open.is_looked_at) {
    // What is to be read whatever is known is not replaced by what is read only if it differs.
    const bool is_whatever = open.read_next && open.read_next->hash == Digest{};
    if (!is_whatever) open.read_next = known;
  } else {
    look_at(open, LookAtFile{file, known, true});
  }
}

void OpenDocuments::note_looked(const std::string& file, OpenDocument& open) {
  open.is_looked_at = false;
  if (const auto known = std::exchange(open.read_next, std::nullopt))
    look_at(open, LookAtFile{file, *known, true});
}

void OpenDocuments::take(const FileLookedAt& changed) {
  const auto at = open_.find(changed.file);
  if (at == open_.end()) return;
  OpenDocument& open = at->second;
  note_looked(changed.file, open);
  open.failure.clear();
  // It was compared with what is not known any more: with what there was before a save, say.
  const bool was_known = changed.known.hash != Digest{};
  if (was_known && changed.known.hash != open.on_disk.hash) return;
  if (changed.state == FileState::same) {
    open.on_disk = changed.version;
    return;
  }
  Json fields{{"file", changed.file}, {"state", name_of(changed.state)}};
  if (changed.content) {
    const Document disk(changed.content->bytes, changed.content->is_whole);
    if (disk.text() == open.document.text()) {
      open.document.adopt(changed.content->bytes);
      open.on_disk = changed.version;
      open.state = FileState::same;
      if (open.is_dirty()) {
        open.clean_version = open.document.version();
        tell_readers(open, "saved",
                     {{"file", changed.file},
                      {"version", open.clean_version},
                      {"hash", changed.version.hash.hex()}});
      }
      return;
    }
    fields["text"] = disk.text();
    fields["hash"] = changed.version.hash.hex();
  }
  const bool is_told = open.state == changed.state && open.on_disk.hash == changed.version.hash;
  if (was_known && is_told) return;
  open.state = changed.state;
  // Whoever saves from now on has seen it.
  if (changed.content) open.on_disk = changed.version;
  // Where nobody edits the text, no page takes up what the disk has.
  if (changed.content && open.editor == 0 && follow_disk(changed.file, open, *changed.content))
    return;
  open.clean_version = 0;
  tell_readers(open, "disk", fields);
}

bool OpenDocuments::follow_disk(const std::string& file, OpenDocument& open,
                                const FileContent& content) {
  const Document disk(content.bytes, content.is_whole);
  const std::string text = open.document.text();
  const TextChange whole{0, open.document.offset_of_text_byte(text.size()), disk.text()};
  if (open.is_dirty() || open.document.apply(std::span(&whole, 1))) return false;
  open.document.adopt(content.bytes);
  open.clean_version = open.document.version();
  open.state = FileState::same;
  ++revision_;
  for (const ClientId client : open.readers) send_document(client, file, open);
  return true;
}

void OpenDocuments::take(const FileFailed& failed) {
  if (failed.request == "open") {
    const auto waiting = opening_.extract(failed.file);
    if (waiting.empty()) return;
    for (const auto& [client, known_text] : waiting.mapped())
      refuse(client, "open", failed.file, failed.why);
  } else if (failed.client != 0) {
    orders_.push_back(refusal(failed.client, failed.request, failed.file, failed.why, failed.number,
                              failed.existing));
    if (failed.request == "save") note_save_ended(failed.file);
  } else if (const auto at = open_.find(failed.file); at != open_.end()) {
    OpenDocument& open = at->second;
    if (failed.request == "look") note_looked(failed.file, open);
    const bool is_draft = failed.request == "draft";
    if (is_draft) open.has_draft_failed = true;
    std::string& told = is_draft ? open.draft_failure : open.failure;
    if (std::exchange(told, failed.why) == failed.why) return;
    for (const ClientId client : open.readers)
      refuse(client, failed.request, failed.file, failed.why);
  }
}

void OpenDocuments::tick(Time now) {
  for (auto& [file, open] : open_) {
    if (std::exchange(open.has_draft_failed, false) && open.is_dirty() && !open.undrafted_since)
      open.undrafted_since = now;
    if (open.undrafted_since && now >= *open.undrafted_since + kDraftAfter) keep_draft(file, open);
  }
  if (now < next_look_) return;
  next_look_ = now + kBetweenLooks;
  for (auto& [file, open] : open_) {
    if (!open.readers.empty() && !open.is_looked_at)
      look_at(open, LookAtFile{file, open.on_disk, false});
  }
}

Time OpenDocuments::deadline() const {
  Time due = open_.empty() ? Time::max() : next_look_;
  for (const auto& [file, open] : open_) {
    if (open.undrafted_since) due = std::min(due, *open.undrafted_since + kDraftAfter);
  }
  return due;
}

OpenTexts OpenDocuments::texts() const {
  OpenTexts texts;
  for (const auto& [file, open] : open_) texts.emplace(file, open.document);
  return texts;
}

const Document* OpenDocuments::document(const std::string& file) const {
  const auto at = open_.find(file);
  return at == open_.end() ? nullptr : &at->second.document;
}

void OpenDocuments::for_each(
    const std::function<void(const std::string& file, const Document& document,
                             const Readers& readers)>& visit) const {
  for (const auto& [file, open] : open_) visit(file, open.document, open.readers);
}

}  // namespace tessera
