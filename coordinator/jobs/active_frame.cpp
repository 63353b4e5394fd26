#include "coordinator/jobs/active_frame.h"

#include <fmt/format.h>
#include <spdlog/spdlog.h>

#include <algorithm>
#include <bit>
#include <cmath>
#include <set>
#include <utility>

#include "coordinator/tiles/identity.h"
#include "coordinator/tiles/tile_store.h"
#include "job/job_messages.h"
#include "job/scene_motion.h"
#include "job/tile_grid.h"
#include "proto/wire/shared_memory.h"
#include "proto/wire/version.h"

namespace tessera {
namespace {

int tile_size_of(const JobSpec& spec, const std::vector<FinishedTile>& kept,
                 const JobRules& rules) {
  if (spec.tile_size > 0) return spec.tile_size;
  const int64_t side = kept.empty() ? 0 : int64_t{kept.front().kept.tile_size()};
  if (side >= 1 && side <= kMaxFrameSide) return static_cast<int>(side);
  return choose_tile_size(spec.crop, rules.expected_workers);
}

v1::JobStart start_of(const FrameName& name, const std::string& frame_id, const JobSpec& spec,
                      const PackedScene& scene) {
  v1::JobStart start;
  start.set_job(name.number);
  start.set_frame_id(frame_id);
  start.set_scene_digest(scene.digest.hex());
  start.set_scene_size(scene.bytes->size());
  // In the order of their names: the message is the same each time.
  std::vector<std::pair<Digest, uint64_t>> blobs;
  for (const auto& [digest, data] : spec.blobs.all()) blobs.emplace_back(digest, data->size());
  std::sort(blobs.begin(), blobs.end());
  for (const auto& [digest, size] : blobs) {
    start.add_blobs(digest.hex());
    start.add_blob_sizes(size);
  }
  *start.mutable_frame() = spec.frame;
  return start;
}

double seconds_of(const v1::TileBand& last) {
  return static_cast<double>(last.trace_microseconds()) * 1e-6;
}

}  // namespace

Digest tile_key(const Digest& scene, const v1::FrameSettings& frame, const PixelRect& crop) {
  return Digest::of(fmt::format("{} {} {},{},{},{} {}", scene.hex(), frame.SerializeAsString(),
                                crop.x0, crop.y0, crop.x1, crop.y1, kNumericsId));
}

ActiveFrame::KeptTiles ActiveFrame::find_kept(const JobSpec& spec, const PackedScene& scene,
                                              TileStore* store) {
  KeptTiles kept{tile_key(scene.digest, settled(spec.frame, scene.moves), spec.crop)};
  if (store) kept.tiles = store->find(kept.key);
  return kept;
}

ActiveFrame::ActiveFrame(const FrameName& name, JobSpec spec, const PackedScene& scene,
                         const TileKeeping& keeping, const JobRules& rules, WorkerKeys& keys,
                         Time now, SceneFailures failures)
    : ActiveFrame(name, spec, scene, find_kept(spec, scene, keeping.store.get()), keeping, rules,
                  keys, now, std::move(failures)) {}

ActiveFrame::ActiveFrame(const FrameName& name, JobSpec& spec, const PackedScene& scene,
                         const KeptTiles& kept, const TileKeeping& keeping, const JobRules& rules,
                         WorkerKeys& keys, Time now, SceneFailures failures)
    : id_(name.number),
      keeping_(keeping),
      keys_(keys),
      key_(kept.key),
      tile_size_(tile_size_of(spec, kept.tiles, rules)),
      samples_(spec.frame.samples_per_pixel()),
      assembler_(spec.crop, cut_tiles(spec.crop, tile_size_), AovSet(spec.frame.aovs())),
      scheduler_(assembler_.tiles(), tile_size_, rules, &keys),
      verifier_(assembler_.tiles().size(), rules.verify, rules.verify_key ^ id_, &keys),
      begun_(now),
      scene_failures_(std::move(failures)) {
  start_ = start_of(name, frame_id_of(name.job_id, id_, key_, tile_size_), spec, scene);
  blobs_ = std::move(spec.blobs);
  if (rules.shared_by_process != 0) share_large_blobs(blobs_);
  blobs_.put(scene.digest, scene.bytes);
  report_.tiles_total = assembler_.tiles().size();
  for (uint32_t tile = 0; tile < report_.tiles_total && rules.verify > 0; ++tile) {
    if (verifier_.selects(tile)) scheduler_.keep_whole(tile);
  }
  restore(kept.tiles);
}

void ActiveFrame::restore(const std::vector<FinishedTile>& kept) {
  const std::vector<uint32_t> restored =
      assembler_.restore(kept, [this](uint32_t tile, const FinishedTile& finished) {
        for (const v1::TileBand& band : finished.kept.bands()) {
          if (seconds_of(band) > 0) scheduler_.costs().learn(tile, seconds_of(band));
        }
        WorkerId from = kFromStore;
        for (const std::string& key : finished.kept.tracers()) {
          from = keys_.note_stored(key);
          verifier_.note_rows(tile, from);
        }
        if (finished.kept.tracers_size() == 1) return from;
        // Which rows are whose nobody knows any more.
        verifier_.note_rows(tile, kFromStore);
        return kFromStore;
      });
  scheduler_.restore(restored);
  for (const uint32_t tile : restored) {
    if (verifier_.selects(tile)) scheduler_.want_check(tile, verifier_.traced_by(tile));
  }
  report_.tiles_restored = restored.size();
}

void ActiveFrame::keep(uint32_t tile) {
  if (!keeping_.store) return;
  unkept_.push_back(tile);
  keep_rest();
}

void ActiveFrame::keep_rest() {
  try {
    for (; !undropped_.empty(); undropped_.pop_back()) {
      keeping_.store->drop(key_, assembler_.tiles()[undropped_.back()]);
    }
    while (!unkept_.empty()) {
      const uint32_t next = unkept_.back();
      FinishedTile finished{assembler_.tiles()[next], {}};
      for (v1::TileBand& band : assembler_.bands_of(next)) {
        *finished.kept.add_bands() = std::move(band);
      }
      const double seconds = scheduler_.costs().told(next).value_or(0);
      finished.kept.mutable_bands()->rbegin()->set_trace_microseconds(
          static_cast<uint64_t>(std::llround(seconds * 1e6)));
      finished.kept.set_tile_size(static_cast<uint32_t>(tile_size_));
      std::set<std::string> tracers;
      for (const WorkerId by : verifier_.traced_by(next)) tracers.insert(keys_.key_of(by));
      tracers.erase("");
      *finished.kept.mutable_tracers() = {tracers.begin(), tracers.end()};
      keeping_.store->keep(key_, finished);
      unkept_.pop_back();
    }
    store_trouble_.clear();
  } catch (const Error& error) {
    if (store_trouble_.empty() && !keeping_.must) {
      spdlog::warn("{}; it will be tried again", error.what());
    }
    store_trouble_ = error.what();
  }
}

void ActiveFrame::reopen(uint32_t tile) {
  assembler_.reopen(tile);
  verifier_.forget(tile);
  filled_.erase(tile);
  std::erase(unkept_, tile);
  if (!keeping_.store) return;
  undropped_.push_back(tile);
  keep_rest();
}

SchedulerEvents ActiveFrame::note_band(const v1::TileBand& band, WorkerId from, bool was_complete) {
  if (!was_complete) {
    verifier_.note_rows(band.tile(), from);
    note_cost(band);
    const bool part_done = !TilePiece::of(band.lease()).whole() &&
                           !assembler_.complete(band.tile()) && assembler_.has_piece(band.lease());
    return part_done ? scheduler_.complete_part(band.lease()) : SchedulerEvents{};
  }
  const PixelRect& rect = assembler_.tiles()[band.tile()];
  if (!verifier_.note_same_rows(band.tile(), from, rect, band.first_row(), band.rows())) return {};
  return scheduler_.check_done(band.tile(), band.lease());
}

ActiveFrame::Completion ActiveFrame::complete(uint32_t tile, LeaseId lease, WorkerId from,
                                              Time now) {
  Completion result{.events = scheduler_.complete(tile, lease, now)};
  if (const Mismatch* const found = verifier_.dispute(tile)) {
    const Mismatch about = *found;
    verifier_.settle(tile);
    const auto wrong = TileVerifier::judge(about, assembler_.row(tile, about.row));
    const bool are_two_voters = keys_.voter_of(about.first) != keys_.voter_of(about.second);
    if (wrong) {
      result.convictions = {{*wrong, about, from, keys_.by_key() && are_two_voters}};
    } else if (!are_two_voters) {
      // Processes of one key contradict each other, and another key both of them.
      result.convictions = {{about.first, about, from}, {about.second, about, from}};
      if (verifier_.wants_second(tile)) scheduler_.want_check(tile, verifier_.traced_by(tile));
    } else {
      result.undecided = about;
      reopen(tile);
      return result;
    }
  } else if (verifier_.wants_second(tile)) {
    scheduler_.want_check(tile, verifier_.traced_by(tile));
  }
  keep(tile);
  return result;
}

SchedulerEvents ActiveFrame::retrace(uint32_t tile) {
  reopen(tile);
  ++report_.retraced;
  return scheduler_.requeue(tile);
}

void ActiveFrame::note_cost(const v1::TileBand& band) {
  if (!band.last() || band.trace_microseconds() == 0) return;
  // A part tells of the whole.
  scheduler_.costs().note(band.tile(), seconds_of(band) * TilePiece::of(band.lease()).parts);
}

bool ActiveFrame::is_sound(const v1::SceneReady::Unseen& unseen) const {
  const auto finite = [](float channel) { return std::isfinite(channel); };
  return unseen.value_size() == assembler_.film().channels() &&
         std::all_of(unseen.value().begin(), unseen.value().end(), finite);
}

void ActiveFrame::fill_unseen(const v1::SceneReady::Unseen& unseen, WorkerId from) {
  if (unseen_distrusted_) return;
  const std::vector<float> value(unseen.value().begin(), unseen.value().end());
  const PixelRect seen = rect_of(unseen.seen());
  if (!unseen_) unseen_ = UnseenWord{from, seen, value};
  unseen_->confirmed |= keys_.voter_of(from) != keys_.voter_of(unseen_->from);
  if (keys_.listed() > 0 && !unseen_->confirmed) return;
  const auto& tiles = assembler_.tiles();
  std::vector<uint32_t> filled;
  for (uint32_t tile = 0; tile < tiles.size(); ++tile) {
    const PixelRect& t = tiles[tile];
    const bool apart =
        seen.empty() || t.x1 <= seen.x0 || t.x0 >= seen.x1 || t.y1 <= seen.y0 || t.y0 >= seen.y1;
    // What somebody holds, or what is in dispute, is traced.
    if (!apart || !scheduler_.untouched(tile)) continue;
    if (assembler_.fill(tile, value, unseen.counters(), from)) filled.push_back(tile);
  }
  scheduler_.restore(filled);
  report_.filled += filled.size();
  filled_.insert(filled.begin(), filled.end());
  for (const uint32_t tile : filled) {
    verifier_.note_rows(tile, from);
    if (unseen_->confirmed) verifier_.note_rows(tile, unseen_->from);
    keep(tile);
    // What two voters say needs no third.
    if (verifier_.selects(tile) && !unseen_->confirmed) scheduler_.want_check(tile, {from});
  }
}

std::optional<WorkerId> ActiveFrame::contradicted(const v1::SceneReady::Unseen& unseen) const {
  if (!unseen_ || unseen_distrusted_) return std::nullopt;
  // As bits: neither a zero's sign nor what is no number may hide a difference.
  const auto same = [](float a, float b) {
    return std::bit_cast<uint32_t>(a) == std::bit_cast<uint32_t>(b);
  };
  if (rect_of(unseen.seen()) == unseen_->seen &&
      std::equal(unseen_->value.begin(), unseen_->value.end(), unseen.value().begin(),
                 unseen.value().end(), same)) {
    return std::nullopt;
  }
  return unseen_->from;
}

SchedulerEvents ActiveFrame::distrust_unseen(WorkerId one, WorkerId other) {
  unseen_distrusted_ = true;
  SchedulerEvents events;
  for (const uint32_t tile : std::exchange(filled_, {})) {
    reopen(tile);
    --report_.filled;
    const SchedulerEvents more = scheduler_.requeue(tile);
    events.cancelled.insert(events.cancelled.end(), more.cancelled.begin(), more.cancelled.end());
  }
  for (const WorkerId worker : {one, other}) {
    verifier_.suspect(worker);
    for (const uint32_t tile : verifier_.tiles_of(worker)) {
      if (assembler_.complete(tile)) scheduler_.want_check(tile, verifier_.traced_by(tile));
    }
  }
  return events;
}

SchedulerEvents ActiveFrame::dispute(Mismatch mismatch, Time now) {
  const uint32_t tile = mismatch.tile;
  reopen(tile);
  SchedulerEvents events = scheduler_.dispute(tile, mismatch.first, mismatch.second, now);
  verifier_.note_dispute(std::move(mismatch));
  return events;
}

SchedulerEvents ActiveFrame::redo_tiles_of(WorkerId worker, bool by_voter) {
  SchedulerEvents events;
  for (const uint32_t tile : verifier_.tiles_of(worker, by_voter)) {
    const SchedulerEvents more = retrace(tile);
    events.cancelled.insert(events.cancelled.end(), more.cancelled.begin(), more.cancelled.end());
  }
  // What it disputes with others needs no third.
  for (const uint32_t tile : verifier_.disputes_of(worker, by_voter)) {
    verifier_.settle(tile);
    scheduler_.forget_dispute(tile);
  }
  return events;
}

v1::Assign ActiveFrame::assignment(const Lease& lease) const {
  v1::Assign assign;
  assign.set_job(id_);
  assign.set_lease(lease.id);
  assign.set_tile(lease.tile);
  *assign.mutable_rect() = to_message(lease.piece().rect(assembler_.tiles()[lease.tile]));
  assign.set_sample_count(samples_);
  return assign;
}

void ActiveFrame::note_assignment(Time now) {
  if (!first_assignment_) first_assignment_ = now;
}

void ActiveFrame::note_tile_seconds(uint32_t tile, double seconds) {
  tile_seconds_.resize(assembler_.tiles().size());
  tile_seconds_[tile] = static_cast<float>(seconds);
}

void ActiveFrame::note_span(FrameTrace::Kind kind, WorkerId worker, const std::string& name,
                            uint32_t tile, Time begin, Time now) {
  constexpr size_t kMostSpans = 1 << 18;  // 16 MiB
  if (trace_.spans.size() >= kMostSpans) {
    ++trace_.left_out;
    return;
  }
  trace_.workers.try_emplace(worker, name);
  const bool of_tile = kind != FrameTrace::Kind::scene;
  trace_.spans.push_back({worker, kind, tile, of_tile ? assembler_.tiles()[tile] : PixelRect{},
                          to_seconds(begin - begun_), to_seconds(now - begun_)});
}

std::vector<TileSnapshot> ActiveFrame::tiles(Time now) const {
  std::vector<TileSnapshot> result;
  const auto& rects = assembler_.tiles();
  for (uint32_t tile = 0; tile < rects.size(); ++tile) {
    const TileScheduler::TileView view = scheduler_.view(tile);
    TileSnapshot& shown = result.emplace_back();
    shown.rect = rects[tile];
    shown.copies = view.copies;
    if (view.done) {
      shown.state = TileSnapshot::State::done;
      const WorkerId by = assembler_.done_by(tile);
      shown.worker = by == kFromStore ? 0 : by;
      if (!tile_seconds_.empty()) shown.seconds = tile_seconds_[tile];
    } else if (view.given_up) {
      shown.state = TileSnapshot::State::given_up;
    } else if (view.copies > 0) {
      shown.state = TileSnapshot::State::assigned;
      shown.worker = view.worker;
      shown.seconds = static_cast<float>(to_seconds(now - view.issued));
    }
  }
  return result;
}

TileWork ActiveFrame::traced() const {
  const uint64_t done = assembler_.tiles_done(), others = report_.tiles_restored + report_.filled;
  return {done - std::min(done, others), scheduler_.costs().known().seconds};
}

void ActiveFrame::fail(ExitCode code, std::string why) {
  if (ended_) return;
  ended_ = true;
  report_.end = JobReport::End::failed;
  report_.exit_code = code;
  report_.failure = std::move(why);
}

void ActiveFrame::note_scene_failure(WorkerId worker, SceneFailure failure) {
  scene_failures_[worker] = failure;
  std::set<WorkerKeys::Voter> voters;
  for (const auto& [id, other] : scene_failures_) {
    if (other.cause == failure.cause) voters.insert(keys_.voter_of(id));
  }
  constexpr size_t kWitnesses = 2;
  if (voters.size() < kWitnesses) return;
  if (failure.cause == v1::SceneFailed::BAD_SCENE) fail(ExitCode::bad_scene, failure.text);
  // Where somebody has built it, what ended the processes of others need not be the scene.
  if (failure.cause == v1::SceneFailed::CRASHED && !built_) {
    fail(ExitCode::render_failed,
         fmt::format("{}; that happened to {} workers", failure.text, voters.size()));
  }
}

void ActiveFrame::look_for_shortage(const std::vector<WorkerId>& present) {
  const bool all = std::all_of(present.begin(), present.end(),
                               [this](WorkerId id) { return scene_failed_at(id); });
  if (present.empty() || !all) return;
  const auto bad = std::find_if(scene_failures_.begin(), scene_failures_.end(), [](const auto& of) {
    return of.second.cause == v1::SceneFailed::BAD_SCENE;
  });
  if (bad == scene_failures_.end()) {
    const std::string why = scene_failures_.empty() ? "workers were lost while they built the scene"
                                                    : scene_failures_.rbegin()->second.text;
    shortage_ = Shortage{fmt::format("{}; a worker that can is waited for", why)};
  } else if (keys_.by_key()) {
    shortage_ = Shortage{fmt::format("{}; one key alone says so, a worker of another is waited for",
                                     bad->second.text)};
  } else {
    fail(ExitCode::bad_scene, bad->second.text);
  }
}

void ActiveFrame::note_lost_builder(WorkerId worker, Time told, Time now) {
  // Many that are lost at once were cut off, or ended together; that counts once.
  if (built_ || told < builder_lost_at_.value_or(told)) return;
  builder_lost_at_ = now;
  lost_builders_.insert(worker);
  // Workers also die of what they trace for other jobs.
  constexpr size_t kMostLost = 5;
  if (lost_builders_.size() < kMostLost) return;
  std::set<WorkerKeys::Voter> voters;
  for (const WorkerId lost : lost_builders_) voters.insert(keys_.voter_of(lost));
  // It is believed of its own workers alone.
  if (voters.size() < 2) return lost_voters_.merge(voters);
  shortage_ = Shortage{
      fmt::format(
          "{} workers, one after the other, were lost while they built the scene, and none "
          "has built it; it may take more memory than they have: 'tessera retry' tries again",
          lost_builders_.size()),
      false};
}

void ActiveFrame::interrupt() {
  if (ended_) return;
  ended_ = true;
  report_.end = JobReport::End::interrupted;
  report_.exit_code = ExitCode::interrupted;
}

JobResult ActiveFrame::finish() {
  const auto& tiles = assembler_.tiles();
  report_.holes = assembler_.holes();
  // Nobody looks at a picture of nothing, which may be large.
  const bool is_seen = report_.end != JobReport::End::interrupted || assembler_.tiles_done() > 0;
  if (is_seen) assembler_.mark_holes();
  if (!ended_ && !report_.holes.empty()) {
    const PixelRect& hole = report_.holes.front();
    fail(ExitCode::render_failed,
         fmt::format("{} of {} tiles were given up, first that at {},{} of {}x{} pixels{}{}",
                     report_.holes.size(), tiles.size(), hole.x0, hole.y0, hole.width(),
                     hole.height(), report_.failure.empty() ? "" : ": ", report_.failure));
  }
  report_.workers_seen = workers_seen_.size();
  report_.counters = assembler_.counters();
  report_.build_counters = assembler_.build_counters();
  report_.tiles_done = assembler_.tiles_done();
  report_.retries = scheduler_.retries();
  report_.speculative = scheduler_.speculative();
  report_.verified = scheduler_.verified();
  report_.unverified = scheduler_.unverified();
  report_.split = scheduler_.split_tiles();
  report_.moved = scheduler_.moved();
  if (first_assignment_ && last_result_) {
    report_.trace_seconds = to_seconds(*last_result_ - *first_assignment_);
  }
  report_.trace = std::make_shared<const FrameTrace>(std::move(trace_));
  return {std::move(report_), std::move(assembler_.film())};
}

}  // namespace tessera
