#pragma once

#include <map>
#include <string>

#include "scenes/import/loaded_scene.h"

namespace tessera {

/// Lets an importer find out whether a picture can be decoded, at the price of decoding it once:
/// what was found good is kept until it is asked for. Refers to `options`, and what reading()
/// returns refers to this.
class CheckedPictures {
 public:
  explicit CheckedPictures(const ReadOptions& options) : options_(options) {}
  CheckedPictures(const CheckedPictures&) = delete;
  CheckedPictures& operator=(const CheckedPictures&) = delete;

  /// The options with decoders that know what was checked, and with a check.
  ReadOptions reading();

 private:
  std::string check(const std::string& name, const std::string* bytes);
  DecodedTexture take(const std::string& name);

  const ReadOptions& options_;
  std::map<std::string, DecodedTexture> good_;
  std::map<std::string, std::string> bad_;  ///< why
};

}  // namespace tessera
