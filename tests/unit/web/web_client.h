#pragma once

#include <arpa/inet.h>
#include <netinet/in.h>
#include <sys/socket.h>
#include <sys/time.h>
#include <unistd.h>

#include <string>

namespace tessera::testing {

/// A connection to a server of this machine, by hand.
class WebClient {
 public:
  /// `address`: "127.0.0.1:PORT".
  explicit WebClient(const std::string& address) {
    sockaddr_in to{};
    to.sin_family = AF_INET;
    to.sin_port = htons(static_cast<uint16_t>(std::stoi(address.substr(address.find(':') + 1))));
    to.sin_addr.s_addr = htonl(INADDR_LOOPBACK);
    socket_ = socket(AF_INET, SOCK_STREAM, 0);
    const timeval patience{30, 0};
    setsockopt(socket_, SOL_SOCKET, SO_RCVTIMEO, &patience, sizeof patience);
    connected_ = connect(socket_, reinterpret_cast<const sockaddr*>(&to), sizeof to) == 0;
  }
  ~WebClient() { close(socket_); }
  WebClient(const WebClient&) = delete;
  WebClient& operator=(const WebClient&) = delete;

  bool connected() const { return connected_; }
  void send(const std::string& text) { ::send(socket_, text.data(), text.size(), MSG_NOSIGNAL); }
  /// What comes until the server closes, or 30 s are over.
  std::string receive_all() {
    std::string all;
    char part[4096];
    ssize_t size = 0;
    while ((size = recv(socket_, part, sizeof part, 0)) > 0) {
      all.append(part, static_cast<size_t>(size));
    }
    was_closed_ = size == 0;
    return all;
  }
  /// Whether that was since the server closed.
  bool was_closed() const { return was_closed_; }
  /// The whole answer to one request; further ones may follow.
  std::string receive_one() {
    std::string all;
    char byte;
    while (!all.ends_with("\r\n\r\n") && recv(socket_, &byte, 1, 0) == 1) all += byte;
    const size_t length = all.find("Content-Length: ");
    if (length == std::string::npos) return all;
    const size_t end = all.size() + std::stoul(all.substr(length + 16));
    while (all.size() < end && recv(socket_, &byte, 1, 0) == 1) all += byte;
    return all;
  }

 private:
  int socket_ = -1;
  bool connected_ = false, was_closed_ = false;
};

inline std::string get_request(const std::string& path, const std::string& more = "") {
  return "GET " + path + " HTTP/1.1\r\nHost: localhost\r\n" + more + "\r\n";
}

/// One request, and the whole answer to it.
inline std::string fetch(const std::string& address, const std::string& path,
                         const std::string& more = "") {
  WebClient client(address);
  client.send(get_request(path, more + "Connection: close\r\n"));
  return client.receive_all();
}

}  // namespace tessera::testing
