#include "coordinator/web/farm_page.h"

#include <fmt/format.h>

#include "base/error.h"
#include "coordinator/web/farm_monitor.h"
#include "coordinator/web/web_api.h"
#include "web/web_server.h"

namespace tessera {
namespace {

WebAccess access_for(const FarmPage::Options& options) {
  if (!options.token_file.empty()) return WebAccess::read(options.token_file);
  if (!WebServer::is_loopback(options.address)) {
    throw usage_error(
        fmt::format("--http: '{}' can be reached by other machines; expected --http-token beside "
                    "it, or 127.0.0.1",
                    options.address));
  }
  if (options.has_keys) {
    throw usage_error(
        "--http: needs --http-token beside it where --key is given: what is let in "
        "by keys is not to be seen without");
  }
  return {};
}

}  // namespace

FarmPage::FarmPage(const Options& options)
    : monitor_(std::make_shared<FarmMonitor>()),
      token_file_(options.token_file),
      api_(std::make_unique<WebApi>(
          WebApi::Parts{monitor_, LogRing::attach(), access_for(options), options.stopping})),
      server_(std::make_unique<WebServer>(
          options.address, [this](const HttpRequest& request, const HttpReply& reply) {
            api_->handle(request, reply);
          })) {}

FarmPage::~FarmPage() = default;

void FarmPage::look(Coordinator& coordinator, Time now) { monitor_->look(coordinator, now); }

void FarmPage::read_tokens_again() { api_->set_access(WebAccess::read(token_file_)); }

std::string FarmPage::address() const { return server_->address(); }

}  // namespace tessera
