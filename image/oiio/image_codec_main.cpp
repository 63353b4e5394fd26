// The image codec: a process that reads and writes pictures for the one that started it, over the
// socket that is its standard input, until that is closed. What is most common it does at once; the
// rest by a module that it loads when first asked for. Decoders cannot take the renderer down with
// them, nor open files: what they decode is handed over as memory, and a sandbox holds them.
#include <dlfcn.h>
#include <poll.h>
#include <sys/mman.h>
#include <sys/resource.h>
#include <sys/syscall.h>
#include <unistd.h>

#include <algorithm>
#include <cerrno>
#include <csignal>
#include <cstdio>
#include <exception>
#include <filesystem>
#include <new>
#include <span>
#include <string>
#include <string_view>
#include <system_error>
#include <thread>
#include <utility>
#include <vector>

#include "base/core_count.h"
#include "base/owned_descriptor.h"
#include "image/channel/image_channel.h"
#include "image/plain/image_answer.h"
#include "image/plain/plain_formats.h"
#include "image/plain/png_format.h"
#include "image/sandbox/sandbox.h"

namespace tessera {

namespace {

using Module = void (*)(const ImageRequest&, std::vector<char> payload, int file, ImageAnswer&);

std::filesystem::path module_file() {
  return std::filesystem::read_symlink("/proc/self/exe").parent_path() / "tessera_oiio.so";
}

/// The module beside this program, loaded when first asked for.
Module oiio_module() {
  static const Module module = [] {
    void* const library = dlopen(module_file().c_str(), RTLD_NOW | RTLD_LOCAL);
    void* const symbol = library ? dlsym(library, "tessera_answer_image") : nullptr;
    if (!symbol) {
      fail_image(std::string("the module for this is not there (Debian's package of it is "
                             "tessera-openimageio): ") +
                 dlerror());
    }
    return reinterpret_cast<Module>(symbol);
  }();
  return module;
}

/// What came with a request: the bytes that followed it or, of a file to decode, sealed memory.
struct Payload {
  std::vector<char> bytes;
  OwnedDescriptor memory;
};

/// The mapped memory of a file to decode.
class MappedFile {
 public:
  MappedFile(int descriptor, size_t size)
      : data_(mmap(nullptr, size, PROT_READ, MAP_SHARED, descriptor, 0)), size_(size) {
    if (data_ == MAP_FAILED) fail_image("its memory cannot be mapped");
  }
  MappedFile(const MappedFile&) = delete;
  MappedFile& operator=(const MappedFile&) = delete;
  ~MappedFile() { munmap(data_, size_); }
  std::span<const char> bytes() const { return {static_cast<const char*>(data_), size_}; }

 private:
  void* data_;
  size_t size_;
};

std::optional<ImageAnswer> answer_plainly_to(const ImageRequest& request, const Payload& payload) {
  if (!request.decodes()) return answer_plainly(request, payload.bytes);
  const MappedFile file(payload.memory.get(), request.payload_bytes);
  return answer_plainly(request, file.bytes());
}

ImageAnswer answer_to(const ImageRequest& request, Payload payload) {
  float gamma = 0;
  if (request.decodes() && std::string_view(request.format) == "png")
    gamma = png_gamma(MappedFile(payload.memory.get(), request.payload_bytes).bytes());
  ImageAnswer answer;
  if (auto plain = answer_plainly_to(request, payload)) {
    answer = *std::move(plain);
  } else {
    oiio_module()(request, std::move(payload.bytes), payload.memory.get(), answer);
  }
  answer.gamma = gamma;
  return answer;
}

/// A file over which a decoder would work for ever ends this process. What we write is ours, and
/// may be large.
void limit_processor_time(bool is_limited) {
  constexpr rlim_t kSecondsPerPicture = 120;
  rusage used{};
  rlimit limit{};
  if (getrusage(RUSAGE_SELF, &used) != 0 || getrlimit(RLIMIT_CPU, &limit) != 0) return;
  const auto so_far = static_cast<rlim_t>(used.ru_utime.tv_sec + used.ru_stime.tv_sec);
  limit.rlim_cur = limit.rlim_max;
  if (is_limited) limit.rlim_cur = std::min(limit.rlim_max, so_far + kSecondsPerPicture);
  setrlimit(RLIMIT_CPU, &limit);
}

/// What goes wrong is told when it is needed.
bool load_oiio() {
  try {
    oiio_module();
  } catch (const std::exception&) {
  }
  return true;
}

class Server {
 public:
  Server(int socket, bool decodes, Sandbox sandbox)
      : channel_(socket), decodes_(decodes), sandbox_(sandbox) {}

