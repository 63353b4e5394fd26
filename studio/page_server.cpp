#include "studio/page_server.h"

#include <fmt/format.h>

#include <atomic>
#include <map>
#include <mutex>
#include <optional>
#include <utility>

#include "base/error.h"
#include "studio/studio_page.h"
#include "web/embedded_file.h"
#include "web/web_access.h"
#include "web/web_server.h"

namespace tessera {
namespace {

/// Of WebSocketLimits::queued_bytes.
constexpr size_t kMostQueuedPixels = size_t{8} << 20;
constexpr int kFirstPort = 7190, kPortsTried = 32;
constexpr std::string_view kPolicy =
    "default-src 'none'; script-src 'self'; connect-src 'self'; worker-src 'self'; "
    "img-src 'self' blob: data:; font-src 'self'; style-src 'self' 'nonce-{{nonce}}'; "
    "frame-ancestors 'none'; base-uri 'none'; form-action 'none'";

HttpResponse page_file(const HttpRequest& request) {
  if (request.method != "GET" && request.method != "HEAD") return http_error(405, "expected GET");
  const auto file = find_studio_page_file(request.path);
  if (!file) return http_error(404, "no such file");
  return request.path == "/" ? response_with_nonce(*file, kPolicy) : response_of(*file);
}

}  // namespace

class PageServer::Impl : public std::enable_shared_from_this<PageServer::Impl> {
 public:
  Impl(const Options& options, std::function<void(PageEvent)> take)
      : take_(std::move(take)), public_address_(options.public_address) {
    if (!options.token_file.empty()) {
      access_ = WebAccess::read(options.token_file);
    } else {
      if (!options.address.empty() && !WebServer::is_loopback(options.address)) {
        throw usage_error(fmt::format(
            "--http: '{}' can be reached by other machines; expected --http-token beside it, or "
            "127.0.0.1",
            options.address));
      }
      token_ = random_hex();
      access_ = WebAccess::of_token(token_, WebAccess::Role::submitter);
    }
    access_.set_public_address(public_address_);
  }
  void start(const std::string& address) {
    if (!address.empty()) {
      server_ = bind(address);
      return;
    }
    for (int i = 0;; ++i) {
      try {
        server_ = bind(fmt::format("127.0.0.1:{}", kFirstPort + i));
        return;
      } catch (const Error& error) {
        if (error.code() != ExitCode::try_again || i + 1 == kPortsTried) throw;
      }
    }
  }

  /// Whether pages come from this machine alone.
  bool is_local() const {
    return WebServer::is_loopback(server_->address()) &&
           (!public_address_ || names_this_machine(public_address_->host));
  }
  std::string url() const {
    return public_address_ ? public_address_->url : fmt::format("http://{}/", server_->address());
  }
  const WebAccess& access() const { return access_; }
  const WebServer& server() const { return *server_; }
  const std::string& token() const { return token_; }
  std::shared_ptr<WebSocket> socket_of(ClientId client) const {
    const std::lock_guard lock(mutex_);
    const auto at = pages_.find(client);
    return at == pages_.end() ? nullptr : at->second.socket;
  }
  /// Whoever is answered has said who they are.
  std::shared_ptr<WebSocket> socket_to_answer(ClientId client) {
    const std::lock_guard lock(mutex_);
    const auto at = pages_.find(client);
    if (at == pages_.end()) return nullptr;
    at->second.is_known = true;
    return at->second.socket;
  }
  bool is_known(ClientId client) const {
    const std::lock_guard lock(mutex_);
    const auto at = pages_.find(client);
    return at != pages_.end() && at->second.is_known;
  }
  /// Counts bytes of a page before it is known. Whether they may be taken.
  bool has_room_for(ClientId client, size_t bytes) {
    const std::lock_guard lock(mutex_);
    const auto at = pages_.find(client);
    if (at == pages_.end()) return false;
    Page& page = at->second;
    if (page.is_known) return true;
    page.unknown_bytes += bytes;
    return page.unknown_bytes <= StudioSession::kMostHelloBytes;
  }
  void stop() {
    stopping_ = true;
    server_.reset();
  }

 private:
  class Peer;
  struct Page {
    std::shared_ptr<WebSocket> socket;
    bool is_known = false;     ///< it was answered, which only happens once its token is known
    size_t unknown_bytes = 0;  ///< that came before
  };

