#include "bench/error_bench.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <map>
#include <memory>

#include "base/error.h"
#include "base/monotonic.h"
#include "base/plural.h"
#include "bench/error/closed_forms.h"
#include "bench/error_render.h"

namespace tessera {
namespace {

/// A curve ends where its error comes within this factor of the reference's own.
constexpr double kReferenceMargin = 5;
/// Seeds of a row whose metrics are all worked out; the others give their MSE and bias.
constexpr size_t kDetailedSeeds = 4;
/// Shares of a scene's budget: of its reference, and of what is left for any one row.
constexpr double kReferenceShare = .35, kRowShare = .5;

class SceneBench {
 public:
  SceneBench(const AccuracyScene& scene, const ErrorBenchOptions& options)
      : scene_(scene), options_(options), start_(monotonic_now()) {
    out_.scene = scene.name;
    out_.about = scene.about;
    if (options.cpu_time) out_.clock = "processor seconds a picture, over threads";
    out_.width = static_cast<int>(scene.loaded.scene.settings().width());
    out_.height = static_cast<int>(scene.loaded.scene.settings().height());
    mask_ = mask();
    for (const ErrorMethod& method : options.methods) {
      Contestant contestant{method, with_method(scene.loaded.scene, method)};
      warm_up(contestant);
      contestants_.push_back(std::move(contestant));
      out_.curves.push_back({scene.name, method.name, {}, 0, {}});
    }
    for (Contestant& contestant : contestants_) contestant.truth = reference(contestant);
    set_pilot();
  }

  SceneErrors run() {
    for (int samples = options_.least_samples; samples <= options_.most_samples; samples *= 2) {
      const int seeds = seeds_for(samples);
      if (seeds == 0) {
        for (size_t i = 0; i < contestants_.size(); ++i)
          if (!contestants_[i].is_done) out_.curves[i].end = "the budget is spent";
        break;
      }
      row(samples, seeds);
    }
    for (ErrorCurve& curve : out_.curves) fit_slope(curve);
    for (const ErrorPeer& peer : options_.peers) add_peer(peer);
    return std::move(out_);
  }

 private:
  struct Contestant {
    ErrorMethod method;
    v1::Scene scene;
    double seconds_a_sample = 0, seconds_a_build = 0;
    std::shared_ptr<const Reference> truth{};
    double truth_error = 0;
    bool is_done = false;  ///< it came too near to the reference's error
  };

  double elapsed() const { return to_seconds(monotonic_now() - start_); }

  PixelMask mask() const {
    if (scene_.left_out.empty()) return {};
    PixelMask out(static_cast<size_t>(out_.width) * static_cast<size_t>(out_.height), 1);
    for (const AccuracyScene::Part& part : scene_.left_out)
      for (int y = 0; y < out_.height; ++y)
        for (int x = 0; x < out_.width; ++x)
          if (x + 1 > part.x0 * out_.width && x < part.x1 * out_.width &&
              y + 1 > part.y0 * out_.height && y < part.y1 * out_.height)
            out[static_cast<size_t>(y) * static_cast<size_t>(out_.width) + static_cast<size_t>(x)] =
                0;
    return out;
  }

  void tell(const std::string& what, double share) const {
    if (options_.on_progress) options_.on_progress(what, share);
  }

  ErrorPicture render(const Contestant& contestant, const ErrorShot& shot) const {
    return render_shot(contestant.scene, scene_.loaded.blobs, contestant.method, shot,
                       options_.threads);
  }

  /// Two pictures: the second tells the speed.
  void warm_up(Contestant& contestant) const {
    tell(contestant.method.name + ": warming up", 0);
    constexpr uint32_t kSamples = 16;  // a square, for the grids
    for (int i = 0; i < 2; ++i) {
      const ErrorRun run = render(contestant, {kSamples, 0, 1e-9}).run;
      contestant.seconds_a_sample = run.wall_seconds / kSamples;
      contestant.seconds_a_build = run.build_seconds;
    }
  }

  /// One for all methods with the same pixel filter.
  std::shared_ptr<const Reference> reference(Contestant& contestant) {
    const int filter = contestant.method.filter.value_or(
        static_cast<int>(scene_.loaded.scene.settings().sampling().filter()));
    auto& known = references_[filter];
    if (!known) known = make_reference(contestant, filter);
    contestant.truth_error = known->error(mask_);
    out_.reference_error = std::max(out_.reference_error, contestant.truth_error);
    return known;
  }

