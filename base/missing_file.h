#pragma once

#include <memory>
#include <string>

#include "base/error.h"

namespace tessera {

/// A scene error: a file that is to be read is not there.
class MissingFileError : public Error {
 public:
  MissingFileError(const std::string& path, const std::string& found)
      : Error(ExitCode::bad_scene, path + ": " + found, {make_diagnostic({path}, found, "")}),
        path_(std::make_shared<const std::string>(path)) {}
  const std::string& path() const { return *path_; }

 private:
  std::shared_ptr<const std::string> path_;  ///< so that copying throws nothing
};

}  // namespace tessera
