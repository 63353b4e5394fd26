#include "renderer/accel/split_search.h"

#include <dlfcn.h>
#include <fmt/format.h>

#include <algorithm>
#include <string>

#include "base/error.h"
#include "base/program_folder.h"

namespace tessera {
namespace {

double weigh(const AxisStretch& axis, float split, size_t left, size_t right) {
  const double width = double{axis.high} - axis.low;
  const double b = width > 0 ? (double{split} - axis.low) / width : 0.5;
  return b * static_cast<double>(left) + (1 - b) * static_cast<double>(right);
}

struct Best {
  double cost;
  float split;
  /// Of equal costs the first counts.
  void offer(double other_cost, float other_split) {
    if (other_cost < cost) *this = {other_cost, other_split};
  }
};

/// Tries each end of an object inside the search stretch, and the stretch's own ends.
float sweep(const AxisStretch& axis) {
  std::vector<float> lows, highs, places{axis.search_low, axis.search_high};
  size_t begun_before = 0, ended_before = 0;
  const auto sort_in = [&](const std::vector<float>& ends, std::vector<float>& inside,
                           size_t& before) {
    for (const float x : ends) {
      if (x < axis.search_low)
        ++before;
      else if (x <= axis.search_high)
        inside.push_back(x);
    }
    std::sort(inside.begin(), inside.end());
  };
  sort_in(axis.lows, lows, begun_before);
  sort_in(axis.highs, highs, ended_before);
  places.insert(places.end(), lows.begin(), lows.end());
  places.insert(places.end(), highs.begin(), highs.end());
  std::sort(places.begin(), places.end());
  Best best{std::numeric_limits<double>::infinity(), axis.search_low};
  size_t begun = 0, ended = 0;
  for (const float at : places) {
    while (begun < lows.size() && lows[begun] < at) ++begun;
    while (ended < highs.size() && highs[ended] <= at) ++ended;
    best.offer(weigh(axis, at, begun_before + begun, axis.highs.size() - ended_before - ended), at);
  }
  return best.split;
}

/// Tries places at even distances, by counting the ends between them.
float sample(const AxisStretch& axis) {
  constexpr size_t kPlaces = SweepSearch::kPlaces;
  const double base = axis.search_low, width = double{axis.search_high} - base;
  std::vector<size_t> begun(kPlaces + 1), ended(kPlaces + 1);
  const auto place = [&](float x) {
    const double at = (x - base) / width * static_cast<double>(kPlaces - 1);
    return static_cast<size_t>(std::max(0.0, std::min(at + 1, static_cast<double>(kPlaces))));
  };
  for (const float x : axis.lows) ++begun[place(x)];
  for (const float x : axis.highs) ++ended[place(x)];
  Best best{std::numeric_limits<double>::infinity(), axis.search_low};
  size_t left = 0, right = axis.highs.size();
  for (size_t i = 0; i < kPlaces; ++i) {
    left += begun[i];
    right -= ended[i];
    const double at = base + width * static_cast<double>(i) / static_cast<double>(kPlaces - 1);
    const float split = std::min(static_cast<float>(at), axis.search_high);
    best.offer(weigh(axis, split, left, right), split);
  }
  return best.split;
}

class NloptSearch final : public SplitSearch {
 public:
  explicit NloptSearch(NloptMinimize minimize) : minimize_(minimize) {}

  std::array<float, 3> find(const std::array<AxisStretch, 3>& axes) const override {
    std::array<float, 3> split;
    Problem problem{&axes, {}, 0};
    std::array<double, 3> low, high, x;
    for (int a = 0; a < 3; ++a) {
      const AxisStretch& axis = axes[static_cast<size_t>(a)];
      split[static_cast<size_t>(a)] = axis.search_low;
      if (!(axis.search_low < axis.search_high)) continue;
      const size_t free = problem.free_axes++;
      problem.axis_of[free] = static_cast<size_t>(a);
      low[free] = axis.search_low;
      high[free] = axis.search_high;
      x[free] = low[free] + (high[free] - low[free]) / 2;
    }
    if (problem.free_axes == 0) return split;
    const auto evaluations = static_cast<int>(std::min<size_t>(axes[0].lows.size(), 100));
    if (minimize_(static_cast<unsigned>(problem.free_axes), low.data(), high.data(), product,
                  &problem, evaluations, x.data()))
      for (size_t i = 0; i < problem.free_axes; ++i)
        split[problem.axis_of[i]] = static_cast<float>(x[i]);
    return split;
  }

 private:
  struct Problem {
    const std::array<AxisStretch, 3>* axes;
    std::array<size_t, 3> axis_of;
    size_t free_axes;
  };

  static double product(const double* x, void* context) {
    const auto& problem = *static_cast<const Problem*>(context);
    double f = 1;
    for (size_t i = 0; i < problem.free_axes; ++i)
      f *= (*problem.axes)[problem.axis_of[i]].cost(static_cast<float>(x[i]));
    return f;
  }

  NloptMinimize minimize_;
};

NloptMinimize load_module() {
  const auto folder = program_folder();
  std::string cause;
  for (const char* place : {"tessera_nlopt.so", "../lib/tessera/tessera_nlopt.so"}) {
    const std::string file = (folder / place).string();
    void* const handle = dlopen(file.c_str(), RTLD_NOW | RTLD_LOCAL);
    if (!handle) {
      if (cause.empty()) cause = dlerror();
      continue;
    }
    const auto entry = reinterpret_cast<NloptModuleEntry>(dlsym(handle, kNloptModuleEntry));
    if (const NloptMinimize minimize = entry ? entry(kNloptModuleVersion) : nullptr)
      return minimize;
    cause = fmt::format("{} is of another version", file);
  }
  throw usage_error(fmt::format("the NLopt module can not be loaded: {}", cause));
}

}  // namespace

double AxisStretch::cost(float split) const {
  size_t left = 0, right = 0;
  for (const float x : lows) left += x < split ? 1 : 0;
  for (const float x : highs) right += x > split ? 1 : 0;
  return weigh(*this, split, left, right);
}

std::array<float, 3> SweepSearch::find(const std::array<AxisStretch, 3>& axes) const {
  std::array<float, 3> split;
  for (size_t a = 0; a < 3; ++a) {
    const AxisStretch& axis = axes[a];
    if (!(axis.search_low < axis.search_high))
      split[a] = axis.search_low;
    else
      split[a] = axis.lows.size() <= kExactObjects ? sweep(axis) : sample(axis);
  }
  return split;
}

std::unique_ptr<const SplitSearch> make_nlopt_search() {
  static const NloptMinimize minimize = load_module();
  return std::make_unique<NloptSearch>(minimize);
}

}  // namespace tessera
