#include "proto/wire/blob_transfer.h"

#include <fmt/format.h>

#include <algorithm>
#include <cstring>

namespace tessera {
namespace {

constexpr size_t kWindow = 8;
constexpr Time kAskAgainAfter = std::chrono::seconds(2);
constexpr int kMaxCorrupt = 3;

size_t chunk_count(uint64_t size) {
  return static_cast<size_t>((size + kBlobChunkBytes - 1) / kBlobChunkBytes);
}

size_t chunk_size(uint64_t size, size_t chunk) {
  return static_cast<size_t>(
      std::min<uint64_t>(kBlobChunkBytes, size - uint64_t{chunk} * kBlobChunkBytes));
}

}  // namespace

v1::Envelope answer_blob_request(const v1::BlobRequest& request, const BlobData& blob) {
  v1::Envelope answer;
  if (!blob || request.offset() > blob->size()) {
    answer.mutable_blob_missing()->set_digest(request.digest());
    return answer;
  }
  v1::BlobChunk& chunk = *answer.mutable_blob_chunk();
  chunk.set_digest(request.digest());
  chunk.set_offset(request.offset());
  const auto length =
      std::min<uint64_t>({request.length(), kBlobChunkBytes, blob->size() - request.offset()});
  chunk.set_data(blob->data() + request.offset(), length);
  return answer;
}

void BlobFetch::want(const Digest& digest, uint64_t size) {
  if (size > kMaxBlobBytes) {
    failure_ =
        fmt::format("blob {} of {} bytes; expected at most {}", digest.hex(), size, kMaxBlobBytes);
    return;
  }
  const auto same = [&](const Part& part) { return part.digest == digest; };
  if (std::none_of(parts_.begin(), parts_.end(), same)) {
    parts_.push_back({.digest = digest, .size = size, .data = {}, .asked = {}, .received = {}});
  }
}

std::vector<v1::BlobRequest> BlobFetch::requests(Time now) {
  std::vector<v1::BlobRequest> result;
  if (!failure_.empty()) return result;
  for (Part& part : parts_) {
    for (size_t chunk = 0; chunk < part.asked.size(); ++chunk) {
      if (!part.received[chunk] && now - part.asked[chunk] >= kAskAgainAfter) {
        --in_flight_;
        ask(part, chunk, now, result);
      }
    }
    // An empty blob is asked for too: its one, empty chunk completes it.
    const size_t count = std::max<size_t>(1, chunk_count(part.size));
    while (in_flight_ < kWindow && part.asked.size() < count) {
      part.asked.push_back(now);
      part.received.push_back(false);
      ask(part, part.asked.size() - 1, now, result);
    }
    if (in_flight_ >= kWindow) break;
  }
  return result;
}

void BlobFetch::ask(Part& part, size_t chunk, Time now, std::vector<v1::BlobRequest>& requests) {
  part.asked[chunk] = now;
  ++in_flight_;
  v1::BlobRequest& request = requests.emplace_back();
  request.set_digest(part.digest.hex());
  request.set_offset(uint64_t{chunk} * kBlobChunkBytes);
  request.set_length(static_cast<uint32_t>(chunk_size(part.size, chunk)));
}

BlobFetch::Part* BlobFetch::find(const std::string& hex) {
  const auto digest = Digest::parse(hex);
  if (!digest) return nullptr;
  const auto it = std::find_if(parts_.begin(), parts_.end(),
                               [&](const Part& part) { return part.digest == *digest; });
  return it == parts_.end() ? nullptr : &*it;
}

void BlobFetch::on_chunk(const v1::BlobChunk& chunk, BlobStore& store) {
  Part* part = find(chunk.digest());
  if (!part || chunk.offset() % kBlobChunkBytes != 0) return;
  const auto index = static_cast<size_t>(chunk.offset() / kBlobChunkBytes);
  if (index >= part->asked.size() || part->received[index] ||
      chunk.data().size() != chunk_size(part->size, index)) {
    return;
  }
  const size_t end = static_cast<size_t>(chunk.offset()) + chunk.data().size();
  if (part->data.size() < end) part->data.resize(end);
  std::memcpy(part->data.data() + chunk.offset(), chunk.data().data(), chunk.data().size());
  part->received[index] = true;
  --in_flight_;
  bytes_received_ += chunk.data().size();
  const bool whole =
      part->received.size() == std::max<size_t>(1, chunk_count(part->size)) &&
      std::find(part->received.begin(), part->received.end(), false) == part->received.end();
  if (whole) complete(*part, store);
}

void BlobFetch::complete(Part& part, BlobStore& store) {
  if (Digest::of(part.data) != part.digest) {
    if (++part.corrupt >= kMaxCorrupt) {
      failure_ = fmt::format("blob {} came damaged {} times", part.digest.hex(), part.corrupt);
    }
    part.data = {};
    part.asked.clear();
    part.received.clear();
    return;
  }
  store.put(part.digest, std::make_shared<const std::vector<std::byte>>(std::move(part.data)));
  std::erase_if(parts_, [digest = part.digest](const Part& p) { return p.digest == digest; });
}

void BlobFetch::on_missing(const v1::BlobMissing& missing) {
  if (find(missing.digest())) {
    failure_ =
        fmt::format("blob {} is not to be had; expected every blob of the scene", missing.digest());
  }
}

std::optional<Time> BlobFetch::next_deadline() const {
  std::optional<Time> next;
  for (const Part& part : parts_) {
    for (size_t chunk = 0; chunk < part.asked.size(); ++chunk) {
      if (part.received[chunk]) continue;
      const Time due = part.asked[chunk] + kAskAgainAfter;
      if (!next || due < *next) next = due;
    }
  }
  return next;
}

}  // namespace tessera
