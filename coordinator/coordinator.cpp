#include "coordinator/coordinator.h"

#include <algorithm>
#include <utility>

#include "base/log.h"
#include "base/plural.h"

#include "coordinator/done_tiles.h"
#include "coordinator/jobs/memory_job_store.h"
#include "coordinator/tiles/identity.h"
#include "proto/wire/blob_transfer.h"

namespace tessera {
namespace {

constexpr Time kTick = std::chrono::milliseconds(100);

}  // namespace

Coordinator::Coordinator(CoordinatorOptions options, std::shared_ptr<JobStore> store)
    : options_(std::move(options)) {
  if (!store) store = std::make_shared<MemoryJobStore>();
  options_.farm = store->farm();
  jobs_ = std::make_unique<JobTable>(options_, store);
  workers_ = std::make_unique<WorkerService>(options_, *jobs_);
  clients_ = std::make_unique<ClientService>(options_, *jobs_, std::move(store));
  set_worker_keys(options_.worker_keys);
}

void Coordinator::set_worker_keys(size_t listed) {
  jobs_->keys().set_listed(listed);
  if (options_.verify == 0 || listed == 0 || listed > 2) return;
  spdlog::warn("--verify: keys of {} are listed: {}; expected three or more",
               counted(listed, "worker"),
               listed == 1 ? "what processes of one key get is compared, which finds faults but "
                             "proves nothing against whoever holds the key"
                           : "a difference is found, but nobody can say which of the two is wrong, "
                             "and the job fails");
}

uint64_t Coordinator::submit(JobSpec spec, Time now, std::shared_ptr<TileStore> tiles) {
  jobs_->account(now);
  const uint64_t id = jobs_->submit(std::move(spec), std::move(tiles));
  try {
    settle(now);
  } catch (...) {
    // No memory for its film, say. It would be begun again, and fail again, with each job after it.
    abandon(id);
    throw;
  }
  return id;
}

void Coordinator::interrupt(uint64_t job, Time now) {
  jobs_->account(now);
  jobs_->interrupt(job, now);
  settle(now);
}

void Coordinator::abandon(uint64_t job) { jobs_->abandon(job); }

void Coordinator::fail_jobs(const std::string& why, Time now) {
  for (ActiveFrame* job : jobs_->running()) job->fail(ExitCode::render_failed, why);
  settle(now);
}

std::optional<JobResult> Coordinator::take_result(uint64_t job) { return jobs_->take_result(job); }

JobProgress Coordinator::progress(Time now) const {
  JobProgress progress;
  const auto& running = jobs_->running();
  if (!running.empty()) return this->progress(running.front()->id(), now).value_or(progress);
  progress.workers = workers().present_count();
  return progress;
}

std::optional<JobProgress> Coordinator::progress(uint64_t job, Time now) const {
  std::optional<JobProgress> progress = jobs_->progress(job, now);
  if (!progress) return std::nullopt;
  progress->workers = workers().present_count();
  if (progress->workers == 0) progress->waiting_for = "workers";
  return progress;
}

std::vector<TileSnapshot> Coordinator::tiles(uint64_t job, Time now) const {
  const ActiveFrame* const active = std::as_const(*jobs_).running(job);
  return active ? active->tiles(now) : std::vector<TileSnapshot>();
}

std::optional<FilmView> Coordinator::film(uint64_t job) const {
  const ActiveFrame* const active = std::as_const(*jobs_).running(job);
  if (!active) return std::nullopt;
  const Film& film = active->assembler().film();
  return FilmView{film.rect(), film.channels(), film.values(), nullptr};
}

void Coordinator::note_assembling(uint64_t job, Time spent) {
  if (ActiveFrame* active = jobs_->running(job)) {
    active->report().assemble_seconds += to_seconds(spent);
  }
}

void Coordinator::note_workers() const {
  jobs_->set_workers(workers().present_count(), workers().present_threads());
}

void Coordinator::settle(Time now) {
  const JobTable::Changes changes = jobs_->advance(now);
  if (!changes.settled) next_tick_ = now;
  workers_->follow(changes, now);
  collect_outgoing();
}

void Coordinator::collect_outgoing() {
  std::vector<WorkerService::Outgoing>& for_workers = workers_->outgoing();
  outgoing_.reserve(outgoing_.size() + for_workers.size());
  for (WorkerService::Outgoing& out : for_workers) {
    outgoing_.push_back({Channel::control, std::move(out.peer), std::move(out.message)});
  }
  for_workers.clear();
  auto for_clients = clients_->take_outgoing();
  if (for_clients.empty()) return;
  const auto count = static_cast<uint32_t>(workers().present_count());
  for (ClientService::Outgoing& out : for_clients) {
    if (out.message.has_job_status()) out.message.mutable_job_status()->set_workers(count);
    if (out.message.has_job_list()) {
      out.message.mutable_job_list()->set_workers(count);
      out.message.mutable_job_list()->set_threads(workers().present_threads());
    }
    outgoing_.push_back({Channel::control, std::move(out.peer), std::move(out.message)});
  }
}

std::vector<OutgoingMessage> Coordinator::take_outgoing() {
  collect_outgoing();
  return std::exchange(outgoing_, {});
}

void Coordinator::on_message(Channel channel, const PeerId& peer, const v1::Envelope& message,
                             Time now, const AllowedKey& sender) {
  jobs_->account(now);
  const bool of_client = message.has_submit_job() || message.has_blob_chunk() ||
                         message.has_job_query() || message.has_job_list_query();
  if (of_client) note_workers();
  if (channel == Channel::bulk) {
    if (message.has_blob_request()) return on_blob_request(peer, message.blob_request());
    if (message.has_done_tiles_query()) {
      return on_done_tiles_query(peer, message.done_tiles_query());
    }
    if (message.has_blob_chunk()) clients_->on_chunk(message.blob_chunk(), now);
    if (message.has_blob_missing()) clients_->on_missing(message.blob_missing(), now);
  } else if (!clients_->on_control(peer, message, now, sender)) {
    workers_->on_control(peer, message, now, sender);
  }
  settle(now);
}

void Coordinator::on_blob_request(const PeerId& peer, const v1::BlobRequest& request) {
  const auto digest = Digest::parse(request.digest());
  const auto blob = digest ? jobs_->find_blob(*digest) : JobTable::FoundBlob{};
  OutgoingMessage answer{Channel::bulk, peer, {}};
  const bool shared = options_.shared_by_process != 0 && blob.data && blob.data->descriptor() >= 0;
  if (request.place() && shared) {
    v1::BlobPlace& place = *answer.message.mutable_blob_place();
    place.set_digest(request.digest());
    place.set_process_id(options_.shared_by_process);
    place.set_file(static_cast<uint32_t>(blob.data->descriptor()));
  } else {
    answer.message = answer_blob_request(request, blob.data);
  }
  // Films that clients fetch are no part of what the job costs.
  if (blob.of) {
    const uint64_t bytes = answer.message.blob_chunk().data().size();
    blob.of->report().bytes_scene += bytes;
    bytes_scene_ += bytes;
  }
  outgoing_.push_back(std::move(answer));
}

void Coordinator::on_done_tiles_query(const PeerId& peer, const v1::DoneTilesQuery& query) {
  OutgoingMessage answer{Channel::bulk, peer, {}};
  v1::DoneTiles& tiles = *answer.message.mutable_done_tiles();
  tiles.set_question(query.question());
  const Job* const job = query.submission() != 0 ? jobs_->find_submission(query.submission())
                                                 : jobs_->find(query.job());
  const ActiveFrame* const active =
      job && !job->local() ? jobs_->running(job->id(), query.frame()) : nullptr;
  if (active) add_done_tiles(*active, options_.opening, query, tiles);
  outgoing_.push_back(std::move(answer));
}

void Coordinator::on_peer_gone(const PeerId& peer, Time now, bool welcomed) {
  jobs_->account(now);
  workers_->on_peer_gone(peer, now, welcomed);
  settle(now);
}

void Coordinator::on_process_ended(pid_t process, bool crashed, const std::string& how, Time now) {
  jobs_->account(now);
  workers_->on_process_ended(process, crashed, how, now);
  settle(now);
}

void Coordinator::on_tick(Time now) {
  // Who slept through its own deadline (a stopped process, a suspended machine) heard nobody.
  const Time overslept = first_tick_ ? now - next_tick_ : Time{0};
  if (overslept > options_.heartbeat) {
    // A heartbeat more, for what is on its way.
    workers_->forgive(overslept + options_.heartbeat, now);
    clients_->forgive(overslept + options_.heartbeat, now);
  }
  if (!first_tick_) first_tick_ = now;
  jobs_->account(now);
  jobs_->keep_rest();
  jobs_->keep_times();
  if (jobs_->running().empty()) jobs_->tidy();
  tell_trouble();
  workers_->on_tick(now);
  clients_->on_tick(now);
  next_tick_ = now + (jobs_->running().empty() ? options_.heartbeat : kTick);
  settle(now);
}

void Coordinator::tell_trouble() {
  const std::string trouble = jobs_->store_trouble();
  if (trouble.empty() == trouble_.empty()) return;
  trouble_ = trouble;
  if (trouble.empty()) {
    spdlog::info("the store takes tiles again: jobs go on");
  } else {
    spdlog::error("{}; no tile is given out until that can be kept", trouble);
  }
}

FarmSnapshot Coordinator::snapshot(Time now) const {
  FarmSnapshot snapshot;
  workers_->describe(snapshot, now);
  note_workers();
  jobs_->describe(snapshot, now);
  snapshot.counters.bytes_scene = bytes_scene_;
  snapshot.farm = options_.farm;
  snapshot.opening = id_text(options_.opening);
  snapshot.uptime_seconds = first_tick_ ? to_seconds(now - *first_tick_) : 0;
  return snapshot;
}

std::string Coordinator::broken_rule(Time now) const {
  // What time alone brings is seen with the next tick.
  const bool has_ticked = next_tick_ == now + kTick || next_tick_ == now + options_.heartbeat;
  const std::string broken = has_ticked ? jobs_->broken_rule(now) : "";
  return broken.empty() ? workers_->broken_rule(now, has_ticked) : broken;
}

std::vector<TileSnapshot> Coordinator::tiles(uint64_t job, uint32_t frame, Time now) const {
  const ActiveFrame* active = jobs_->running(job, frame);
  return active ? active->tiles(now) : std::vector<TileSnapshot>();
}

std::optional<PreviewImage> Coordinator::preview(uint64_t job, uint32_t frame, int most_side) {
  return jobs_->preview(job, frame, most_side);
}

int32_t Coordinator::number_of(uint64_t job, uint32_t frame) const {
  return jobs_->number_of(job, frame);
}

std::vector<std::pair<uint64_t, uint32_t>> Coordinator::running_frames() const {
  return jobs_->running_frames();
}

std::optional<FilmView> Coordinator::film(uint64_t job, uint32_t frame) {
  return jobs_->film(job, frame);
}

std::optional<std::pair<BlobData, BlobStore>> Coordinator::scene(uint64_t job, uint32_t frame) {
  return jobs_->scene(job, frame);
}

std::shared_ptr<const FrameTrace> Coordinator::trace(uint64_t job, uint32_t frame) const {
  return jobs_->trace(job, frame);
}

v1::JobStatus Coordinator::ask(const v1::JobQuery& query, Time now) {
  jobs_->account(now);
  note_workers();
  v1::JobStatus status = clients_->ask(query, now);
  settle(now);
  return status;
}

bool Coordinator::drained() const {
  const auto& running = jobs_->running();
  return jobs_->store_trouble().empty() &&
         std::all_of(running.begin(), running.end(),
                     [](const ActiveFrame* job) { return job->scheduler().live_count() == 0; });
}

void Coordinator::shut_down(const std::string& reason) {
  jobs_->keep_times(true);
  workers_->shut_down(reason);
  clients_->close(reason);
}

}  // namespace tessera
