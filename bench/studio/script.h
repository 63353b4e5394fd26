#pragma once

#include <cstdint>
#include <string>
#include <string_view>

#include "bench/studio/page_client.h"

namespace tessera {

/// Whether a message is about that version of a text.
PageClient::Condition of_version(uint64_t version);

/// Types digits at one number of a text that is open in a page.
class Script {
 public:
  /// The page has to outlive it.
  Script(PageClient& page, std::string file);

  uint64_t version() const { return version_; }

  /// Finds a number in which one more digit makes another picture than that of the digest `shown`.
  /// Returns false where there is none.
  bool find_place(const std::string& shown);
  /// The place behind these words, which the text has.
  void take_place(std::string_view words);
  /// Types a digit in place of the one before.
  void type(int number);

 private:
  bool is_shown(size_t place, const std::string& shown);

  PageClient& page_;
  const std::string file_;
  std::string text_;  ///< as it was opened
  uint64_t version_ = 0;
  size_t place_ = 0;
  bool has_digit_ = false;
};

}  // namespace tessera
