#include "studio/studio_session.h"

#include <fmt/format.h>

#include <algorithm>
#include <charconv>
#include <utility>

#include "base/error.h"
#include "studio/export_order.h"
#include "studio/files/studio_settings.h"
#include "studio/new_scene.h"
#include "studio/page_answer.h"
#include "studio/page_message.h"

namespace tessera {
namespace {

using Json = nlohmann::json;

constexpr size_t kIdDigits = 32;

Json kept_json(const std::string& text) {
  Json kept = Json::parse(text, nullptr, false);
  return kept.is_discarded() ? Json::object() : kept;
}

}  // namespace

StudioSession::StudioSession(StudioFacts facts, RoleOf role_of)
    : facts_(std::move(facts)),
      role_of_(std::move(role_of)),
      requests_(orders_),
      documents_(orders_, [this](ClientId client) { return may_edit(client); }),
      sources_(orders_, requests_, documents_, facts_.is_read_only),
      views_(orders_, facts_.folder, facts_.samples_folder, facts_.deflate),
      picks_(orders_, facts_.deflate),
      renders_(orders_, facts_.folder, facts_.assets) {
  if (facts_.is_read_only) return;
  orders_.push_back(FileTask(RemoveUnfinished{}));
  orders_.push_back(FileTask(NoteOpened{}));
}

void StudioSession::connect(ClientId client, Time now) {
  const auto unknown = static_cast<size_t>(std::ranges::count_if(
      clients_, [](const auto& each) { return each.second.role == StudioRole::none; }));
  if (clients_.size() >= kMostClients || unknown >= kMostUnknown) {
    orders_.push_back(CloseClient{client, close_code::kTryLater, "too many pages"});
    return;
  }
  clients_[client].silence.heard(now);
}

void StudioSession::disconnect(ClientId client) {
  if (clients_.erase(client) == 0) return;
  orders_.push_back(FileTask(DropUploads{client}));
  requests_.leave(client);
  picks_.leave(client);
  views_.leave(client);
  sources_.leave(client);
  documents_.leave(client);
}

bool StudioSession::may_edit(ClientId client) const {
  const auto at = clients_.find(client);
  return !facts_.is_read_only && at != clients_.end() && at->second.role == StudioRole::editor;
}

bool StudioSession::Flow::exceeds(const FlowLimit& limit, Time now) {
  const Time each = Time(std::chrono::seconds(1)) / limit.per_second;
  const Time settled = std::max(settled_, now) + each;
  if (settled - now > limit.at_once * each) return true;
  settled_ = settled;
  return false;
}

void StudioSession::shut_out(ClientId client, uint16_t code, std::string_view why) {
  orders_.push_back(CloseClient{client, code, std::string(why)});
  disconnect(client);
}

void StudioSession::receive(ClientId client, std::string_view text, Time now) {
  const auto at = clients_.find(client);
  if (at == clients_.end()) return;
  if (at->second.messages.exceeds(kMostMessages, now))
    return shut_out(client, close_code::kPolicyViolation, "too many messages");
  if (at->second.role == StudioRole::none && text.size() > kMostHelloBytes)
    return shut_out(client, close_code::kNoToken, "expected hello");
  page::MessageName name{.kind = "message"};
  try {
    const auto message = page::parse_message(text, &name);
    if (at->second.role == StudioRole::none) {
      const auto* const hello = message ? std::get_if<page::Hello>(&*message) : nullptr;
      at->second.role = hello ? role_of_(hello->token) : StudioRole::none;
      if (at->second.role == StudioRole::none)
        return shut_out(client, close_code::kNoToken, "expected a token");
      if (welcomes_.exceeds(kMostWelcomes, now))
        return shut_out(client, close_code::kTryLater, "too many pages in a second");
      return welcome(client, *hello);
    }
    if (!message) return;
    if (may_say(client, *message)) return handle(client, *message, now);
    orders_.push_back(refusal(client, name.kind, "",
                              "the token is a viewer's; expected a submitter's", name.number));
  } catch (const Error& error) {
    if (at->second.role == StudioRole::none)
      return shut_out(client, close_code::kNoToken, "expected hello");
    orders_.push_back(refusal(client, name.kind, "", error.what(), name.number));
  }
}

std::string StudioSession::id_of(ClientId client) const {
  const std::string number = std::to_string(client);
  return fmt::format("{}.{}", number,
                     Digest::of(facts_.run + "." + number).hex().substr(0, kIdDigits));
}

bool StudioSession::is_of_this_run(const std::string& id) const {
  ClientId client = 0;
  const auto end = std::from_chars(id.data(), id.data() + id.size(), client).ptr;
  return end != id.data() && id == id_of(client);
}

void StudioSession::welcome(ClientId client, const page::Hello& hello) {
  Client& mine = clients_[client];
  // A page that was cut off is known by the id that it was given: what it edits is its own again.
  ClientId before = 0;
  for (const auto& [other, known] : clients_) {
    if (other != client && !hello.resume.empty() && known.id == hello.resume) before = other;
  }
  mine.id = is_of_this_run(hello.resume) ? hello.resume : id_of(client);
  Json fields{{"id", mine.id},
              {"program", facts_.version},
              {"folder", facts_.folder},
              {"read_only", !may_edit(client)},
              {"limits", limits_json()},
              {"choices", choices_json()},
              {"workers_nice", StudioSettings::kWorkersNice},
              {"settings", kept_json(facts_.settings)},
              {"workspace", kept_json(facts_.workspace)},
              {"workers", facts_.workers},
              {"worker_command", facts_.worker_command},
              {"samples", facts_.samples},
              {"templates", templates_json()}};
  // Where else its owner works is of no concern to who only sees.
  if (mine.role == StudioRole::editor)
    fields["recent"] = recent_json(facts_.recent_folders, facts_.folder);
  if (!facts_.file.empty()) fields["file"] = facts_.file;
  orders_.push_back(page_answer(client, "welcome", std::move(fields)));
  orders_.push_back(page_answer(client, "renders", renders_.list()));
  if (!farm_.is_null()) orders_.push_back(page_answer(client, "farm", farm_));
  documents_.resume(client, before, hello);
  if (before != 0) shut_out(before, close_code::kDone, "the page connected again");
}

bool StudioSession::may_say(ClientId client, const page::Message& message) const {
  return clients_.at(client).role == StudioRole::editor || page::is_for_viewers(message);
}

void StudioSession::handle(ClientId client, const page::Message& message, Time now) {
  struct Handler {
    StudioSession& session;
    ClientId client;
    Time now;

    void operator()(const page::Hello&) const {}
    void operator()(const page::List&) const {
      session.requests_.add({client, "list"}, FileTask(ListFiles{client}));
    }
    void operator()(const page::Open& open) const { session.documents_.open(client, open.file); }
    void operator()(const page::Close& close) const { session.documents_.close(client, close); }
    void operator()(const page::Reload& reload) const {
      session.documents_.reload(client, reload.file);
    }
    void operator()(const page::TakeOver& take) const {
      session.documents_.take_over(client, take.file);
    }
    void operator()(const page::Edit& edit) const { session.documents_.edit(client, edit, now); }
    void operator()(const page::Save& save) const { session.documents_.save(client, save); }
    void operator()(const page::Recover& recover) const {
      session.documents_.recover(client, recover);
    }
    void operator()(const page::View& view) const { session.views_.set(client, view, now); }
    void operator()(const page::PaneOrder& order) const {
      session.show_texts();
      session.views_.order(client, order);
    }
    void operator()(const page::Pin& pin) const {
      session.orders_.push_back(PinPicture{{client, pin.pane}, pin.what});
    }
    void operator()(const page::Compare& compare) const {
      session.requests_.add({client, "compare"},
                            ComparePictures{{client, compare.pane}, session.facts_.deflate});
    }
    void operator()(const page::Probe& probe) const {
      session.orders_.push_back(ProbePixel{{client, probe.pane}, probe.x, probe.y});
    }
    void operator()(const page::Pick& pick) const {
      session.picks_.pick(client, pick, session.views_);
    }
    void operator()(const page::Parts& parts) const {
      session.picks_.parts(client, parts, session.views_);
    }
    void operator()(const page::Centers& centers) const {
      if (auto reading = session.views_.reading_of(client, centers.file))
        session.requests_.add({client, "centers"}, TellCenters{client, std::move(reading)});
    }
    void operator()(const page::Source& source) const { session.sources_.ask(client, source); }
    void operator()(const page::Create& create) const { session.create(client, create); }
    void operator()(const page::Put& put) const { session.put(client, put); }
    void operator()(const page::Settings& settings) const {
      session.facts_.settings = settings.json;
      if (!session.facts_.is_read_only)
        session.orders_.push_back(FileTask(KeepSettings{settings.json}));
    }
    void operator()(const page::Workspace& workspace) const {
      session.facts_.workspace = workspace.json;
      if (!session.facts_.is_read_only)
        session.orders_.push_back(FileTask(KeepWorkspace{workspace.json}));
    }
    void operator()(const page::Render& render) const { session.render(client, render); }
    void operator()(const page::RenderOrder& order) const { session.renders_.order(client, order); }
    void operator()(const page::Export& wish) const { session.export_file(client, wish); }
  };
  std::visit(Handler{*this, client, now}, message);
}

void StudioSession::export_file(ClientId client, const page::Export& wish) {
  if (wish.command) {
    const std::string command = command_line(*wish.command, facts_.folder, facts_.assets);
    if (command.empty()) {
      orders_.push_back(refusal(client, "export", wish.command->file,
                                "no option stands for a camera that was moved; write it to the "
                                "source first",
                                wish.number));
    } else {
      orders_.push_back(
          page_answer(client, "exported", {{"number", wish.number}, {"command", command}}));
    }
    return;
  }
  auto order = export_order(client, wish, views_, renders_);
  if (const auto* const why = std::get_if<std::string>(&order)) {
    orders_.push_back(refusal(client, "export", wish.file, *why, wish.number));
  } else if (auto* const view = std::get_if<ExportView>(&order)) {
    orders_.push_back(std::move(*view));
  } else if (auto* const unfinished = std::get_if<ExportUnfinished>(&order)) {
    orders_.push_back(std::move(*unfinished));
  } else {
    orders_.push_back(std::move(std::get<ExportFile>(order)));
  }
}

void StudioSession::create(ClientId client, const page::Create& create) {
  if (facts_.is_read_only)
    return orders_.push_back(refusal(client, "create", "", "the studio is read-only"));
  if (!create.sample.empty()) return orders_.push_back(FileTask(CopySample{client, create.sample}));
  CreateFiles task{client, {}};
  for (TemplateFile& file : create.model.empty() ? scene_of_template(create.from_template)
                                                 : scene_of_model(create.model)) {
    task.files.emplace_back(std::move(file.name), std::move(file.text));
  }
  if (task.files.empty()) {
    return orders_.push_back(
        refusal(client, "create", create.from_template, "expected a template: empty, lux or crt"));
  }
  orders_.push_back(FileTask(std::move(task)));
}

void StudioSession::render(ClientId client, const page::Render& wish) {
  if (!renders_.accepts(client, wish)) return;
  if (wish.outputs.empty()) return renders_.add(client, wish, documents_.texts());
  if (facts_.is_read_only) {
    return orders_.push_back(refusal(client, "render", wish.file,
                                     "the studio is read-only; expected no files to write",
                                     wish.number));
  }
  orders_.push_back(FileTask(CheckOutputs{client, wish, documents_.texts()}));
}

void StudioSession::take(const FileResult& result) {
  if (const auto* const listed = std::get_if<FilesListed>(&result)) {
    requests_.take({{listed->client, "list"}});
    orders_.push_back(page_answer(listed->client, "files", files_json(listed->list)));
  } else if (const auto* const opened = std::get_if<FileOpened>(&result)) {
    documents_.take(*opened);
  } else if (const auto* const saved = std::get_if<FileSaved>(&result)) {
    documents_.take(*saved);
    show_texts();
    if (!documents_.take_saved().empty()) views_.note_saved();
  } else if (const auto* const created = std::get_if<FilesCreated>(&result)) {
    orders_.push_back(page_answer(created->client, "created", {{"file", created->file}}));
  } else if (const auto* const progress = std::get_if<UploadProgress>(&result)) {
    note_chunk_written(progress->client);
    tell(*progress);
  } else if (const auto* const kept = std::get_if<DraftKept>(&result)) {
    documents_.take(*kept);
  } else if (const auto* const changed = std::get_if<FileLookedAt>(&result)) {
    documents_.take(*changed);
  } else if (const auto* const checked = std::get_if<CheckOutputs>(&result)) {
    renders_.add(checked->client, checked->wish, checked->texts);
  } else {
    const auto& failed = std::get<FileFailed>(result);
    if (failed.request == "list") requests_.take({{failed.client, "list"}});
    if (!failed.upload) return documents_.take(failed);
    note_chunk_written(failed.client);
    tell(failed);
  }
}

void StudioSession::take(std::shared_ptr<const SceneReading> reading, Time now) {
  if (reading->job != 0) return renders_.take(std::move(reading));
  views_.take(std::move(reading), now);
}

void StudioSession::take(const PassEnd& end) {
  views_.take(end);
  picks_.take(end);
}

void StudioSession::take(uint32_t serial, const JobProgress& progress) {
  views_.take(serial, progress);
}

std::vector<ClientId> StudioSession::pages() const {
  std::vector<ClientId> pages;
  for (const auto& [client, known] : clients_) {
    if (known.role != StudioRole::none) pages.push_back(client);
  }
  return pages;
}

void StudioSession::show_texts() {
  if (documents_.revision() == shown_revision_) return;
  shown_revision_ = documents_.revision();
  views_.set_texts(shown_revision_, documents_.texts());
}

void StudioSession::tell_all(std::string_view kind, const Json& fields) {
  for (const ClientId client : pages()) orders_.push_back(page_answer(client, kind, fields));
}

void StudioSession::set_farm(nlohmann::json farm) {
  farm_ = std::move(farm);
  tell_all("farm", farm_);
}

StudioOrders StudioSession::tick(Time now) {
  Time greeting = Time::max();
  std::vector<ClientId> silent;
  for (auto& [client, known] : clients_) {
    if (known.role != StudioRole::none) continue;
    known.silence.listen(deadline_, now);
    if (known.silence.length(now) >= kHelloWithin) silent.push_back(client);
    greeting = std::min(greeting, known.silence.reaches(kHelloWithin));
  }
  for (const ClientId client : silent) shut_out(client, close_code::kNoToken, "no hello in time");
  show_texts();
  sources_.tick();
  documents_.tick(now);
  views_.tick(now);
  if (renders_.tick(now)) tell_all("renders", renders_.list());
  deadline_ = std::min({greeting, documents_.deadline(), views_.deadline(), renders_.deadline()});
  return std::exchange(orders_, {});
}

Time StudioSession::deadline() const { return deadline_; }

StudioOrders StudioSession::take_file_tasks() {
  StudioOrders orders = std::exchange(orders_, {});
  std::erase_if(orders,
                [](const StudioOrder& order) { return !std::holds_alternative<FileTask>(order); });
  return orders;
}

}  // namespace tessera
