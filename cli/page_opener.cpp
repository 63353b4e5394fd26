#include "cli/page_opener.h"

#include <fmt/format.h>
#include <spdlog/spdlog.h>
#include <unistd.h>

#include <cstdlib>
#include <system_error>
#include <thread>

#include "base/error.h"
#include "base/process.h"

namespace tessera {

PageOpener::PageOpener(const std::string& address) {
  // By the specifications of these variables an empty one is as one that is not set.
  const auto variable = [](const char* name) {
    const char* const value = std::getenv(name);
    return value && *value ? value : nullptr;
  };
  if (!variable("DISPLAY") && !variable("WAYLAND_DISPLAY")) return;
  const char* const runtime = variable("XDG_RUNTIME_DIR");
  std::error_code error;
  const std::filesystem::path folder =
      runtime ? runtime : std::filesystem::temp_directory_path(error);
  std::string name = (folder / "tessera-studio-XXXXXX.html").string();
  constexpr int kEnding = 5;
  const int file = mkstemps(name.data(), kEnding);  // mode 0600
  if (file < 0) return;
  file_ = name;
  const std::string text = fmt::format(
      "<!DOCTYPE html><meta charset=\"utf-8\"><meta http-equiv=\"refresh\" content=\"0; "
      "url={}\"><title>Tessera studio</title>\n",
      address);
  const bool is_whole = write(file, text.data(), text.size()) == static_cast<ssize_t>(text.size());
  close(file);
  if (!is_whole) return;
  try {
    const pid_t opener =
        start_process("xdg-open", {"xdg-open", file_.string()}, {.discards_output = true});
    std::thread([opener] { wait_for_process(opener); }).detach();
  } catch (const Error& failure) {
    spdlog::info("no browser was started: {}", failure.what());
  }
}

PageOpener::~PageOpener() {
  std::error_code error;
  if (!file_.empty()) std::filesystem::remove(file_, error);
}

}  // namespace tessera
