#pragma once

#include <chrono>
#include <functional>
#include <string>
#include <vector>

namespace tessera {

/// What the name of a host stands for.
struct ResolvedHost {
  std::vector<std::string> addresses{};  ///< best first, as Endpoint::host spells them
  bool is_unknown = false;               ///< it is certain that there is no such host
  std::string failure{};                 ///< why nothing is certain, where there are no addresses
};

/// Resolves a name. May block for as long as it likes, and is called by threads that serve nothing
/// else, several at once where it is slow.
using ResolveHost = std::function<ResolvedHost(const std::string& host)>;

/// Asks the system: its list of hosts, and name servers. `localhost` is known without asking
/// (RFC 6761). The families of addresses alternate (RFC 8305, section 4).
ResolvedHost resolve_by_system(const std::string& host);

/// Runs `call` on a thread of its own, which nobody waits for and no signal reaches. Throws
/// std::system_error where there can be none.
void run_detached(std::function<void()> call);

/// Resolves a name on a thread of its own; a failure where that takes longer than `limit`.
ResolvedHost resolve_within(std::chrono::milliseconds limit, const std::string& host,
                            const ResolveHost& resolve = resolve_by_system);

}  // namespace tessera
