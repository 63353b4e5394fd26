#include "bench/error/curve.h"

#include <cmath>

namespace tessera {
namespace {

double mean_mse(const std::vector<ErrorRun>& runs, std::span<const uint32_t> picks) {
  double sum = 0;
  for (const uint32_t i : picks) sum += runs[i].mse;
  return std::max(0.0, sum / static_cast<double>(picks.size()));
}

/// The mean MSE times the median seconds of the runs with these numbers.
double cost(const std::vector<ErrorRun>& runs, std::span<const uint32_t> picks) {
  std::vector<double> seconds;
  seconds.reserve(picks.size());
  for (const uint32_t i : picks) seconds.push_back(runs[i].wall_seconds);
  return mean_mse(runs, picks) * median(std::move(seconds));
}

std::vector<uint32_t> first_numbers(size_t count) {
  std::vector<uint32_t> out(count);
  for (size_t i = 0; i < count; ++i) out[i] = static_cast<uint32_t>(i);
  return out;
}

template <typename Member>
double median_of(const std::vector<ErrorRun>& runs, Member member) {
  std::vector<double> values;
  for (const ErrorRun& run : runs) values.push_back(run.*member);
  return median(std::move(values));
}

/// The rows that a slope can be fitted to.
std::vector<const ErrorRow*> fitted_rows(const ErrorCurve& curve) {
  std::vector<const ErrorRow*> all, usual;
  for (const ErrorRow& row : curve.rows) {
    if (!(row.rmse > 0)) continue;
    all.push_back(&row);
    if (row.samples >= 4) usual.push_back(&row);
  }
  return usual.size() >= 3 ? usual : all;
}

}  // namespace

void summarize(ErrorRow& row) {
  row.seeds = static_cast<int>(row.runs.size());
  if (row.runs.empty()) return;
  row.seconds = median_of(row.runs, &ErrorRun::wall_seconds);
  row.cpu_seconds = median_of(row.runs, &ErrorRun::cpu_seconds);
  row.build_seconds = median_of(row.runs, &ErrorRun::build_seconds);
  const auto all = first_numbers(row.runs.size());
  const double mse = mean_mse(row.runs, all);
  row.rmse = std::sqrt(mse);
  row.rmse_band = bootstrap_band(row.runs.size(), [&row](std::span<const uint32_t> picks) {
    return std::sqrt(mean_mse(row.runs, picks));
  });
  const auto inverse = [](double value) { return value > 0 ? 1 / value : 0; };
  row.efficiency = inverse(cost(row.runs, all));
  row.efficiency_band = bootstrap_band(row.runs.size(), [&](std::span<const uint32_t> picks) {
    return inverse(cost(row.runs, picks));
  });
}

void compare(ErrorRow& row, const ErrorRow& base) {
  const size_t seeds = std::min(row.runs.size(), base.runs.size());
  const auto ratio = [&](std::span<const uint32_t> picks) {
    const double own = cost(row.runs, picks);
    return own > 0 ? cost(base.runs, picks) / own : 0;
  };
  if (seeds == 0) return;
  row.gain = ratio(first_numbers(seeds));
  row.gain_band = bootstrap_band(seeds, ratio);
}

void fit_slope(ErrorCurve& curve) {
  const auto rows = fitted_rows(curve);
  if (rows.size() < 3) return;
  std::vector<double> x, y;
  for (const ErrorRow* row : rows) {
    x.push_back(std::log2(row->samples));
    y.push_back(std::log2(row->rmse));
  }
  curve.slope = fit_line(x, y).slope;
  // Rows are resampled each for itself: their seeds differ in number.
  Resampler resampler;
  std::vector<uint32_t> picks;
  std::vector<double> slopes;
  for (int i = 0; i < kResamples; ++i) {
    for (size_t k = 0; k < rows.size(); ++k) {
      resampler.draw(rows[k]->runs.size(), picks);
      y[k] = std::log2(std::max(mean_mse(rows[k]->runs, picks), 1e-300)) / 2;
    }
    slopes.push_back(fit_line(x, y).slope);
  }
  curve.slope_band = {percentile(slopes, .025), percentile(slopes, .975)};
}

std::optional<double> seconds_to(const ErrorCurve& curve, double target) {
  const ErrorRow* before = nullptr;
  for (const ErrorRow& row : curve.rows) {
    if (!(row.rmse > 0) || row.rmse <= target) {
      if (before == nullptr || !(row.rmse > 0)) return row.seconds;
      const double share = std::log(before->rmse / target) / std::log(before->rmse / row.rmse);
      return before->seconds * std::pow(row.seconds / before->seconds, share);
    }
    before = &row;
  }
  return std::nullopt;
}

}  // namespace tessera