  std::shared_ptr<const Reference> make_reference(const Contestant& contestant, int filter) {
    const auto found = [this](const std::string& text, Reference reference) {
      if (out_.reference.empty()) out_.reference = text;
      return std::make_shared<const Reference>(std::move(reference));
    };
    if (!options_.given_reference.empty()) {
      const Picture& first = options_.given_reference.front();
      const Picture& second = options_.given_reference.back();
      check_size(first, "--reference");
      check_size(second, "--reference");
      return found(options_.given_reference.size() > 1 ? "two given pictures" : "a given picture",
                   {first, second});
    }
    if (filter == v1::Sampling::BOX) {
      if (auto exact = closed_form(scene_.name, out_.width, out_.height))
        return found("closed form", {*exact, *exact});
    }
    uint32_t samples = static_cast<uint32_t>(options_.reference_samples);
    if (options_.budget_seconds > 0) {
      const double seconds = kReferenceShare * options_.budget_seconds;
      while (samples > 64 && 2 * samples * contestant.seconds_a_sample > seconds) samples /= 2;
    }
    tell(fmt::format("two references of {} samples", samples), 0);
    v1::Scene scene = with_method(scene_.loaded.scene, {"reference"});
    scene.mutable_settings()->mutable_sampling()->set_filter(
        static_cast<v1::Sampling::Filter>(filter));
    Reference rendered = converged_reference(scene, scene_.loaded.blobs, samples,
                                             static_cast<uint32_t>(options_.reference_samples),
                                             options_.cache_folder, options_.threads);
    const double error = rendered.error(mask_);
    return found(fmt::format("two pictures of {} samples, error {:.2g}", samples, error),
                 std::move(rendered));
  }

  void check_size(const Picture& picture, const std::string& whose) const {
    if (picture.width != out_.width || picture.height != out_.height)
      throw usage_error(fmt::format("{}: its picture has {}x{} pixels; expected {}x{}, or --size",
                                    whose, picture.width, picture.height, out_.width, out_.height));
  }

  /// The error of the first method at the first number of samples, for adaptive ones to aim at.
  void set_pilot() {
    const Contestant& first = contestants_.front();
    const auto samples = static_cast<uint32_t>(options_.least_samples);
    const ErrorPicture picture = render(first, {samples, 0, 1e-9});
    pilot_ = std::sqrt(std::max(0.0, mean_square_error(picture.picture, *first.truth, mask_)));
  }

  /// How many seeds the time that is left allows for; 0: too few.
  int seeds_for(int samples) const {
    double round = 0;
    bool any = false;
    for (const Contestant& contestant : contestants_) {
      if (contestant.is_done) continue;
      any = true;
      round += samples * contestant.seconds_a_sample + contestant.seconds_a_build;
    }
    if (!any) return 0;
    if (!(options_.budget_seconds > 0)) return options_.seeds;
    const double left = options_.budget_seconds - elapsed();
    const int wanted = static_cast<int>(std::min<double>(options_.seeds, kRowShare * left / round));
    if (wanted >= kLeastSeeds) return wanted;
    const bool is_early = samples <= 2 * options_.least_samples;  // a curve has two points at least
    return is_early || kLeastSeeds * round <= left ? std::min(kLeastSeeds, options_.seeds) : 0;
  }

  double share_done(int samples, double within) const {
    if (options_.budget_seconds > 0) return std::min(1.0, elapsed() / options_.budget_seconds);
    return (samples * (1 + within) - options_.least_samples) /
           (2.0 * options_.most_samples - options_.least_samples);
  }

  /// One row of every method that goes on: seed by seed, methods in turns.
  void row(int samples, int seeds) {
    std::vector<ErrorRow> rows(contestants_.size());
    std::vector<BiasEstimator> biases;
    for (size_t i = 0; i < contestants_.size(); ++i) {
      biases.emplace_back(*contestants_[i].truth, mask_);
      rows[i].samples = contestants_[i].method.is_adaptive ? 0 : samples;
    }
    for (int seed = 1; seed <= seeds; ++seed) {
      for (size_t i = 0; i < contestants_.size(); ++i) {
        if (contestants_[i].is_done) continue;
        tell(fmt::format("{}: {}, seed {} of {}", contestants_[i].method.name,
                         counted(samples, "sample"), seed, seeds),
             share_done(samples, double(seed - 1) / seeds));
        shoot(contestants_[i], samples, seed, seeds, rows[i], biases[i]);
      }
    }
    for (size_t i = 0; i < contestants_.size(); ++i)
      if (!contestants_[i].is_done) finish(i, samples, biases[i].result(), std::move(rows[i]));
  }

