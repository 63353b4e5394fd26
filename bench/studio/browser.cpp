#include "bench/studio/browser.h"

#include <fmt/format.h>
#include <signal.h>
#include <sys/wait.h>

#include <fstream>
#include <thread>
#include <utility>

#include "base/error.h"
#include "base/monotonic.h"
#include "base/process.h"

namespace tessera {
namespace {

using Json = nlohmann::json;

constexpr std::chrono::seconds kBrowserPatience{60};
constexpr std::chrono::milliseconds kBetweenLooks{20};

}  // namespace

Browser::Browser(const std::string& program, const std::filesystem::path& folder,
                 std::function<void()> check)
    : check_(std::move(check)) {
  // What it says of missing buses and sandboxes is of no use here.
  process_ = start_process(
      "sh",
      {"sh", "-c", "exec \"$@\" 2>/dev/null", "sh", "env", "TMPDIR=" + folder.string(), program,
       "--headless=new", "--no-sandbox", "--disable-gpu", "--disable-dev-shm-usage",
       "--no-first-run", "--mute-audio", "--disable-background-networking",
       "--disable-component-update", "--disable-sync", "--remote-debugging-port=0",
       "--user-data-dir=" + folder.string(), "about:blank"},
      {.discards_output = true});
  try {
    const std::string port_and_path = wait_for_port(folder);
    const size_t slash = port_and_path.find('/');
    socket_ =
        std::make_unique<WebSocketClient>("127.0.0.1:" + port_and_path.substr(0, slash),
                                          port_and_path.substr(slash), WebSocketClient::Headers{});
    const Json target = call("Target.createTarget", {{"url", "about:blank"}});
    session_ = call("Target.attachToTarget",
                    {{"targetId", target["targetId"]}, {"flatten", true}})["sessionId"];
    call("Page.enable");
    call("Emulation.setDeviceMetricsOverride",
         {{"width", 1280}, {"height", 720}, {"deviceScaleFactor", 1}, {"mobile", false}});
  } catch (...) {
    kill(-process_, SIGKILL);
    wait_for_process(process_);
    throw;
  }
}

Browser::~Browser() {
  kill(-process_, SIGKILL);
  wait_for_process(process_);
  // The others of its group are there until the system has seen to them.
  for (int look = 0; look < 250 && kill(-process_, SIGKILL) == 0; ++look)
    std::this_thread::sleep_for(kBetweenLooks);
}

/// "PORT/devtools/browser/ID", as it writes them in two lines.
std::string Browser::wait_for_port(const std::filesystem::path& folder) {
  for (const Time end = monotonic_now() + kBrowserPatience; monotonic_now() < end;) {
    check_();
    std::string port, path;
    std::ifstream file(folder / "DevToolsActivePort");
    if (std::getline(file, port) && std::getline(file, path) && path.starts_with('/')) {
      return port + path;
    }
    siginfo_t ended{};
    waitid(P_PID, static_cast<id_t>(process_), &ended, WEXITED | WNOHANG | WNOWAIT);
    if (ended.si_pid != 0) break;
    std::this_thread::sleep_for(kBetweenLooks);
  }
  throw render_error("the browser did not start; expected Chromium");
}

Json Browser::call(std::string_view method, const Json& parameters) {
  const int number = ++count_;
  Json message{{"id", number}, {"method", method}, {"params", parameters}};
  if (parameters.is_array()) message["params"] = Json::object();
  if (!session_.empty()) message["sessionId"] = session_;
  socket_->send(message.dump());
  for (const Time end = monotonic_now() + kBrowserPatience;;) {
    check_();
    const auto received = socket_->receive(kBetweenLooks);
    if (!received && monotonic_now() < end) continue;
    if (!received) throw render_error(fmt::format("the browser did not answer {}", method));
    Json answer = Json::parse(received->content);
    if (answer.value("id", 0) != number) continue;
    if (answer.contains("error")) {
      throw render_error(fmt::format("{}: {}", method, answer["error"].dump()));
    }
    return answer["result"];
  }
}

Json Browser::evaluate(const std::string& expression) {
  const Json answer =
      call("Runtime.evaluate",
           {{"expression", expression}, {"awaitPromise", true}, {"returnByValue", true}});
  if (answer.contains("exceptionDetails")) {
    throw render_error(fmt::format("{}: {}", expression, answer["exceptionDetails"].dump()));
  }
  return answer["result"].value("value", Json());
}

void Browser::wait_until(const std::string& expression) {
  for (const Time end = monotonic_now() + kBrowserPatience; evaluate(expression) != true;) {
    if (monotonic_now() > end) throw render_error(fmt::format("it did not come to {}", expression));
  }
}

void Browser::type(char sign) {
  const std::string text(1, sign);
  call("Input.dispatchKeyEvent",
       {{"type", "keyDown"}, {"text", text}, {"key", text}, {"unmodifiedText", text}});
  call("Input.dispatchKeyEvent", {{"type", "keyUp"}, {"key", text}});
}

void Browser::press(const std::string& name, int number, int modifiers) {
  for (const char* type : {"rawKeyDown", "keyUp"}) {
    call("Input.dispatchKeyEvent", {{"type", type},
                                    {"key", name},
                                    {"code", name},
                                    {"windowsVirtualKeyCode", number},
                                    {"modifiers", modifiers}});
  }
}

void Browser::click(const std::string& selector, const std::string& text) {
  const std::string find = fmt::format(
      "[...document.querySelectorAll({})].find((each) => each.textContent.includes({}))",
      Json(selector).dump(), Json(text).dump());
  wait_until(fmt::format("!!{}", find));
  const Json box =
      evaluate(fmt::format("(() => {{ const each = {}; each.scrollIntoView({{block: 'nearest'}}); "
                           "const box = each.getBoundingClientRect(); "
                           "return [box.x + box.width / 2, box.y + box.height / 2]; }})()",
                           find));
  for (const char* type : {"mouseMoved", "mousePressed", "mouseReleased"}) {
    call("Input.dispatchMouseEvent",
         {{"type", type},
          {"x", box[0]},
          {"y", box[1]},
          {"button", type == std::string("mouseMoved") ? "none" : "left"},
          {"clickCount", 1}});
  }
}

}  // namespace tessera
