// What the studio does with files that pages send.

#include <utility>

#include "studio/page_answer.h"
#include "studio/pixel_frame.h"
#include "studio/studio_session.h"

namespace tessera {

void StudioSession::receive_binary(ClientId client, std::string_view frame, Time now) {
  const auto at = clients_.find(client);
  if (at == clients_.end()) return;
  Client& mine = at->second;
  if (mine.role == StudioRole::none)
    return shut_out(client, close_code::kNoToken, "expected hello");
  if (mine.messages.exceeds(kMostMessages, now))
    return shut_out(client, close_code::kPolicyViolation, "too many messages");
  const auto chunk = decode_file_chunk(frame);
  if (!chunk) return;  // of a kind that is not known
  if (!may_edit(client)) return;
  if (++mine.chunks_waiting > kMostChunksWaiting)
    return shut_out(client, close_code::kPolicyViolation, "too many chunks at once");
  orders_.push_back(
      FileTask(AppendUpload{client, chunk->number, std::string(chunk->bytes), chunk->is_last}));
}

void StudioSession::put(ClientId client, const page::Put& put) {
  if (facts_.is_read_only)
    return tell(FileFailed{client, "put", put.name, "the studio is read-only", put.number});
  ++clients_[client].chunks_waiting;
  orders_.push_back(FileTask(BeginUpload{client, put.number, put.name, put.size}));
}

void StudioSession::note_chunk_written(ClientId client) {
  const auto at = clients_.find(client);
  if (at != clients_.end()) --at->second.chunks_waiting;
}

void StudioSession::tell(const FileFailed& failed) {
  nlohmann::json fields{
      {"request", failed.request}, {"why", failed.why}, {"upload", *failed.upload}};
  if (!failed.file.empty()) fields["file"] = failed.file;
  orders_.push_back(page_answer(failed.client, "refused", std::move(fields)));
}

void StudioSession::tell(const UploadProgress& progress) {
  nlohmann::json fields{{"number", progress.number},
                        {"name", progress.state.name},
                        {"received", progress.state.received},
                        {"whole", progress.state.is_whole}};
  orders_.push_back(page_answer(progress.client, "put", std::move(fields)));
}

}  // namespace tessera
