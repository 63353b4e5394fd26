#include <fmt/format.h>

#include <nlohmann/json.hpp>

#include "bench/precision.h"

namespace tessera {

std::string precision_table(const std::vector<PrecisionBenchRow>& rows) {
  std::string text = fmt::format("{:9} {:24} {:>9} {:>8} {:>10} {:>10} {:>9} {:>9} {:>10}\n",
                                 "shape", "method", "distance", "ns/test", "rms error", "max error",
                                 "wrong/M", "leaks/M", "self-hit/M");
  for (const PrecisionBenchRow& r : rows)
    text += fmt::format("{:9} {:24} {:9.0e} {:8.1f} {:10.1e} {:10.1e} {:9.0f} {:9.0f} {:10.0f}\n",
                        r.shape, r.method, r.distance, r.nanoseconds, r.rms_error, r.max_error,
                        r.wrong, r.leaks, r.self_hits);
  return text;
}

std::string precision_json(const std::vector<PrecisionBenchRow>& rows) {
  nlohmann::ordered_json list = nlohmann::ordered_json::array();
  for (const PrecisionBenchRow& r : rows)
    list.push_back({{"shape", r.shape},
                    {"method", r.method},
                    {"distance", r.distance},
                    {"nanoseconds", r.nanoseconds},
                    {"rms_error", r.rms_error},
                    {"max_error", r.max_error},
                    {"wrong_per_million", r.wrong},
                    {"leaks_per_million", r.leaks},
                    {"self_hits_per_million", r.self_hits}});
  return nlohmann::ordered_json{{"rows", list}}.dump(2) + "\n";
}

}  // namespace tessera
