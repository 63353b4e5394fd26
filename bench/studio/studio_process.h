#pragma once

#include <filesystem>
#include <functional>
#include <string>
#include <vector>

namespace tessera {

/// `tessera studio` as a process, which is ended with this object.
class StudioProcess {
 public:
  /// Opens that folder on any free port. Throws render_error where it does not come up. `check`: as
  /// of StudioBenchOptions.
  StudioProcess(const std::filesystem::path& folder, std::function<void()> check);
  ~StudioProcess();
  StudioProcess(const StudioProcess&) = delete;
  StudioProcess& operator=(const StudioProcess&) = delete;

  const std::string& address() const { return address_; }  ///< "127.0.0.1:PORT"
  const std::string& token() const { return token_; }
  int process() const { return process_; }
  const std::function<void()>& check() const { return check_; }
  /// Those that it has now.
  std::vector<int> workers() const;

 private:
  int process_ = -1;
  std::function<void()> check_;
  std::string address_, token_;
};

/// Nanoseconds that the threads of a process have run; 0 where it is gone.
uint64_t nanoseconds_of(int process);
/// What it holds in memory; 0 where it is gone.
uint64_t resident_bytes_of(int process);

}  // namespace tessera
