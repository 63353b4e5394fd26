#include <nlopt.h>

#include <cmath>
#include <memory>
#include <mutex>

#include "renderer/accel/split_search.h"

namespace tessera {
namespace {

constexpr unsigned long kSeed = 20180401;

struct Destroy {
  void operator()(nlopt_opt_s* o) const { nlopt_destroy(o); }
};
using Optimizer = std::unique_ptr<nlopt_opt_s, Destroy>;

struct Objective {
  double (*function)(const double* x, void* context);
  void* context;
};

double evaluate(unsigned, const double* x, double*, void* data) {
  const auto* objective = static_cast<const Objective*>(data);
  return objective->function(x, objective->context);
}

bool minimize(unsigned dimensions, const double* low, const double* high,
              double (*function)(const double* x, void* context), void* context,
              int max_evaluations, double* x) {
  // The generator is one for the whole library (or thread, as it was built).
  static std::mutex mutex;
  const std::lock_guard lock(mutex);
  nlopt_srand(kSeed);
  const Optimizer global(nlopt_create(NLOPT_G_MLSL, dimensions));
  const Optimizer local(nlopt_create(NLOPT_LN_SBPLX, dimensions));
  if (!global || !local) return false;
  nlopt_set_xtol_rel(local.get(), 1e-3);
  Objective objective{function, context};
  const bool ready = nlopt_set_min_objective(global.get(), evaluate, &objective) > 0 &&
                     nlopt_set_lower_bounds(global.get(), low) > 0 &&
                     nlopt_set_upper_bounds(global.get(), high) > 0 &&
                     nlopt_set_maxeval(global.get(), max_evaluations) > 0 &&
                     nlopt_set_local_optimizer(global.get(), local.get()) > 0;
  double value = 0;
  if (!ready || nlopt_optimize(global.get(), x, &value) < 0) return false;
  for (unsigned i = 0; i < dimensions; ++i)
    if (!(x[i] >= low[i] && x[i] <= high[i])) return false;
  return std::isfinite(value);
}

}  // namespace
}  // namespace tessera

extern "C" __attribute__((visibility("default"))) tessera::NloptMinimize tessera_nlopt_module(
    uint32_t version) {
  return version == tessera::kNloptModuleVersion ? tessera::minimize : nullptr;
}
