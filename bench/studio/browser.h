#pragma once

#include <filesystem>
#include <functional>
#include <memory>
#include <nlohmann/json.hpp>
#include <string>
#include <string_view>

#include "web/web_socket_client.h"

namespace tessera {

/// A headless Chromium with one page of 1280 x 720, driven by its DevTools protocol over a port of
/// this machine. It is ended with this object.
class Browser {
 public:
  /// What it keeps goes to `folder`. Throws render_error where it does not come up. `check`: as of
  /// StudioBenchOptions.
  Browser(const std::string& program, const std::filesystem::path& folder,
          std::function<void()> check);
  ~Browser();
  Browser(const Browser&) = delete;
  Browser& operator=(const Browser&) = delete;

  /// The result of one command.
  nlohmann::json call(std::string_view method, const nlohmann::json& parameters = {{}});
  /// The value of a JavaScript expression in the page.
  nlohmann::json evaluate(const std::string& expression);
  /// Waits until it is true.
  void wait_until(const std::string& expression);

  /// Presses a key that makes that sign, and lets it go.
  void type(char sign);
  /// Likewise one without a sign: "Backspace", 8.
  void press(const std::string& name, int number, int modifiers = 0);
  /// Clicks in the middle of the first element of that selector whose text holds `text`.
  void click(const std::string& selector, const std::string& text = "");

 private:
  std::string wait_for_port(const std::filesystem::path& folder);

  int process_ = -1;
  std::function<void()> check_;
  std::unique_ptr<WebSocketClient> socket_;
  std::string session_;
  int count_ = 0;
};

}  // namespace tessera
