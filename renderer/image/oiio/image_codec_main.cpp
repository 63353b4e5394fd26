// The image codec: a process that reads and writes pictures for the one that started it, over the
// socket that is its standard input, until that is closed. What is most common it does at once; the
// rest by a module that it loads when first asked for. Decoders cannot take the renderer down with
// them.
#include <dlfcn.h>
#include <sys/resource.h>
#include <unistd.h>

#include <algorithm>
#include <csignal>
#include <cstdio>
#include <exception>
#include <filesystem>
#include <new>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "renderer/image/channel/image_channel.h"
#include "renderer/image/plain/image_answer.h"
#include "renderer/image/plain/plain_formats.h"

namespace tessera {

namespace {

using Module = void (*)(const ImageRequest&, std::vector<char>, ImageAnswer&);

/// The module beside this program, loaded when first asked for.
Module oiio_module() {
  static const Module module = [] {
    const auto folder = std::filesystem::read_symlink("/proc/self/exe").parent_path();
    void* const library = dlopen((folder / "tessera_oiio.so").c_str(), RTLD_NOW | RTLD_LOCAL);
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

ImageAnswer answer_to(const ImageRequest& request, std::vector<char> payload) {
  if (request.version != ImageRequest::kVersion) {
    fail_image("the image codec is of another version");
  }
  if (auto plain = answer_plainly(request, payload)) return *std::move(plain);
  ImageAnswer answer;
  oiio_module()(request, std::move(payload), answer);
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

bool send(ImageChannel& channel, ImageAnswer& answer) {
  if (!answer.shared) {
    return channel.send(ImageReply{1, 0, answer.layout, answer.payload.size()},
                        {answer.payload.data(), answer.payload.size()});
  }
  const int descriptor = answer.shared->seal();
  return descriptor >= 0 &&
         channel.send_shared({1, 1, answer.layout, answer.layout.bytes()}, descriptor);
}

bool serve_one(ImageChannel& channel) {
  ImageRequest request;
  if (!channel.receive(request)) return false;
  limit_processor_time(request.call != ImageRequest::encode &&
                       request.call != ImageRequest::convert_colors);
  if (request.call == ImageRequest::load) return load_oiio();
  std::vector<char> payload(request.payload_bytes);
  if (!channel.receive_bytes(payload.data(), payload.size())) return false;
  std::string cause;
  try {
    ImageAnswer answer = answer_to(request, std::move(payload));
    return send(channel, answer);
  } catch (const std::bad_alloc&) {
    cause = "there is not enough memory for it";
  } catch (const std::exception& error) {
    cause = error.what();
    if (cause.empty()) cause = "OpenImageIO does not tell why";
    std::replace(cause.begin(), cause.end(), '\n', ' ');
  }
  return channel.send(ImageReply{0, 0, {}, cause.size()}, cause);
}

}  // namespace

}  // namespace tessera

int main() {
  std::signal(SIGXFSZ, SIG_IGN);
  // What is wrong with a picture is told to who asked; libraries would print it too.
  if (std::FILE* const nowhere = std::fopen("/dev/null", "w")) stderr = nowhere;
  tessera::ImageChannel channel(STDIN_FILENO);
  while (tessera::serve_one(channel)) {
  }
  // Nothing is left to be written; taking the libraries down in order would only cost time.
  _exit(0);
}
