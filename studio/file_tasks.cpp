#include "studio/file_tasks.h"

#include <fmt/format.h>
#include <spdlog/spdlog.h>

#include <chrono>
#include <exception>
#include <filesystem>
#include <nlohmann/json.hpp>
#include <utility>

#include "front/output_settings.h"
#include "front/render_frame.h"
#include "front/render_options.h"
#include "image/image_file.h"
#include "studio/full_frame.h"
#include "studio/render_orders.h"
#include "studio/wall_clock.h"

namespace tessera {
namespace {

namespace fs = std::filesystem;

/// What the picture, or each of its frames, would be written to: for each output its files.
std::vector<std::vector<std::string>> output_files(const page::Render& wish) {
  std::vector<std::string> names = wish.outputs;
  if (wish.statistics && !names.empty()) names.push_back(statistics_name(names.front()));
  std::vector<std::vector<std::string>> files;
  for (const std::string& name : names) {
    files.emplace_back();
    if (wish.frames && !holds_frames(name)) {
      for (int frame = wish.frames->first; frame <= wish.frames->last; ++frame)
        files.back().push_back(frame_path(name, frame).generic_string());
    } else {
      files.back().push_back(name);
    }
  }
  return files;
}

class Doer {
 public:
  explicit Doer(const FilePlaces& places) : places_(places) {}

  std::optional<FileResult> operator()(const ListFiles& task) const {
    return FilesListed{task.client, places_.folder.list()};
  }
  std::optional<FileResult> operator()(const OpenFile& task) const {
    FileContent content = places_.folder.read(task.file, Document::kMostBytes);
    FileOpened opened{.client = task.client,
                      .file = task.file,
                      .document = Document(content.bytes, content.is_whole),
                      .version = content.version};
    if (places_.drafts) opened.drafts = places_.drafts->find(folder(), task.file);
    return opened;
  }
  std::optional<FileResult> operator()(const SaveFile& task) const {
    const std::string bytes = task.document.bytes();
    FileSaved saved{.client = task.client,
                    .file = task.file,
                    .as = task.as,
                    .document = task.document,
                    .result = {}};
    if (task.as.empty() && !task.is_new) {
      saved.result = places_.folder.save(task.file, bytes, task.expected);
    } else {
      const std::string& name = task.as.empty() ? task.file : task.as;
      saved.result = {FileState::same, places_.folder.create(name, bytes)};
    }
    // A text that went elsewhere still is not saved where it is from.
    if (saved.result.state == FileState::same && task.as.empty())
      drop_drafts(task.file, task.drafts);
    return saved;
  }
  std::optional<FileResult> operator()(const LookAtFile& task) const {
    FileLookedAt changed{
        .file = task.file, .known = task.known, .version = task.known, .content = {}};
    changed.state = places_.folder.state(task.file, changed.version);
    if (changed.state == FileState::same && task.always) changed.state = FileState::changed;
    if (changed.state == FileState::changed) {
      changed.content = places_.folder.read(task.file, Document::kMostBytes);
      changed.version = changed.content->version;
    }
    return changed;
  }
  std::optional<FileResult> operator()(const KeepDraft& task) const {
    if (places_.drafts)
      places_.drafts->put(
          {folder(), task.file, task.base, milliseconds_since_1970(), task.document.text()});
    return DraftKept{task.file};
  }
  std::optional<FileResult> operator()(const DropDrafts& task) const {
    drop_drafts(task.file, task.programs);
    return std::nullopt;
  }
  std::optional<FileResult> operator()(const DropOffered& task) const {
    if (places_.drafts) places_.drafts->drop(folder(), task.file, {task.program});
    return std::nullopt;
  }
  std::optional<FileResult> operator()(const CreateFiles& task) const {
    return create(task.client, task.files);
  }
  std::optional<FileResult> operator()(const CopySample& task) const {
    std::vector<std::pair<std::string, std::string>> files;
    for (TemplateFile& file : places_.samples.files_of(task.sample)) {
      // The scene alone is another one: what it names keeps its name.
      if (files.empty()) file.name = "untitled" + fs::path(file.name).extension().string();
      files.emplace_back(std::move(file.name), std::move(file.text));
    }
    return create(task.client, files);
  }
  std::optional<FileResult> operator()(const BeginUpload& task) const {
    places_.uploads.begin(task.client, task.number, task.name, task.size);
    return UploadProgress{task.client, task.number, {task.name, 0, false}};
  }
  std::optional<FileResult> operator()(const AppendUpload& task) const {
    return UploadProgress{
        task.client, task.number,
        places_.uploads.append(task.client, task.number, task.bytes, task.is_last)};
  }
  std::optional<FileResult> operator()(const DropUploads& task) const {
    places_.uploads.drop(task.client);
    return std::nullopt;
  }
  std::optional<FileResult> operator()(const RemoveUnfinished&) const {
    places_.folder.remove_unfinished();
    return std::nullopt;
  }
  std::optional<FileResult> operator()(const KeepSettings& task) const {
    places_.settings.keep(nlohmann::json::parse(task.json));
    return std::nullopt;
  }
  std::optional<FileResult> operator()(const KeepWorkspace& task) const {
    places_.settings.keep_of_folder(folder(), nlohmann::json::parse(task.json));
    return std::nullopt;
  }
  std::optional<FileResult> operator()(const NoteOpened&) const {
    places_.settings.note_opened(folder());
    return std::nullopt;
  }
  std::optional<FileResult> operator()(const CheckOutputs& task) const {
    const page::Render& wish = task.wish;
    ExistingFiles existing;
    for (const std::vector<std::string>& files : output_files(wish)) {
      places_.folder.check_writable(files.front());
      for (const std::string& file : files) {
        if (is_there(file)) existing.add(file);
      }
    }
    if (existing.count > 0 && !wish.force) {
      return FileFailed{.client = task.client,
                        .request = "render",
                        .file = wish.file,
                        .why = existing.why(),
                        .number = wish.number,
                        .existing = existing};
    }
    const OutputOptions asked = full_options(wish, folder() + "/" + wish.file).output;
    if (const auto names = output_settings(wish.file, {}, asked).color_management)
      check_color_management(*names);
    return task;
  }

