#pragma once

#include <sys/resource.h>
#include <unistd.h>

#include <fstream>

#include "tests/sanitizers.h"

namespace tessera {

/// While it lives this process gets no more than so many bytes of address space beside those that
/// it has: allocations fail, as if there were no memory.
class AddressSpaceLimit {
 public:
  explicit AddressSpaceLimit(rlim_t more) {
    rlim_t pages = 0;
    std::ifstream("/proc/self/statm") >> pages;
    getrlimit(RLIMIT_AS, &before_);
    rlimit small = before_;
    small.rlim_cur = pages * static_cast<rlim_t>(sysconf(_SC_PAGESIZE)) + more;
    setrlimit(RLIMIT_AS, &small);
  }
  ~AddressSpaceLimit() { setrlimit(RLIMIT_AS, &before_); }
  AddressSpaceLimit(const AddressSpaceLimit&) = delete;
  AddressSpaceLimit& operator=(const AddressSpaceLimit&) = delete;

  static constexpr bool kWorks = !kSanitized;
  static constexpr auto kWhyNot = "a sanitizer's own memory would be refused too";

 private:
  rlimit before_{};
};

}  // namespace tessera
