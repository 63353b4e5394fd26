#include "studio/source_edits.h"

#include <fmt/format.h>

#include "studio/page_answer.h"

namespace tessera {

void SourceEdits::ask(ClientId client, const page::Source& request) {
  const auto refused = [&](std::string_view why) {
    nlohmann::json fields{
        {"request", page::name_of(request.what)}, {"file", request.file}, {"why", why}};
    if (request.number != 0) fields["number"] = request.number;
    return page_answer(client, "refused", std::move(fields));
  };
  const auto refuse = [&](std::string_view why) { orders_.push_back(refused(why)); };
  const Document* const document = documents_.document(request.file);
  if (!document) return refuse("the file is not open");
  if (request.changes_text()) {
    if (is_read_only_) return refuse("the studio is read-only");
    if (!document->is_editable()) return refuse(document->why_not_editable());
  }
  if (request.base != document->version()) {
    // The page asks for fields again once it has the outline of the text that there is; a question
    // with a number waits for its answer.
    if (!request.changes_text() && request.number == 0) return;
    return refuse(fmt::format("version {} of the text; expected version {}", request.base,
                              document->version()));
  }
  SourceOrder order{client, request, *document};
  // A change is never left out, and a page waits for its answer before it asks for the next one.
  if (request.changes_text()) return orders_.push_back(std::move(order));
  std::optional<SendText> superseded;
  if (request.number != 0) superseded = refused("a newer question took its place");
  requests_.add({client, page::name_of(request.what)}, std::move(order), std::move(superseded));
}

void SourceEdits::take(std::shared_ptr<const FileOutline> outline) {
  const auto at = outlined_.find(outline->file);
  // One of a document that was closed meanwhile.
  if (at == outlined_.end() || at->second.ticket != outline->ticket) return;
  at->second.is_under_way = false;
  at->second.last = std::move(outline);
}

void SourceEdits::leave(ClientId client) {
  for (auto& [file, outlined] : outlined_) outlined.told.erase(client);
}

void SourceEdits::tell(Outlined& outlined, const OpenDocuments::Readers& readers) {
  if (!outlined.last || outlined.last->message.empty()) return;
  std::erase_if(outlined.told, [&](const auto& told) { return !readers.contains(told.first); });
  for (const ClientId client : readers) {
    uint64_t& told = outlined.told[client];
    if (told == outlined.last->ticket) continue;
    told = outlined.last->ticket;
    orders_.push_back(SendText{client, outlined.last->message});
  }
}

void SourceEdits::tick() {
  std::erase_if(outlined_, [&](const auto& known) { return !documents_.document(known.first); });
  documents_.for_each([&](const std::string& file, const Document& document,
                          const OpenDocuments::Readers& readers) {
    Outlined& outlined = outlined_[file];
    if (!outlined.is_under_way && outlined.ordered != document.version()) {
      outlined.is_under_way = true;
      outlined.ordered = document.version();
      outlined.ticket = ++last_ticket_;
      orders_.push_back(OutlineOrder{file, outlined.ticket, document});
    }
    tell(outlined, readers);
  });
}

}  // namespace tessera
