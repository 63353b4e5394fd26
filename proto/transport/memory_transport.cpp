#include "proto/transport/memory_transport.h"

#include <condition_variable>
#include <deque>
#include <map>
#include <mutex>
#include <utility>

#include "base/error.h"

namespace tessera {

/// Messages on their way to one end.
struct Mailbox {
  std::deque<ReceivedMessage> control, bulk;
  std::condition_variable changed;
  bool woken = false;

  bool empty() const { return control.empty() && bulk.empty(); }
  void put(Channel channel, PeerId peer, MessageBytes bytes) {
    const auto owner = std::make_shared<const MessageBytes>(std::move(bytes));
    ReceivedMessage message;
    message.channel = channel;
    message.peer = std::move(peer);
    message.bytes = *owner;
    message.owner = owner;
    (channel == Channel::control ? control : bulk).push_back(std::move(message));
    changed.notify_one();
  }
  std::optional<ReceivedMessage> take() {
    std::deque<ReceivedMessage>& queue = control.empty() ? bulk : control;
    if (queue.empty()) return std::nullopt;
    ReceivedMessage message = std::move(queue.front());
    queue.pop_front();
    return message;
  }
  void wake() {
    woken = true;
    changed.notify_one();
  }
  void wait(std::unique_lock<std::mutex>& lock, std::chrono::milliseconds timeout) {
    changed.wait_for(lock, timeout, [this] { return woken || !empty(); });
    woken = false;
  }
};

struct MemoryNetwork::State {
  std::mutex mutex;
  Mailbox server;
  std::map<PeerId, Mailbox> clients;
  uint64_t names = 0;
  bool has_server = false;

  PeerId enter() {
    const std::lock_guard lock(mutex);
    const PeerId name = "memory-" + std::to_string(++names);
    clients[name];
    return name;
  }
  void leave(const PeerId& name) {
    const std::lock_guard lock(mutex);
    clients.erase(name);
  }

  class Server;
  class Client;
};

class MemoryNetwork::State::Server final : public ServerTransport {
 public:
  explicit Server(std::shared_ptr<State> state) : state_(std::move(state)) {}
  std::string endpoint() const override { return "memory"; }
  std::string bulk_endpoint() const override { return {}; }
  void wait(std::chrono::milliseconds timeout) override {
    std::unique_lock lock(state_->mutex);
    state_->server.wait(lock, timeout);
  }
  std::optional<ReceivedMessage> receive() override {
    const std::lock_guard lock(state_->mutex);
    return state_->server.take();
  }
  SendResult send(Channel channel, const PeerId& peer, MessageBytes bytes) override {
    const std::lock_guard lock(state_->mutex);
    const auto it = state_->clients.find(peer);
    if (it == state_->clients.end()) return SendResult::gone;
    it->second.put(channel, {}, std::move(bytes));
    return SendResult::sent;
  }
  void wake() override {
    const std::lock_guard lock(state_->mutex);
    state_->server.wake();
  }

 private:
  std::shared_ptr<State> state_;
};

class MemoryNetwork::State::Client final : public ClientTransport {
 public:
  explicit Client(std::shared_ptr<State> state)
      : state_(std::move(state)), name_(state_->enter()) {}
  ~Client() override { state_->leave(name_); }
  Client(const Client&) = delete;
  Client& operator=(const Client&) = delete;

  void connect_bulk(const std::string&) override {}
  void wait(std::chrono::milliseconds timeout) override {
    std::unique_lock lock(state_->mutex);
    state_->clients.at(name_).wait(lock, timeout);
  }
  std::optional<ReceivedMessage> receive() override {
    const std::lock_guard lock(state_->mutex);
    return state_->clients.at(name_).take();
  }
  void send(Channel channel, MessageBytes bytes) override {
    const std::lock_guard lock(state_->mutex);
    state_->server.put(channel, name_, std::move(bytes));
  }
  void reconnect() override {}
  void wake() override {
    const std::lock_guard lock(state_->mutex);
    state_->clients.at(name_).wake();
  }

 private:
  std::shared_ptr<State> state_;
  PeerId name_;
};

MemoryNetwork::MemoryNetwork() : state_(std::make_shared<State>()) {}

std::unique_ptr<ServerTransport> MemoryNetwork::server() {
  TESSERA_CHECK(!std::exchange(state_->has_server, true), "a second server");
  return std::make_unique<State::Server>(state_);
}

std::unique_ptr<ClientTransport> MemoryNetwork::client() {
  return std::make_unique<State::Client>(state_);
}

}  // namespace tessera
