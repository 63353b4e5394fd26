#include "tests/farm/service_simulation.h"

#include <fmt/format.h>

#include <algorithm>

#include "coordinator/jobs/frame_number.h"
#include "job/job_messages.h"
#include "proto/wire/blob_transfer.h"
#include "proto/wire/scene_codec.h"

namespace tessera::testing {
namespace {

using std::chrono::milliseconds;
using std::chrono::seconds;

constexpr Time kServicePatience = seconds(3600);
constexpr char kLarge[] = "a scene that takes much memory";

Digest digest_of(const Film& film) { return Digest::of(std::as_bytes(film.values())); }

}  // namespace

ServiceSimulation::ServiceSimulation(uint64_t seed)
    : Simulation(seed, [](Faults& faults, CoordinatorOptions&) {
        // Those of one job of this process are simulated there.
        faults.by_client = faults.bad_scene = faults.restarts = false;
      }) {
  service_.jobs = 1 + static_cast<int>(draw(5));
  service_.orders = draw() < 0.4 ? 0 : static_cast<int>(draw(6));
  service_.kills = draw() < 0.3 ? 0 : static_cast<int>(draw(4));
  service_.full = draw() < 0.3;
  service_.spools = draw() < 0.4;
  service_.restores = draw() < 0.2;
  if (service_.spools) {
    faults_.events += 4;
    faults_.orphan_timeout = seconds(3) + draw_time(seconds(5));
    faults_.result_bytes = 1 + draw(8) * 1024;
  }
  // Few jobs meet limits only where these are small.
  options_.begin.jobs = 1 + draw(3);
  options_.begin.urgent_jobs = options_.begin.jobs + draw(3);
  options_.scenes_of_worker = 1 + draw(3);
  const auto film = static_cast<uint64_t>(job_.crop.area()) * kFilmChannels * sizeof(float);
  options_.begin.film_bytes = film * (1 + draw(4));
  coordinator_ = std::make_unique<Coordinator>(options_, store_);
}

std::filesystem::path ServiceSimulation::spool_folder() {
  if (!service_.spools) return {};
  if (!spool_) spool_.emplace();
  return spool_->path();
}

void ServiceSimulation::with_coordinator(const std::function<void(Coordinator&)>& act) {
  // Each act has an instant of its own: what was given out at it was given out by this act.
  ++now_;
  try {
    act(*coordinator_);
  } catch (const Killed&) {
    restart();
  }
  if (flaw_.empty()) flaw_ = coordinator_->broken_rule(now_);
}

void ServiceSimulation::restart() {
  say("the coordinator is killed, and started anew");
  coordinator_stopped_until_ = {};
  ++restarts_;
  options_.opening = opening_of(++openings_);
  coordinator_ = std::make_unique<Coordinator>(options_, store_);
  deliver();
}

void ServiceSimulation::restore(const MortalStore& copy) {
  say("a copy of the store is restored");
  *store_ = copy;
  for (auto& [peer, client] : clients_) {
    client.ended = false;
    if (client.job != 0 && client.job <= store_->last_job()) continue;
    // What is on its way of the submission of before is about a job that is gone.
    client.job = 0;
    if (client.wants != v1::JobQuery::CANCEL) client.wants = v1::JobQuery::ASK;
    client.request.set_submission(random_() | 1);
  }
  restart();
}

void ServiceSimulation::note_sent(const OutgoingMessage& out) {
  // A kept tile may be given out again to be verified.
  if (!out.message.has_assign() || options_.verify > 0) return;
  const v1::Assign& assign = out.message.assign();
  const uint64_t job = job_of_number(assign.job());
  const auto frame = static_cast<int>(frame_of_number(assign.job()));
  const auto jobs = store_->jobs();
  const auto of = std::find_if(jobs.begin(), jobs.end(),
                               [job](const v1::KeptJob& kept) { return kept.job() == job; });
  if (of == jobs.end()) return;
  const std::string& key = of->tile_keys(frame);
  // A client that took its submission for refused may have made another job of the same frames.
  const auto has_key = [&key](const v1::KeptJob& kept) {
    return std::count(kept.tile_keys().begin(), kept.tile_keys().end(), key) > 0;
  };
  if (std::count_if(jobs.begin(), jobs.end(), has_key) > 1) return;
  const v1::PixelRect& r = assign.rect();
  for (const FinishedTile& tile : store_->find(*Digest::parse(key))) {
    if (tile.rect != PixelRect{r.x0(), r.y0(), r.x1(), r.y1()}) continue;
    flaw_ = fmt::format("tile {} of job {} is kept, and given out again", assign.tile(), job);
  }
}

// --------------------------------------------------------------------------------------- clients

void ServiceSimulation::come(int number) {
  Client client;
  client.request.set_submission(random_() | 1);
  client.request.set_detached(true);
  client.request.set_priority(static_cast<int32_t>(draw(3)));
  client.request.set_weight(1 + static_cast<uint32_t>(draw(3)));
  const int frames = draw() < 0.6 ? 1 : 2 + static_cast<int>(draw(2));
  const int large_frame = draw() < 0.2 ? static_cast<int>(draw(static_cast<uint64_t>(frames))) : -1;
  for (int frame = 0; frame < frames; ++frame) {
    JobSpec spec = job_;
    spec.frame.set_seed(static_cast<uint32_t>(100 * number + frame));
    // Some scenes no worker can build for a while.
    if (frame == large_frame) spec.scene.mutable_metadata()->set_title(kLarge);
    v1::JobFrame& added = *client.request.add_frames();
    const std::string scene = serialize_scene(spec.scene);
    const auto bytes = std::as_bytes(std::span(scene));
    added.set_scene_digest(client.blobs.put({bytes.begin(), bytes.end()}).hex());
    added.set_scene_size(scene.size());
    *added.mutable_settings() = spec.frame;
    *client.request.mutable_crop() = to_message(spec.crop);
    client.request.set_tile_size(static_cast<uint32_t>(spec.tile_size));
    Film film(spec.crop);
    TileProgress progress;
    const auto pixels = FakeRenderer(spec.frame.seed())
                            .render({spec.crop, 0, spec.frame.samples_per_pixel()}, progress);
    film.write(spec.crop, spec.crop.y0, spec.crop.height(), pixels->values);
    client.films.push_back(digest_of(film));
  }
  const PeerId peer = fmt::format("client-{}", number);
  ask(peer, clients_.emplace(peer, std::move(client)).first->second);
}

void ServiceSimulation::ask(const PeerId& peer, Client& client) {
  client.next_question = now_ + milliseconds(500);
  v1::Envelope message;
  if (client.job == 0) {
    *message.mutable_submit_job() = client.request;
  } else {
    // Its number may be another's once a copy of the store was restored.
    message.mutable_job_query()->set_submission(client.request.submission());
    message.mutable_job_query()->set_action(client.wants);
    if (client.priority) message.mutable_job_query()->set_priority(*client.priority);
  }
  carry(message, peer + ">0", [this, peer](const v1::Envelope& arrived) {
    to_coordinator(Channel::control, peer, arrived);
  });
}

bool ServiceSimulation::tell_client(const PeerId& peer, Channel, const v1::Envelope& message) {
  const auto it = clients_.find(peer);
  if (it == clients_.end()) return false;
  Client& client = it->second;
  if (message.has_blob_request()) {
    const auto digest = Digest::parse(message.blob_request().digest());
    const v1::Envelope answer =
        answer_blob_request(message.blob_request(), digest ? client.blobs.find(*digest) : nullptr);
    carry(answer, peer + ">1", [this, peer](const v1::Envelope& arrived) {
      to_coordinator(Channel::bulk, peer, arrived);
    });
  }
  if (message.has_job_status()) on_status(client, message.job_status());
  return true;
}

void ServiceSimulation::on_status(Client& client, const v1::JobStatus& status) {
  if (status.submission() != client.request.submission()) return;
  if (client.job == 0) {
    client.job = status.job();
    // Refused, since the store took nothing: it is another submission then.
    if (client.job == 0 && status.state() == v1::JobStatus::ENDED) {
      client.request.set_submission(random_() | 1);
    }
    return;
  }
  if (status.state() == v1::JobStatus::UNKNOWN) flaw_ = "an accepted job is unknown";
  // The refusal of an earlier copy of the submission may come after the word that it was accepted.
  if (status.job() == 0) return;
  client.ended |= status.state() == v1::JobStatus::ENDED;
  const bool paused = status.state() == v1::JobStatus::PAUSED;
  if (client.wants == v1::JobQuery::PAUSE && paused) client.wants = v1::JobQuery::ASK;
  // Workers that could not build a scene are not tried again of themselves.
  if (quiet_ && client.wants != v1::JobQuery::CANCEL) {
    const bool held = !paused && !status.failure().empty();
    client.wants = held ? v1::JobQuery::RETRY : v1::JobQuery::RESUME;
  }
  // In the end it insists: an order of before may have been on its way for long.
  const bool resumed = client.wants == v1::JobQuery::RESUME && !paused && !quiet_;
  if (resumed) client.wants = v1::JobQuery::ASK;
}

std::optional<std::string> ServiceSimulation::cannot_build(const v1::Scene& scene) {
  // Of a frame that does not fit, the rest of the job and other jobs go on.
  if (quiet_ || scene.metadata().title() != kLarge) return std::nullopt;
  return "there is not enough memory for the scene";
}

void ServiceSimulation::give_order() {
  if (clients_.empty()) return;
  auto it = clients_.begin();
  std::advance(it, static_cast<ptrdiff_t>(draw(clients_.size())));
  Client& client = it->second;
  if (client.job == 0 || client.wants == v1::JobQuery::CANCEL) return;
  const double what = draw();
  client.wants = what < 0.5    ? v1::JobQuery::PAUSE
                 : what < 0.85 ? v1::JobQuery::RESUME
                               : v1::JobQuery::CANCEL;
  client.priority.reset();
  if (draw() < 0.3) client.priority = static_cast<int32_t>(draw(4));
  say(fmt::format("{}: order {}", it->first, static_cast<int>(client.wants)));
  ask(it->first, client);
}

Time ServiceSimulation::next_client_time() const {
  Time next = Time::max();
  for (const auto& [peer, client] : clients_) {
    if (!client.ended) next = std::min(next, client.next_question);
  }
  return next;
}

void ServiceSimulation::tick_clients() {
  for (auto& [peer, client] : clients_) {
    if (!client.ended && now_ >= client.next_question) ask(peer, client);
  }
}

// ------------------------------------------------------------------------------------------- run

std::string ServiceSimulation::verdict() {
  for (auto& [peer, client] : clients_) {
    for (uint32_t frame = 0; frame < client.films.size(); ++frame) {
      v1::JobQuery query;
      query.set_job(client.job);
      query.set_frame(frame);
      const v1::JobStatus status = coordinator_->ask(query, now_);
      if (status.how() == v1::JobEnd::INTERRUPTED) {
        if (client.wants != v1::JobQuery::CANCEL) return "a job is cancelled that nobody cancelled";
        cancelled_ += frame == 0;
        break;
      }
      if (status.end().how() != v1::JobEnd::DONE) return "a frame fails: " + status.failure();
      if (status.end().film_digest() != client.films[frame].hex()) return "another picture";
      const auto rays = static_cast<uint64_t>(job_.crop.area()) * 4;
      if (status.end().counters().values().at("rays_primary") != rays) {
        return "a tile was counted more or less than once";
      }
      restored_ += status.end().totals().values().at("tiles_restored");
    }
  }
  return "";
}

bool ServiceSimulation::end_again() {
  bool any = false;
  for (auto& [peer, client] : clients_) {
    v1::JobQuery query;
    query.set_job(client.job);
    client.ended = coordinator_->ask(query, now_).state() == v1::JobStatus::ENDED;
    any |= !client.ended;
  }
  return service_.restores && any;
}

std::string ServiceSimulation::run_service() {
  const Time start = now_;
  plan_stop();
  for (int i = 0; i < 3; ++i) at(now_ + draw_time(milliseconds(500)), [this] { join(); });
  for (int i = 0; i < service_.jobs; ++i) at(now_ + draw_time(seconds(5)), [this, i] { come(i); });
  for (int i = 0; i < faults_.events; ++i) {
    at(now_ + draw_time(seconds(20)), [this] { something_happens(); });
  }
  for (int i = 0; i < service_.orders; ++i) {
    at(now_ + draw_time(seconds(20)), [this] { give_order(); });
  }
  for (int i = 0; i < service_.kills; ++i) {
    at(now_ + draw_time(seconds(10)),
       [this] { store_->kill_at(static_cast<int>(draw(20)), draw() < 0.5); });
  }
  if (service_.restores) {
    at(now_ + draw_time(seconds(8)),
       [this] { at(now_ + draw_time(seconds(8)), [this, copy = *store_] { restore(copy); }); });
  }
  if (service_.full) {
    at(now_ + draw_time(seconds(5)), [this] {
      store_->set_full(true);
      at(now_ + draw_time(seconds(15)), [this] { store_->set_full(false); });
    });
  }
  at(now_ + seconds(20), [this] {
    thaw_all();
    store_->set_full(false);
    for (auto& [peer, client] : clients_) {
      if (client.wants != v1::JobQuery::CANCEL) client.wants = v1::JobQuery::RESUME;
    }
  });
  while (now_ - start < kServicePatience && flaw_.empty()) {
    now_ = next_time();
    tick();
    const bool all = clients_.size() == static_cast<size_t>(service_.jobs) &&
                     std::all_of(clients_.begin(), clients_.end(),
                                 [](const auto& entry) { return entry.second.ended; });
    if (hasty_workers() > 0) flaw_ = "a worker took its own absence for the coordinator's";
    if (all && !end_again()) return flaw_.empty() ? verdict() : flaw_;
  }
  return flaw_.empty() ? "the jobs do not end" : flaw_;
}

}  // namespace tessera::testing
