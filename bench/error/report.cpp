#include "bench/error/report.h"

#include <fmt/format.h>

#include <algorithm>
#include <nlohmann/json.hpp>

#include "bench/error/log_plot.h"

namespace tessera {
namespace {

using Json = nlohmann::ordered_json;

Json band(const Band& band) { return Json::array({band.low, band.high}); }

/// All of a row that is one number, under its name.
Json to_json(const SceneErrors& scene, const ErrorCurve& curve, const ErrorRow& row) {
  Json out{{"scene", scene.scene},
           {"method", curve.method},
           {"samples", row.samples},
           {"seconds", row.seconds},
           {"rmse", row.rmse},
           {"bias", row.bias},
           {"seeds", row.seeds},
           {"cpu_seconds", row.cpu_seconds},
           {"build_seconds", row.build_seconds},
           {"rmse_low", row.rmse_band.low},
           {"rmse_high", row.rmse_band.high},
           {"bias_sigmas", row.bias_sigmas},
           {"rel_mse", row.error.rel_mse},
           {"trimmed_rel_mse", row.error.trimmed_rel_mse},
           {"smape", row.error.smape},
           {"flip", row.error.flip},
           {"max_error", row.error.max_error},
           {"error_99_9", row.error.error_99_9},
           {"mean_ratio", row.error.mean_ratio},
           {"not_finite", row.not_finite},
           {"efficiency", row.efficiency},
           {"efficiency_low", row.efficiency_band.low},
           {"efficiency_high", row.efficiency_band.high}};
  out["gain"] = row.gain ? Json(*row.gain) : Json();
  out["gain_low"] = row.gain ? Json(row.gain_band.low) : Json();
  out["gain_high"] = row.gain ? Json(row.gain_band.high) : Json();
  out["width"] = scene.width;
  out["height"] = scene.height;
  return out;
}

std::vector<Json> all_rows(const std::vector<SceneErrors>& scenes) {
  std::vector<Json> out;
  for (const SceneErrors& scene : scenes)
    for (const ErrorCurve& curve : scene.curves)
      for (const ErrorRow& row : curve.rows) out.push_back(to_json(scene, curve, row));
  return out;
}

/// The value as a cell of a CSV file.
std::string csv_cell(const Json& value) {
  if (value.is_null()) return "";
  if (!value.is_string()) return value.dump();
  std::string quoted = "\"";
  for (const char c : value.get<std::string>()) quoted += c == '"' ? "\"\"" : std::string(1, c);
  return quoted + "\"";
}

std::string gain_text(const ErrorRow& row) {
  if (!row.gain) return "";
  return fmt::format("{:.2f} [{:.2f}, {:.2f}]", *row.gain, row.gain_band.low, row.gain_band.high);
}

std::string slope_text(const ErrorCurve& curve) {
  if (!(curve.slope_band.low < curve.slope_band.high)) return "-";
  return fmt::format("{:.2f} [{:.2f}, {:.2f}]", curve.slope, curve.slope_band.low,
                     curve.slope_band.high);
}

std::string size_note(const SceneErrors& scene) {
  return fmt::format("{}x{} pixels; bands: 95 % over seeds", scene.width, scene.height);
}

PlotSeries series_of(const ErrorCurve& curve, double ErrorRow::*value, Band ErrorRow::*its_band) {
  PlotSeries out{curve.method, {}};
  for (const ErrorRow& row : curve.rows)
    out.points.push_back({row.seconds, row.*value, row.*its_band});
  return out;
}

}  // namespace

std::string error_table(const SceneErrors& scene) {
  std::string text = fmt::format("\n{}: {} ({}x{})\nreference: {}\n", scene.scene, scene.about,
                                 scene.width, scene.height, scene.reference);
  text += fmt::format("{:28} {:>7} {:>5} {:>9} {:>9} {:>21} {:>9} {:>6} {:>9} {:>6} {:>9}  {}\n",
                      "method", "samples", "seeds", "seconds", "rmse", "95 %", "bias", "sigmas",
                      "relMSE", "FLIP", "1/MSE/s", "gain [95 %]");
  for (const ErrorCurve& curve : scene.curves) {
    for (const ErrorRow& r : curve.rows)
      text += fmt::format(
          "{:28} {:7.4g} {:5} {:9.4f} {:9.3g} {:>21} {:9.2g} {:6.1f} {:9.3g} {:6.3f} {:9.3g}  "
          "{}{}\n",
          curve.method, r.samples, r.seeds, r.seconds, r.rmse,
          fmt::format("[{:.3g}, {:.3g}]", r.rmse_band.low, r.rmse_band.high), r.bias, r.bias_sigmas,
          r.error.rel_mse, r.error.flip, r.efficiency, gain_text(r),
          r.not_finite > 0 ? fmt::format("  {} not finite", r.not_finite) : "");
    if (!curve.end.empty()) text += fmt::format("{:28} ends here: {}\n", curve.method, curve.end);
    if (slope_text(curve) != "-")
      text += fmt::format("{:28} slope of RMSE over samples {}\n", curve.method, slope_text(curve));
  }
  for (const PeerMark& p : scene.peers)
    text += fmt::format(
        "{:28} {:7.4g} {:>5} {:9.4f} {:9.3g} mean {:.4f} of the reference's, rmse {:.3g} with the "
        "reference's mean\n",
        p.name, p.samples, "peer", p.seconds, p.error.rmse, p.error.mean_ratio, p.rmse_scaled);
  return text;
}

std::string error_json(const std::vector<SceneErrors>& scenes) {
  Json curves = Json::array(), peers = Json::array();
  for (const SceneErrors& scene : scenes) {
    for (const ErrorCurve& curve : scene.curves)
      curves.push_back({{"scene", scene.scene},
                        {"method", curve.method},
                        {"slope", curve.slope},
                        {"slope_band", band(curve.slope_band)},
                        {"reference", scene.reference},
                        {"reference_error", scene.reference_error}});
    for (const PeerMark& p : scene.peers)
      peers.push_back({{"scene", scene.scene},
                       {"method", p.name},
                       {"samples", p.samples},
                       {"seconds", p.seconds},
                       {"rmse", p.error.rmse},
                       {"rmse_scaled", p.rmse_scaled},
                       {"mean_ratio", p.error.mean_ratio},
                       {"rel_mse", p.error.rel_mse},
                       {"smape", p.error.smape},
                       {"flip", p.error.flip}});
  }
  return Json{{"rows", all_rows(scenes)}, {"curves", curves}, {"peers", peers}}.dump(2) + "\n";
}

std::string error_csv(const std::vector<SceneErrors>& scenes) {
  std::string text;
  for (const Json& row : all_rows(scenes)) {
    std::vector<std::string> names, cells;
    for (const auto& [name, value] : row.items()) {
      names.push_back(name);
      cells.push_back(csv_cell(value));
    }
    if (text.empty()) text = fmt::format("{}\n", fmt::join(names, ","));
    text += fmt::format("{}\n", fmt::join(cells, ","));
  }
  return text;
}

std::string error_summary(const std::vector<SceneErrors>& scenes) {
  std::string text =
      "| scene | method | s/Mpixel to 1/64 | s/Mpixel to 1/256 | slope [95 %] | gain at most "
      "samples [95 %] |\n|---|---|---|---|---|---|\n";
  for (const SceneErrors& scene : scenes) {
    for (const ErrorCurve& curve : scene.curves) {
      const auto seconds = [&](double target) -> std::string {
        const auto found = seconds_to(curve, target);
        return found ? fmt::format("{:.3g}", *found * 1e6 / (scene.width * scene.height)) : "-";
      };
      text += fmt::format("| {} | {} | {} | {} | {} | {} |\n", scene.scene, curve.method,
                          seconds(1. / 64), seconds(1. / 256), slope_text(curve),
                          curve.rows.empty() ? "" : gain_text(curve.rows.back()));
    }
  }
  return text;
}

std::string error_svg(const SceneErrors& scene) {
  LogPlot plot{scene.scene + ": error against time",
               size_note(scene),
               scene.clock,
               "root mean square error",
               {},
               {-.5, -.75, -1.5},
               scene.reference_error,
               "error of the reference"};
  for (const ErrorCurve& curve : scene.curves)
    plot.series.push_back(series_of(curve, &ErrorRow::rmse, &ErrorRow::rmse_band));
  for (const PeerMark& peer : scene.peers) {  // of one name, one colour
    const PlotPoint point{peer.seconds, peer.rmse_scaled, {}};
    const auto known = std::find_if(plot.series.begin(), plot.series.end(), [&](const auto& s) {
      return s.is_mark && s.name == peer.name;
    });
    if (known == plot.series.end()) {
      plot.series.push_back({peer.name, {point}, true});
    } else {
      known->points.push_back(point);
    }
  }
  return to_svg(plot);
}

std::string efficiency_svg(const SceneErrors& scene) {
  LogPlot plot{scene.scene + ": efficiency against time",
               size_note(scene),
               scene.clock,
               "1 / (MSE x seconds)",
               {},
               {},
               0,
               ""};
  for (const ErrorCurve& curve : scene.curves)
    plot.series.push_back(series_of(curve, &ErrorRow::efficiency, &ErrorRow::efficiency_band));
  return to_svg(plot);
}

}  // namespace tessera