  std::unique_ptr<WebServer> bind(const std::string& address) {
    // Weak: connections may outlive this by a moment.
    std::weak_ptr<Impl> weak = weak_from_this();
    WebSocketRoute route{
        .path = "/studio",
        .subprotocol = "tessera-studio.1",
        .refuse = [weak](const HttpRequest& request) -> std::optional<HttpResponse> {
          const auto self = weak.lock();
          return self ? self->access_.refuse_upgrade(request)
                      : std::optional(http_error(503, "ends"));
        },
        .make_peer = [weak](const HttpRequest&,
                            std::shared_ptr<WebSocket> socket) -> std::unique_ptr<WebSocketPeer> {
          const auto self = weak.lock();
          return self ? self->add(std::move(socket)) : nullptr;
        },
        .limits = {.connections = StudioSession::kMostClients,
                   .unknown = StudioSession::kMostUnknown}};
    return std::make_unique<WebServer>(
        address,
        [weak](const HttpRequest& request, const HttpReply& reply) {
          const auto self = weak.lock();
          if (!self) return;
          auto refused = self->access_.refuse_host(request);
          reply([response = refused ? *refused : page_file(request)] { return response; });
        },
        WebLimits{}, std::vector{std::move(route)});
  }

  std::unique_ptr<WebSocketPeer> add(std::shared_ptr<WebSocket> socket);
  void post(PageEvent event) {
    if (!stopping_) take_(std::move(event));
  }
  void remove(ClientId client) {
    {
      const std::lock_guard lock(mutex_);
      pages_.erase(client);
    }
    post({PageEvent::Kind::closed, client, {}});
  }

  std::function<void(PageEvent)> take_;
  std::optional<PublicAddress> public_address_;
  WebAccess access_;
  std::string token_;
  std::atomic<bool> stopping_{false};
  mutable std::mutex mutex_;
  std::map<ClientId, Page> pages_;
  ClientId last_client_ = 0;
  std::unique_ptr<WebServer> server_;
};

class PageServer::Impl::Peer : public WebSocketPeer {
 public:
  Peer(std::shared_ptr<Impl> server, ClientId client)
      : server_(std::move(server)), client_(client) {}

  void on_message(std::string_view message, bool binary) override {
    // Who sends this much before it is known is none of our pages; nothing of it is kept.
    if (!server_->has_room_for(client_, message.size())) {
      if (const auto socket = server_->socket_of(client_))
        socket->close(close_code::kNoToken, "expected hello");
      return;
    }
    const auto kind = binary ? PageEvent::Kind::binary : PageEvent::Kind::message;
    server_->post({kind, client_, std::string(message)});
  }
  void on_close() override { server_->remove(client_); }
  bool is_known() const override { return server_->is_known(client_); }

 private:
  std::shared_ptr<Impl> server_;
  ClientId client_;
};

std::unique_ptr<WebSocketPeer> PageServer::Impl::add(std::shared_ptr<WebSocket> socket) {
  ClientId client = 0;
  {
    const std::lock_guard lock(mutex_);
    client = ++last_client_;
    pages_.emplace(client, Page{.socket = std::move(socket)});
  }
  post({PageEvent::Kind::connected, client, {}});
  return std::make_unique<Peer>(shared_from_this(), client);
}

PageServer::PageServer(const Options& options, std::function<void(PageEvent)> take)
    : impl_(std::make_shared<Impl>(options, std::move(take))) {
  impl_->start(options.address);
}

PageServer::~PageServer() { impl_->stop(); }

std::string PageServer::address() const { return impl_->server().address(); }

std::string PageServer::url() const { return impl_->url(); }

bool PageServer::is_local() const { return impl_->is_local(); }

const std::string& PageServer::token() const { return impl_->token(); }

StudioRole PageServer::role_of(const std::string& token) const {
  const auto role = impl_->access().role_of(token);
  if (!role) return StudioRole::none;
  return *role == WebAccess::Role::submitter ? StudioRole::editor : StudioRole::viewer;
}

void PageServer::send(ClientId client, std::string text) {
  const auto socket = impl_->socket_to_answer(client);
  if (!socket) return;
  // A page that misses a message is no more what the program takes it for: it connects anew.
  if (!socket->send(std::make_shared<const std::string>(std::move(text)), false))
    socket->close(close_code::kTryLater, "the page takes too little");
}

void PageServer::close(ClientId client, uint16_t code, const std::string& reason) {
  if (const auto socket = impl_->socket_of(client)) socket->close(code, reason);
}

std::shared_ptr<PixelSink> PageServer::sink_of(ClientId client) const {
  class Sink : public PixelSink {
   public:
    explicit Sink(std::shared_ptr<WebSocket> socket) : socket_(std::move(socket)) {}
    bool send(std::shared_ptr<const std::string> frame) override {
      // The rest of the queue is for text, which is not dropped.
      if (socket_->queued_bytes() > kMostQueuedPixels) return !socket_->is_open();
      return socket_->send(std::move(frame), true) || !socket_->is_open();
    }

   private:
    std::shared_ptr<WebSocket> socket_;
  };
  auto socket = impl_->socket_of(client);
  if (!socket) return nullptr;
  return std::make_shared<Sink>(std::move(socket));
}

void PageServer::stop() { impl_->stop(); }

}  // namespace tessera
