#include "proto/transport/resolve_host.h"

#include <netdb.h>

#include <algorithm>
#include <cerrno>
#include <cstring>
#include <future>
#include <memory>
#include <system_error>
#include <thread>
#include <utility>

#include "proto/transport/signals_blocked.h"
#include "proto/transport/socket_address.h"

namespace tessera {
namespace {

/// More are not tried; nobody has so many interfaces.
constexpr size_t kMostAddresses = 8;

/// The first one stays first; then the other family has its turn.
std::vector<std::string> alternated(std::vector<std::string> addresses) {
  const auto is_like_first = [first = addresses.front().front() == '['](const std::string& host) {
    return (host.front() == '[') == first;
  };
  const auto others = std::stable_partition(addresses.begin(), addresses.end(), is_like_first);
  std::vector<std::string> result;
  auto one = addresses.begin();
  for (auto other = others; one != others || other != addresses.end();) {
    if (one != others) result.push_back(*one++);
    if (other != addresses.end()) result.push_back(*other++);
  }
  if (result.size() > kMostAddresses) result.resize(kMostAddresses);
  return result;
}

}  // namespace

ResolvedHost resolve_by_system(const std::string& host) {
  if (host == "localhost") return {{"127.0.0.1", "[::1]"}};
  addrinfo hints{};
  hints.ai_socktype = SOCK_STREAM;
  addrinfo* found = nullptr;
  const int error = getaddrinfo(host.c_str(), nullptr, &hints, &found);
  if (error == EAI_NONAME || error == EAI_NODATA) return {.is_unknown = true};
  if (error == EAI_SYSTEM) return {.failure = std::strerror(errno)};
  if (error != 0) return {.failure = gai_strerror(error)};
  const std::unique_ptr<addrinfo, void (*)(addrinfo*)> owner(found, freeaddrinfo);
  std::vector<std::string> addresses;
  for (const addrinfo* each = found; each; each = each->ai_next) {
    SocketAddress address;
    std::memcpy(&address.storage, each->ai_addr, each->ai_addrlen);
    address.size = each->ai_addrlen;
    const std::string text = address.host();
    if (!text.empty() && std::ranges::find(addresses, text) == addresses.end()) {
      addresses.push_back(text);
    }
  }
  if (addresses.empty()) return {.is_unknown = true};
  return {alternated(std::move(addresses))};
}

void run_detached(std::function<void()> call) {
  const SignalsBlocked blocked;  // they are for the thread that serves
  std::thread(std::move(call)).detach();
}

ResolvedHost resolve_within(std::chrono::milliseconds limit, const std::string& host,
                            const ResolveHost& resolve) {
  const auto promise = std::make_shared<std::promise<ResolvedHost>>();
  std::future<ResolvedHost> answer = promise->get_future();
  try {
    run_detached([promise, host, resolve] { promise->set_value(resolve(host)); });
  } catch (const std::system_error& error) {
    return {.failure = error.what()};
  }
  if (answer.wait_for(limit) == std::future_status::ready) return answer.get();
  return {.failure = "no name server answers"};
}

}  // namespace tessera
