#pragma once

#include <filesystem>
#include <string>

namespace tessera {

/// Shows a page in the user's browser, where there is a display. Its address, which may hold a
/// token, is in a file that forwards to it and that nobody else can read, so that no process has it
/// among its arguments.
class PageOpener {
 public:
  /// Returns at once. Whatever goes wrong, the user still has the address.
  explicit PageOpener(const std::string& address);
  /// Removes the file.
  ~PageOpener();
  PageOpener(const PageOpener&) = delete;
  PageOpener& operator=(const PageOpener&) = delete;

 private:
  std::filesystem::path file_;  ///< empty: there is none
};

}  // namespace tessera
