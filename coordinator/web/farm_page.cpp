#include "coordinator/web/farm_page.h"

#include <fmt/format.h>

#include "base/error.h"
#include "coordinator/web/farm_monitor.h"
#include "coordinator/web/web_api.h"
#include "web/web_server.h"

namespace tessera {
namespace {

WebAccess access_for(const FarmPage::Options& options) {
  const auto& proxy = options.public_address;
  WebAccess access;
  if (!options.token_file.empty()) {
    access = WebAccess::read(options.token_file);
  } else if (!WebServer::is_loopback(options.address)) {
    throw usage_error(
        fmt::format("--http: '{}' can be reached by other machines; expected --http-token beside "
                    "it, or 127.0.0.1",
                    options.address));
  } else if (proxy && !names_this_machine(proxy->host)) {
    throw usage_error(
        fmt::format("--http-origin: '{}' can be reached by other machines; expected --http-token "
                    "beside it",
                    proxy->url));
  } else if (options.has_keys) {
    throw usage_error(
        "--http: needs --http-token beside it where --key is given: what is let in "
        "by keys is not to be seen without");
  }
  access.set_public_address(proxy);
  return access;
}

}  // namespace

FarmPage::FarmPage(const Options& options)
    : monitor_(std::make_shared<FarmMonitor>()),
      options_(options),
      api_(std::make_unique<WebApi>(
          WebApi::Parts{monitor_, LogRing::attach(), access_for(options), options.stopping})),
      server_(std::make_unique<WebServer>(
          options.address, [this](const HttpRequest& request, const HttpReply& reply) {
            api_->handle(request, reply);
          })) {}

FarmPage::~FarmPage() = default;

void FarmPage::look(Coordinator& coordinator, Time now) { monitor_->look(coordinator, now); }

void FarmPage::read_tokens_again() { api_->set_access(access_for(options_)); }

std::string FarmPage::address() const { return server_->address(); }

std::string FarmPage::url() const {
  return options_.public_address ? options_.public_address->url
                                 : fmt::format("http://{}/", server_->address());
}

}  // namespace tessera
