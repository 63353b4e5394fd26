#include "coordinator/tiles/worker_keys.h"

#include <cstring>

#include "base/digest.h"

namespace tessera {
namespace {

WorkerKeys::Voter voter_of_key(const std::string& key) {
  const Digest digest = Digest::of(key);
  WorkerKeys::Voter voter;
  std::memcpy(&voter, digest.bytes.data(), sizeof voter);
  return voter;
}

}  // namespace

void WorkerKeys::note(WorkerId worker, const std::string& key, const std::string& name) {
  if (key.empty()) return;
  const auto it = names_.try_emplace(key).first;
  if (!name.empty()) it->second = name;
  holders_.try_emplace(worker, Holder{&it->first, voter_of_key(key)});
}

WorkerId WorkerKeys::note_stored(const std::string& key) {
  const WorkerId worker = voter_of_key(key) | kReservedId;
  note(worker, key, "");
  return worker;
}

const std::string& WorkerKeys::key_of(WorkerId worker) const {
  static const std::string kNone;
  const auto it = holders_.find(worker);
  return it == holders_.end() ? kNone : *it->second.key;
}

std::string WorkerKeys::name_of(const std::string& key) const {
  const auto it = names_.find(key);
  constexpr size_t kDigits = 8;
  return it == names_.end() || it->second.empty() ? key.substr(0, kDigits) + "..." : it->second;
}

WorkerKeys::Voter WorkerKeys::voter_of(WorkerId worker) const {
  const auto it = holders_.find(worker);
  return by_key() && it != holders_.end() ? it->second.voter : worker;
}

}  // namespace tessera
