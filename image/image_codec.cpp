#include "image/image_codec.h"

#include <fmt/format.h>
#include <sys/socket.h>
#include <sys/time.h>
#include <sys/wait.h>
#include <unistd.h>

#include <algorithm>
#include <array>
#include <atomic>
#include <cerrno>
#include <csignal>
#include <cstdlib>
#include <cstring>
#include <filesystem>
#include <memory>
#include <new>
#include <utility>
#include <vector>

#include "base/cancellation.h"
#include "base/log.h"
#include "base/process.h"
#include "base/program_folder.h"

namespace tessera {

namespace fs = std::filesystem;

namespace {

constexpr const char* kProgram = "tessera-image-codec";

fs::path find_program() {
  const fs::path folder = program_folder();
  for (const char* place : {"", "../libexec/tessera"}) {
    const fs::path file = folder / place / kProgram;
    if (access(file.c_str(), X_OK) == 0) return file;
  }
  throw render_error(fmt::format("cannot find the image codec '{}'; expected it in '{}'", kProgram,
                                 folder.string()));
}

/// What tells the configuration of OpenColorIO of now from another: its name, age and size.
std::string color_configuration() {
  const char* const named = std::getenv("OCIO");
  if (!named) return "";
  std::error_code none;  // where there is no such file, its name is all
  return fmt::format("{}\n{}\n{}", named,
                     fs::last_write_time(named, none).time_since_epoch().count(),
                     fs::file_size(named, none));
}

/// Whether the reply is of a size that such an answer may have.
bool is_plausible(const ImageRequest& request, const ImageReply& reply) {
  constexpr uint64_t kLongestCause = 64 * 1024;
  if (reply.names_bytes > (reply.done && request.decodes() ? PixelLayout::kLongestNames : 0))
    return false;
  if (!reply.done) return !reply.is_shared && reply.payload_bytes <= kLongestCause;
  if (request.call == ImageRequest::encode) {
    return reply.payload_bytes <= most_encoded_bytes(request.layout.bytes());
  }
  if (request.call == ImageRequest::decode_all) {
    return reply.layout.is_legal(PixelLayout::kMostChannels) &&
           reply.payload_bytes == reply.layout.bytes();
  }
  return reply.layout.is_legal() && reply.layout.bytes() == reply.payload_bytes;
}

std::vector<std::string> split_names(std::string_view all) {
  std::vector<std::string> names;
  while (!all.empty()) {
    names.emplace_back(all.substr(0, all.find('\0')));
    all.remove_prefix(std::min(all.size(), names.back().size() + 1));
  }
  return names;
}

}  // namespace

ImageCodec& ImageCodec::shared() {
  static ImageCodec codec(false);
  return codec;
}

ImageCodec& ImageCodec::for_colors() {
  static ImageCodec codec(true);
  return codec;
}

ImageCodec::~ImageCodec() {
  if (process_) end_locked();
}

void ImageCodec::check_installed() { find_program(); }

void ImageCodec::start(bool loads_all) {
  const std::lock_guard lock(mutex_);
  start_locked();
  if (!loads_all || std::exchange(loads_all_, true)) return;
  ImageRequest request;
  request.call = ImageRequest::load;
  // Where this fails, so will what is asked next, and say why.
  ImageChannel(socket_.get()).send(request, {});
}

void ImageCodec::start_locked() {
  siginfo_t news{};
  if (process_ &&
      waitid(P_PID, static_cast<id_t>(process_), &news, WEXITED | WNOHANG | WNOWAIT) == 0 &&
      news.si_pid == process_) {
    end_locked();
  }
  std::string configuration = converts_colors_ ? color_configuration() : "";
  // OpenColorIO reads it once in the life of a process.
  if (process_ && configuration != configuration_) end_locked();
  if (process_) return;
  configuration_ = std::move(configuration);
  std::array<int, 2> ends{};
  if (socketpair(AF_UNIX, SOCK_STREAM | SOCK_CLOEXEC, 0, ends.data()) != 0) {
    throw render_error(fmt::format("cannot start the image codec: {}", std::strerror(errno)));
  }
  OwnedDescriptor ours(ends[0]);
  const OwnedDescriptor theirs(ends[1]);
  std::vector<std::string> arguments{kProgram};
  if (converts_colors_) arguments.emplace_back(kConvertsColors);
  process_ = start_process(find_program().string(), std::move(arguments),
                           {.standard_input = theirs.get(), .discards_output = true});
  socket_ = std::move(ours);
  loads_all_ = false;
  const timeval patience{.tv_sec = 0, .tv_usec = 100'000};
  setsockopt(socket_.get(), SOL_SOCKET, SO_RCVTIMEO, &patience, sizeof patience);
  setsockopt(socket_.get(), SOL_SOCKET, SO_SNDTIMEO, &patience, sizeof patience);
}

int ImageCodec::end_locked() {
  // It has nothing of its own to lose, and may still be loading.
  socket_ = OwnedDescriptor();
  kill(process_, SIGKILL);
  return wait_for_process(std::exchange(process_, 0));
}

std::optional<ImageCodec::Answer> ImageCodec::try_call(const ImageRequest& request,
                                                       const Sending& send) {
  start_locked();
  // A process that something has stopped would keep a finished picture waiting for good.
  // Nor does one whose answer nobody wants any more work on.
  ImageChannel channel(socket_.get(), [this] {
    siginfo_t news{};
    constexpr int kAsk = WEXITED | WSTOPPED | WNOHANG | WNOWAIT;
    const std::atomic<bool>* const cancelled = Cancellation::current();
    return !(cancelled && *cancelled) &&
           waitid(P_PID, static_cast<id_t>(process_), &news, kAsk) == 0 && news.si_pid == 0;
  });
  if (!send(channel)) return std::nullopt;
  return receive_answer(channel, request);
}

std::optional<ImageCodec::Answer> ImageCodec::receive_answer(ImageChannel& channel,
                                                             const ImageRequest& request) {
  ImageReply reply;
  int descriptor = -1;
  const bool came = channel.receive(reply, descriptor);
  OwnedDescriptor memory(descriptor);
  if (!came || !is_plausible(request, reply)) return std::nullopt;
  tell_sandbox(reply);
  const SampleMeaning meaning{reply.from_integers != 0, reply.is_associated != 0};
  BlobData payload;
  if (reply.is_shared) {
    payload = Blob::map_sealed(std::move(memory), reply.payload_bytes);
    if (!payload) return std::nullopt;
  } else {
    std::vector<std::byte> bytes(reply.payload_bytes);
    if (!channel.receive_bytes(bytes.data(), bytes.size())) return std::nullopt;
    if (!reply.done) {
      throw Refusal(ExitCode::render_failed,
                    std::string(reinterpret_cast<const char*>(bytes.data()), bytes.size()));
    }
    payload = make_blob(std::move(bytes));
  }
  std::string names(reply.names_bytes, 0);
  if (!channel.receive_bytes(names.data(), names.size())) return std::nullopt;
  return Answer{reply.layout,
                std::move(payload),
                meaning,
                split_names(names),
                std::string(reply.part, strnlen(reply.part, sizeof reply.part)),
                std::string(reply.damage, strnlen(reply.damage, sizeof reply.damage)),
                reply.gamma};
}

void ImageCodec::tell_sandbox(const ImageReply& reply) {
  if (std::exchange(knows_sandbox_, true)) return;
  if (!reply.holds_files) {
    spdlog::debug("the kernel has no Landlock: the image codec may open the files that we may");
  }
  if (!reply.holds_calls) {
    spdlog::debug("the kernel takes no seccomp filter: the image codec may use the network");
  }
}

ImageCodec::Answer ImageCodec::call(ImageRequest request, std::string_view payload) {
  request.payload_bytes = payload.size();
  return call_by(request, [&](ImageChannel& channel) { return channel.send(request, payload); });
}

ImageCodec::Answer ImageCodec::decode(ImageRequest request, SealedMemory file) {
  request.payload_bytes = file.bytes().size();
  const int descriptor = file.seal();
  if (descriptor < 0) throw render_error(std::strerror(errno));
  return call_by(request, [&](ImageChannel& channel) { return channel.send(request, descriptor); });
}

ImageCodec::Answer ImageCodec::call_by(const ImageRequest& request, const Sending& send) {
  const std::lock_guard lock(mutex_);
  int status = 0;
  for (int attempt = 0; attempt < 3; ++attempt) {
    Cancellation::check();
    try {
      if (auto answer = try_call(request, send)) return *std::move(answer);
    } catch (const std::bad_alloc&) {
      end_locked();  // the rest of its answer is still to come
      throw;
    }
    status = end_locked();
    Cancellation::check();
    // Who ended it from outside did not mean this file.
    const int signal = WIFSIGNALED(status) ? WTERMSIG(status) : 0;
    if (signal != SIGKILL && signal != SIGTERM) break;
  }
  throw render_error(fmt::format("the image codec ended over it with {}", how_it_ended(status)));
}

}  // namespace tessera
