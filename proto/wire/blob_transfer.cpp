#include "proto/wire/blob_transfer.h"

#include <fmt/format.h>

#include <algorithm>
#include <cstring>
#include <span>
#include <utility>

#include "base/huge_pages.h"

namespace tessera {
namespace {

constexpr size_t kWindow = 8;
constexpr Time kAskAgainAfter = std::chrono::seconds(2),
               kAskAgainAtLatest = std::chrono::minutes(1);
constexpr int kMaxCorrupt = 3;
/// Of address space; what no chunk has come for takes no memory.
constexpr uint64_t kMostReserved = uint64_t{1} << 30;

/// An empty blob has one chunk too, which completes it.
size_t chunk_count(uint64_t size) {
  return std::max<size_t>(1, static_cast<size_t>((size + kBlobChunkBytes - 1) / kBlobChunkBytes));
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
    answer.mutable_blob_missing()->set_submission(request.submission());
    return answer;
  }
  v1::BlobChunk& chunk = *answer.mutable_blob_chunk();
  chunk.set_digest(request.digest());
  chunk.set_offset(request.offset());
  chunk.set_submission(request.submission());
  const auto length =
      std::min<uint64_t>({request.length(), kBlobChunkBytes, blob->size() - request.offset()});
  chunk.set_data(blob->data() + request.offset(), length);
  return answer;
}

BlobFetch::BlobFetch(uint64_t submission, bool by_place)
    : submission_(submission), by_place_(by_place), ask_again_after_(kAskAgainAfter) {}

BlobFetch::Part* BlobFetch::add(const Digest& digest, uint64_t size) {
  if (size > kMaxBlobBytes) {
    failure_ =
        fmt::format("blob {} of {} bytes; expected at most {}", digest.hex(), size, kMaxBlobBytes);
    return nullptr;
  }
  const auto [part, fresh] = parts_.try_emplace(digest);
  if (!fresh) return nullptr;
  part->second.size = size;
  part->second.by_place = by_place_;
  return &part->second;
}

void BlobFetch::want(const Digest& digest, uint64_t size) {
  if (add(digest, size)) unasked_.push_back(digest);
}

void BlobFetch::hold(const Digest& digest, uint64_t size) {
  if (Part* const part = add(digest, size)) part->held = true;
}

void BlobFetch::on_loaded(const Digest& digest, BlobData blob, BlobStore& store) {
  const auto it = parts_.find(digest);
  if (it == parts_.end() || !it->second.held) return;
  if (blob) {
    store.put(digest, std::move(blob));
    parts_.erase(it);
    return;
  }
  it->second.held = false;
  unasked_.push_back(digest);
}

std::optional<uint64_t> BlobFetch::on_place(const v1::BlobPlace& place) {
  const auto it = find(place.digest());
  if (it == parts_.end() || !it->second.by_place || in_flight_.erase({it->first, 0}) == 0) {
    return std::nullopt;
  }
  // One that is not there is not asked for again.
  Part& part = it->second;
  part.by_place = false;
  part.asked = 0;
  part.held = true;
  return part.size;
}

std::vector<v1::BlobRequest> BlobFetch::requests(Time now) {
  std::vector<v1::BlobRequest> result;
  if (!failure_.empty()) return result;
  if (answered_) {
    ask_again_after_ = std::clamp(2 * (now - *answered_), kAskAgainAfter, kAskAgainAtLatest);
    answered_.reset();
  }
  for (auto& [chunk, asked] : in_flight_) {
    if (now - asked.last < ask_again_after_) continue;
    asked.last = now;
    result.push_back(request(chunk.first, chunk.second));
  }
  while (in_flight_.size() < kWindow && !unasked_.empty()) {
    const Digest digest = unasked_.front();
    Part& part = parts_.at(digest);
    in_flight_.emplace(std::pair(digest, part.asked), Asked{now, now});
    result.push_back(request(digest, part.asked));
    if (++part.asked == chunk_count(part.size) || part.by_place) unasked_.pop_front();
  }
  return result;
}

v1::BlobRequest BlobFetch::request(const Digest& digest, size_t chunk) const {
  v1::BlobRequest request;
  request.set_digest(digest.hex());
  request.set_offset(uint64_t{chunk} * kBlobChunkBytes);
  request.set_length(static_cast<uint32_t>(chunk_size(parts_.at(digest).size, chunk)));
  request.set_submission(submission_);
  request.set_place(parts_.at(digest).by_place);
  return request;
}

BlobFetch::Parts::iterator BlobFetch::find(const std::string& hex) {
  const auto digest = Digest::parse(hex);
  return digest ? parts_.find(*digest) : parts_.end();
}

bool BlobFetch::on_chunk(const v1::BlobChunk& chunk, BlobStore& store) {
  const auto it = find(chunk.digest());
  if (it == parts_.end() || chunk.offset() % kBlobChunkBytes != 0) return false;
  const auto index = static_cast<size_t>(chunk.offset() / kBlobChunkBytes);
  const auto asked = in_flight_.find({it->first, index});
  if (asked == in_flight_.end()) return false;
  Part& part = it->second;
  // Such as where the blob is not as long as was said.
  if (chunk.data().size() != chunk_size(part.size, index)) {
    note_damage(it);
    return false;
  }
  answered_ = std::min(answered_.value_or(asked->second.first), asked->second.first);
  in_flight_.erase(asked);
  if (std::exchange(part.by_place, false) && part.asked < chunk_count(part.size)) {
    unasked_.push_front(it->first);
  }
  const size_t end = static_cast<size_t>(chunk.offset()) + chunk.data().size();
  // Room is taken before it is filled, but not for more than would be worth a lie about the size.
  if (part.data.empty()) {
    part.data.reserve(std::min(part.size, kMostReserved));
    prefer_huge_pages(part.data.data(), part.data.capacity());
  }
  const auto bytes = std::as_bytes(std::span(chunk.data()));
  if (part.data.size() == chunk.offset()) {
    part.data.insert(part.data.end(), bytes.begin(), bytes.end());
  } else {
    if (part.data.size() < end) part.data.resize(end);
    std::copy(bytes.begin(), bytes.end(),
              part.data.begin() + static_cast<ptrdiff_t>(chunk.offset()));
  }
  if (part.came.size() <= index) part.came.resize(index + 1);
  part.came[index] = true;
  digest_more(part);
  return ++part.received == chunk_count(part.size) && complete(it, store);
}

void BlobFetch::digest_more(Part& part) {
  while (part.digested < part.came.size() && part.came[part.digested]) {
    part.digest.add(std::span(part.data).subspan(part.digested * kBlobChunkBytes,
                                                 chunk_size(part.size, part.digested)));
    ++part.digested;
  }
}

uint64_t BlobFetch::digested_bytes() const {
  uint64_t sum = 0;
  for (const auto& [digest, part] : parts_) {
    sum += std::min<uint64_t>(uint64_t{part.digested} * kBlobChunkBytes, part.size);
  }
  return sum;
}

bool BlobFetch::complete(Parts::iterator it, BlobStore& store) {
  Part& part = it->second;
  if (part.digest.finish() != it->first) {
    part.data = {};
    part.came = {};
    part.digest = {};
    part.asked = part.received = part.digested = 0;
    unasked_.push_front(it->first);
    note_damage(it);
    return false;
  }
  store.put(it->first, make_blob(std::move(part.data)));
  parts_.erase(it);
  return true;
}

void BlobFetch::note_damage(Parts::iterator it) {
  if (++it->second.corrupt < kMaxCorrupt) return;
  failure_ = fmt::format("blob {} came damaged, or not {} bytes long, {} times", it->first.hex(),
                         it->second.size, it->second.corrupt);
}

void BlobFetch::on_missing(const v1::BlobMissing& missing) {
  if (find(missing.digest()) != parts_.end()) {
    failure_ =
        fmt::format("blob {} is not to be had; expected every blob of the scene", missing.digest());
  }
}

std::optional<Time> BlobFetch::next_deadline() const {
  std::optional<Time> next;
  for (const auto& [chunk, asked] : in_flight_) {
    if (!next || asked.last + ask_again_after_ < *next) next = asked.last + ask_again_after_;
  }
  return next;
}

}  // namespace tessera