  void shoot(const Contestant& contestant, int samples, int seed, int seeds, ErrorRow& row,
             BiasEstimator& bias) const {
    ErrorShot shot{static_cast<uint32_t>(samples), static_cast<uint32_t>(seed), 0};
    if (contestant.method.is_adaptive) {
      constexpr uint32_t kMostTimes = 16;
      shot.target_error = pilot_ * std::sqrt(double(options_.least_samples) / samples);
      shot.samples = std::min<uint32_t>(shot.samples * kMostTimes, 1u << 20);
    }
    ErrorPicture picture = render(contestant, shot);
    if (options_.cpu_time) picture.run.wall_seconds = picture.run.cpu_seconds / options_.threads;
    picture.run.mse = mean_square_error(picture.picture, *contestant.truth, mask_);
    row.runs.push_back(picture.run);
    row.not_finite += picture.not_finite;
    if (contestant.method.is_adaptive) row.samples += picture.mean_samples / seeds;
    bias.add(picture.picture);
    if (row.runs.size() > kDetailedSeeds) return;
    add_error(picture_error(picture.picture, contestant.truth->mean(), mask_),
              std::min<size_t>(kDetailedSeeds, static_cast<size_t>(seeds)), row.error);
  }

  /// Means over `count` pictures, of max_error the greatest.
  static void add_error(const PictureError& one, size_t count, PictureError& sum) {
    const auto n = static_cast<double>(count);
    sum.mse += one.mse / n;
    sum.rmse += one.rmse / n;
    sum.rel_mse += one.rel_mse / n;
    sum.trimmed_rel_mse += one.trimmed_rel_mse / n;
    sum.smape += one.smape / n;
    sum.flip += one.flip / n;
    sum.error_99_9 += one.error_99_9 / n;
    sum.mean_ratio += one.mean_ratio / n;
    sum.max_error = std::max(sum.max_error, one.max_error);
  }

  /// The row of method `i`, which was asked for so many samples a pixel.
  void finish(size_t i, int asked, const BiasEstimator::Result& bias, ErrorRow row) {
    Contestant& contestant = contestants_[i];
    row.bias = bias.bias;
    row.bias_sigmas = bias.sigmas;
    summarize(row);
    auto& rows = out_.curves[i].rows;
    if (row.rmse < kReferenceMargin * contestant.truth_error) {
      contestant.is_done = true;
      const bool is_left_out = !rows.empty();
      if (is_left_out || asked < options_.most_samples)
        out_.curves[i].end =
            fmt::format("its error comes within {} times the reference's own, {:.2g}",
                        kReferenceMargin, contestant.truth_error);
      if (is_left_out) return;
    }
    const auto& base = out_.curves.front().rows;
    if (i > 0 && !base.empty() && base.back().samples == row.samples) compare(row, base.back());
    rows.push_back(std::move(row));
  }

  void add_peer(const ErrorPeer& peer) {
    check_size(peer.picture, "--peer " + peer.name);
    const Reference& truth = *contestants_.front().truth;
    PeerMark mark{peer.name, peer.seconds, peer.samples, {}, 0};
    mark.error = picture_error(peer.picture, truth.mean(), mask_);
    Picture scaled = peer.picture;
    if (mark.error.mean_ratio > 0)
      for (float& value : scaled.values)
        value = static_cast<float>(double{value} / mark.error.mean_ratio);
    mark.rmse_scaled = std::sqrt(std::max(0.0, mean_square_error(scaled, truth, mask_)));
    out_.peers.push_back(std::move(mark));
  }

  const AccuracyScene& scene_;
  const ErrorBenchOptions& options_;
  Time start_;
  SceneErrors out_;
  PixelMask mask_;
  std::vector<Contestant> contestants_;
  std::map<int, std::shared_ptr<const Reference>> references_;  ///< by pixel filter
  double pilot_ = 0;
};

}  // namespace

SceneErrors bench_error(const AccuracyScene& scene, const ErrorBenchOptions& options) {
  TESSERA_CHECK(!options.methods.empty() && options.seeds > 0 && options.least_samples > 0,
                fmt::format("{} methods, {} seeds", options.methods.size(), options.seeds));
  return SceneBench(scene, options).run();
}

}  // namespace tessera