 private:
  void drop_drafts(const std::string& file, const std::vector<std::string>& programs) const {
    if (!places_.drafts) return;
    places_.drafts->drop_own(folder(), file);
    places_.drafts->drop(folder(), file, programs);
  }
  FilesCreated create(ClientId client,
                      const std::vector<std::pair<std::string, std::string>>& files) const {
    for (size_t i = 1; i < files.size(); ++i) {
      const auto& [name, bytes] = files[i];
      if (is_there(name) &&
          places_.folder.read(name, bytes.size()).version.hash != Digest::of(bytes))
        throw render_error(
            fmt::format("'{}' is there already, and is another file than is needed", name));
    }
    FilesCreated created{client, places_.folder.free_name(files.front().first)};
    places_.folder.create(created.file, files.front().second);
    for (size_t i = 1; i < files.size(); ++i) {
      if (!is_there(files[i].first)) places_.folder.create(files[i].first, files[i].second);
    }
    return created;
  }
  bool is_there(const std::string& name) const {
    std::error_code failure;  // whoever reads or makes the file is told why not
    return fs::symlink_status(places_.folder.path() / name, failure).type() !=
           fs::file_type::not_found;
  }
  std::string folder() const { return places_.folder.path().string(); }

  const FilePlaces& places_;
};

/// What the task was, for whom to tell that it failed.
struct Describer {
  FileFailed operator()(const ListFiles& task) const { return {task.client, "list", "", ""}; }
  FileFailed operator()(const OpenFile& task) const { return {task.client, "open", task.file, ""}; }
  FileFailed operator()(const SaveFile& task) const { return {task.client, "save", task.file, ""}; }
  FileFailed operator()(const LookAtFile& task) const { return {0, "look", task.file, ""}; }
  FileFailed operator()(const KeepDraft& task) const { return {0, "draft", task.file, ""}; }
  FileFailed operator()(const DropDrafts& task) const { return {0, "drop_draft", task.file, ""}; }
  FileFailed operator()(const DropOffered& task) const { return {0, "drop_draft", task.file, ""}; }
  FileFailed operator()(const CreateFiles& task) const { return {task.client, "create", "", ""}; }
  FileFailed operator()(const CopySample& task) const {
    return {task.client, "create", task.sample, ""};
  }
  FileFailed operator()(const BeginUpload& task) const {
    return {.client = task.client,
            .request = "put",
            .file = task.name,
            .why = "",
            .upload = task.number};
  }
  FileFailed operator()(const AppendUpload& task) const {
    return {.client = task.client, .request = "put", .file = "", .why = "", .upload = task.number};
  }
  FileFailed operator()(const DropUploads&) const { return {0, "put", "", ""}; }
  FileFailed operator()(const RemoveUnfinished&) const { return {0, "put", "", ""}; }
  FileFailed operator()(const KeepSettings&) const { return {0, "settings", "", ""}; }
  FileFailed operator()(const KeepWorkspace&) const { return {0, "workspace", "", ""}; }
  FileFailed operator()(const NoteOpened&) const { return {0, "settings", "", ""}; }
  FileFailed operator()(const CheckOutputs& task) const {
    return {.client = task.client,
            .request = "render",
            .file = task.wish.file,
            .why = "",
            .number = task.wish.number};
  }
};

}  // namespace

std::unique_ptr<DraftStore> open_drafts() {
  const std::filesystem::path folder = DraftStore::default_folder();
  if (folder.empty()) return nullptr;
  try {
    return std::make_unique<DraftStore>(folder);
  } catch (const Error& error) {
    spdlog::warn("no drafts are kept: {}", error.what());
    return nullptr;
  }
}

std::optional<FileResult> do_file_task(const FileTask& task, const FilePlaces& places) {
  try {
    return std::visit(Doer(places), task);
  } catch (const std::exception& error) {
    // Also of the library, such as no memory: whoever asked waits for an answer.
    FileFailed failed = std::visit(Describer(), task);
    failed.why = error.what();
    return failed;
  }
}

}  // namespace tessera