  /// Answers one request; false: nobody asks any more.
  bool serve_one() {
    ImageRequest request;
    int memory = -1;
    if (!channel_.receive(request, memory)) return false;
    Payload payload{{}, OwnedDescriptor(memory)};
    limit_processor_time(request.decodes());
    if (request.call == ImageRequest::load) return load_oiio();
    if (memory < 0) payload.bytes.resize(request.payload_bytes);
    if (!channel_.receive_bytes(payload.bytes.data(), payload.bytes.size())) return false;
    std::string cause;
    try {
      if (request.version != ImageRequest::kVersion) {
        fail_image("the image codec is of another version");
      }
      if (request.decodes() && !decodes_) fail_image("this process may not decode files");
      ImageAnswer answer = answer_to(request, std::move(payload));
      return send(answer);
    } catch (const std::bad_alloc&) {
      cause = "there is not enough memory for it";
    } catch (const std::exception& error) {
      cause = error.what();
      if (cause.empty()) cause = "OpenImageIO does not tell why";
      std::replace(cause.begin(), cause.end(), '\n', ' ');
    }
    return channel_.send(reply(false, {}, cause.size()), cause);
  }

 private:
  ImageReply reply(bool done, PixelLayout layout, uint64_t payload_bytes) const {
    return {.done = done,
            .holds_files = sandbox_.holds_files,
            .holds_calls = sandbox_.holds_calls,
            .layout = layout,
            .payload_bytes = payload_bytes};
  }

  ImageReply reply(const ImageAnswer& answer, uint64_t payload_bytes) const {
    ImageReply made = reply(true, answer.layout, payload_bytes);
    made.from_integers = answer.meaning.from_integers;
    made.is_associated = answer.meaning.is_associated;
    made.gamma = answer.gamma;
    answer.part.copy(made.part, sizeof made.part - 1);
    answer.damage.copy(made.damage, sizeof made.damage - 1);
    return made;
  }

  bool send(ImageAnswer& answer) {
    ImageReply made = reply(answer, answer.shared ? answer.layout.bytes() : answer.payload.size());
    made.names_bytes = answer.names.size();
    made.is_shared = answer.shared.has_value();
    const int descriptor = answer.shared ? answer.shared->seal() : -1;
    const bool is_sent = answer.shared
                             ? descriptor >= 0 && channel_.send(made, descriptor)
                             : channel_.send(made, {answer.payload.data(), answer.payload.size()});
    return is_sent && channel_.send_bytes(answer.names.data(), answer.names.size());
  }

  ImageChannel channel_;
  bool decodes_;
  Sandbox sandbox_;
};

/// Ends this process as soon as the one that asks is gone, whatever it is at: nobody wants it.
void end_with_who_asks(int socket) {
  const auto watch = [socket] {
    pollfd asker{.fd = socket, .events = POLLRDHUP, .revents = 0};
    while (poll(&asker, 1, -1) < 0 && errno == EINTR) {
    }
    _exit(0);
  };
  try {
    std::thread(watch).detach();
  } catch (const std::system_error&) {
    // Where no thread can be had, it ends once it has answered.
  }
}

/// Those that this process may read from now on. The files that an OpenColorIO configuration names
/// may be anywhere, so whoever converts colours may read all, and decodes nothing.
std::vector<std::filesystem::path> readable_places(bool decodes) {
  if (!decodes) return {"/"};
  std::vector<std::filesystem::path> places = library_places();
  places.push_back(module_file());
  return places;
}

}  // namespace

}  // namespace tessera

int main(int count, char** arguments) {
  std::signal(SIGXFSZ, SIG_IGN);
  // What was left open for the program that started this is nothing to a decoder.
  syscall(SYS_close_range, STDERR_FILENO + 1, ~0U, 0);
  // What is wrong with a picture is told to who asked; libraries would print it too.
  if (std::FILE* const nowhere = std::fopen("/dev/null", "w")) stderr = nowhere;
  // In the sandbox the files that tell the quota are out of reach.
  tessera::core_count();
  const bool decodes = count < 2 || std::string_view(arguments[1]) != tessera::kConvertsColors;
  tessera::Server server(STDIN_FILENO, decodes,
                         tessera::enter_sandbox(tessera::readable_places(decodes)));
  tessera::end_with_who_asks(STDIN_FILENO);
  while (server.serve_one()) {
  }
  // Nothing is left to be written; taking the libraries down in order would only cost time.
  _exit(0);
}
