#pragma once

#include <algorithm>
#include <cstdint>
#include <initializer_list>
#include <string>
#include <string_view>
#include <vector>

#include "base/error.h"

// For sources that are compiled once for each instruction set, before Highway's headers. The sets
// named here add nothing that we use.
#define HWY_DISABLED_TARGETS (HWY_SSSE3 | HWY_AVX3_DL)
#include <hwy/detect_targets.h>
#include <hwy/targets.h>

namespace tessera {

// Highway's own dispatch lies in a library whose loading measures the clock for 3 ms, as long as
// all else that a worker does before it is ready. So only its headers are used.

/// What was compiled for one instruction set, of Highway's `target` bits.
template <typename Code>
struct TargetCode {
  int64_t target;
  Code code;
};
template <typename Code>
TargetCode<Code> target_code(int64_t target, Code code) {
  return {target, code};
}

/// Whether this machine has all that the compiler may use for it.
inline bool machine_has(int64_t target) {
  if (target == HWY_STATIC_TARGET) return true;  // all else is compiled for it too
#if HWY_ARCH_X86
  __builtin_cpu_init();
  if (target == HWY_AVX3) {
    return __builtin_cpu_supports("avx512f") && __builtin_cpu_supports("avx512vl") &&
           __builtin_cpu_supports("avx512dq") && __builtin_cpu_supports("avx512bw") &&
           __builtin_cpu_supports("avx512cd");
  }
  if (target == HWY_AVX2) {
    return __builtin_cpu_supports("avx2") && __builtin_cpu_supports("fma") &&
           __builtin_cpu_supports("bmi") && __builtin_cpu_supports("bmi2");
  }
  if (target == HWY_SSE4) return __builtin_cpu_supports("sse4.2");
#endif
  return false;
}

/// What was compiled for the instruction sets that this machine has, the best first.
template <typename Code>
std::vector<Code> codes_of_machine(std::initializer_list<TargetCode<Code>> each) {
  std::vector<Code> codes;
  for (const auto& [target, code] : each)
    if (machine_has(target)) codes.push_back(code);
  return codes;
}
template <typename Code>
Code best_code_of_machine(std::initializer_list<TargetCode<Code>> each) {
  return codes_of_machine(each).front();
}

/// That of the instruction set that Highway calls `name`; any other name is refused by a check.
template <typename Code>
Code code_of_target(std::initializer_list<TargetCode<Code>> each, std::string_view name) {
  const auto found = std::ranges::find(
      each, name, [](const auto& of) { return std::string_view(hwy::TargetName(of.target)); });
  TESSERA_CHECK(found != each.end(), std::string(name));
  return found->code;
}

}  // namespace tessera

// Each with the comma behind it, or nothing where the compiler has not that set.
#if HWY_TARGETS & HWY_AVX3
#define TESSERA_AVX3_CODE(function) ::tessera::target_code(HWY_AVX3, &N_AVX3::function),
#else
#define TESSERA_AVX3_CODE(function)
#endif
#if HWY_TARGETS & HWY_AVX2
#define TESSERA_AVX2_CODE(function) ::tessera::target_code(HWY_AVX2, &N_AVX2::function),
#else
#define TESSERA_AVX2_CODE(function)
#endif
#if HWY_TARGETS & HWY_SSE4
#define TESSERA_SSE4_CODE(function) ::tessera::target_code(HWY_SSE4, &N_SSE4::function),
#else
#define TESSERA_SSE4_CODE(function)
#endif
#define TESSERA_STATIC_CODE(function) \
  ::tessera::target_code(HWY_STATIC_TARGET, &HWY_STATIC_DISPATCH(function))

/// A list of the TargetCode of `function`, which stands in HWY_NAMESPACE: the best set first, the
/// one that all else is compiled for last.
#define TESSERA_EACH_TARGET(function)                                                     \
  {                                                                                       \
    TESSERA_AVX3_CODE(function)                                                           \
    TESSERA_AVX2_CODE(function) TESSERA_SSE4_CODE(function) TESSERA_STATIC_CODE(function) \
  }
