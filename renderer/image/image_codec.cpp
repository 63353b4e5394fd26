#include "renderer/image/image_codec.h"

#include <fcntl.h>
#include <fmt/format.h>
#include <spawn.h>
#include <sys/socket.h>
#include <sys/time.h>
#include <sys/wait.h>
#include <unistd.h>

#include <array>
#include <cerrno>
#include <csignal>
#include <cstring>
#include <filesystem>

#include "base/error.h"

namespace tessera {

namespace fs = std::filesystem;

namespace {

constexpr const char* kProgram = "tessera-image-codec";

fs::path find_program() {
  const fs::path folder = fs::read_symlink("/proc/self/exe").parent_path();
  for (const char* place : {"", "../libexec/tessera"}) {
    const fs::path file = folder / place / kProgram;
    if (access(file.c_str(), X_OK) == 0) return file;
  }
  throw render_error(fmt::format("cannot find the image codec '{}'; expected it in '{}'", kProgram,
                                 folder.string()));
}

/// Starts `program` with `socket` for its standard input, out of the terminal's Ctrl-C: whether a
/// picture is still written is for us to decide.
pid_t spawn(const fs::path& program, int socket) {
  posix_spawn_file_actions_t actions;
  posix_spawn_file_actions_init(&actions);
  posix_spawn_file_actions_adddup2(&actions, socket, STDIN_FILENO);
  posix_spawn_file_actions_addopen(&actions, STDOUT_FILENO, "/dev/null", O_WRONLY, 0);
  posix_spawnattr_t attributes;
  posix_spawnattr_init(&attributes);
  sigset_t none, all;
  sigemptyset(&none);
  sigfillset(&all);
  posix_spawnattr_setsigmask(&attributes, &none);
  posix_spawnattr_setsigdefault(&attributes, &all);
  posix_spawnattr_setpgroup(&attributes, 0);
  posix_spawnattr_setflags(&attributes,
                           POSIX_SPAWN_SETSIGMASK | POSIX_SPAWN_SETSIGDEF | POSIX_SPAWN_SETPGROUP);
  std::string name = kProgram;
  char* const arguments[] = {name.data(), nullptr};
  pid_t process = 0;
  const int error =
      posix_spawn(&process, program.c_str(), &actions, &attributes, arguments, environ);
  posix_spawnattr_destroy(&attributes);
  posix_spawn_file_actions_destroy(&actions);
  if (error != 0) {
    throw render_error(fmt::format("cannot start the image codec '{}': {}", program.string(),
                                   std::strerror(error)));
  }
  return process;
}

}  // namespace

ImageCodec& ImageCodec::shared() {
  static ImageCodec codec;
  return codec;
}

ImageCodec::~ImageCodec() {
  if (process_) end_locked();
}

void ImageCodec::start() {
  const std::lock_guard lock(mutex_);
  start_locked();
}

void ImageCodec::start_locked() {
  if (process_) return;
  std::array<int, 2> ends{};
  if (socketpair(AF_UNIX, SOCK_STREAM | SOCK_CLOEXEC, 0, ends.data()) != 0) {
    throw render_error(fmt::format("cannot start the image codec: {}", std::strerror(errno)));
  }
  try {
    process_ = spawn(find_program(), ends[1]);
  } catch (...) {
    close(ends[0]);
    close(ends[1]);
    throw;
  }
  close(ends[1]);
  socket_ = ends[0];
  const timeval patience{.tv_sec = 0, .tv_usec = 250'000};
  setsockopt(socket_, SOL_SOCKET, SO_RCVTIMEO, &patience, sizeof patience);
  setsockopt(socket_, SOL_SOCKET, SO_SNDTIMEO, &patience, sizeof patience);
}

std::string ImageCodec::end_locked() {
  // It has nothing of its own to lose, and may still be loading.
  close(socket_);
  kill(process_, SIGKILL);
  int status = 0;
  while (waitpid(process_, &status, 0) < 0 && errno == EINTR) {
  }
  process_ = 0;
  return WIFSIGNALED(status) ? fmt::format("signal {}", WTERMSIG(status))
                             : fmt::format("exit code {}", WEXITSTATUS(status));
}

std::optional<ImageCodec::Answer> ImageCodec::try_call(const ImageRequest& request,
                                                       std::string_view payload) {
  start_locked();
  // A process that something has stopped would keep a finished picture waiting for good.
  ImageChannel channel(socket_, [this] {
    siginfo_t news{};
    constexpr int kAsk = WEXITED | WSTOPPED | WNOHANG | WNOWAIT;
    return waitid(P_PID, static_cast<id_t>(process_), &news, kAsk) == 0 && news.si_pid == 0;
  });
  ImageReply reply;
  if (!channel.send(request, payload) || !channel.receive(reply)) return std::nullopt;
  Answer answer{reply.layout, std::vector<std::byte>(reply.payload_bytes)};
  if (!channel.receive_bytes(answer.payload.data(), answer.payload.size())) return std::nullopt;
  if (!reply.done) {
    throw render_error(
        std::string(reinterpret_cast<const char*>(answer.payload.data()), answer.payload.size()));
  }
  return answer;
}

ImageCodec::Answer ImageCodec::call(ImageRequest request, std::string_view payload) {
  const std::lock_guard lock(mutex_);
  request.payload_bytes = payload.size();
  // Who ended the process the first time may not have meant this file.
  std::string how;
  for (int attempt = 0; attempt < 2; ++attempt) {
    if (auto answer = try_call(request, payload)) return *std::move(answer);
    how = end_locked();
  }
  throw render_error(fmt::format("the image codec ended over it with {}", how));
}

}  // namespace tessera
