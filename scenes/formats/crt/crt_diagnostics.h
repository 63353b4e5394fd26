#pragma once

#include <cstdint>
#include <set>
#include <stdexcept>
#include <string>
#include <string_view>
#include <vector>

#include "base/all_failures.h"
#include "base/error.h"
#include "scenes/import/loaded_scene.h"

namespace tessera {

/// A stretch of a script's text, in bytes.
struct CrtSpan {
  uint32_t offset = 0;
  uint32_t length = 0;
};

/// What is wrong with a script at one place: thrown where it is found, caught at the statement or
/// attribute that it spoils, so that one run finds several.
class CrtError : public std::runtime_error {
 public:
  CrtError(CrtSpan where, const std::string& found, std::string expected)
      : std::runtime_error(found), where_(where), expected_(std::move(expected)) {}
  CrtSpan where() const { return where_; }
  const std::string& expected() const { return expected_; }

 private:
  CrtSpan where_;
  std::string expected_;
};

/// A limit is reached: nothing more of the script is run.
class CrtLimitError : public CrtError {
 public:
  using CrtError::CrtError;
};

/// Collects what is to be said of a script, each with its line, the source and a caret below it.
class CrtDiagnostics {
 public:
  static constexpr size_t kMostWarnings = 50;

  /// `text` must outlive this.
  CrtDiagnostics(std::string file, std::string_view text);

  /// A second error at the same place says nothing new and is left out.
  void error(CrtSpan where, std::string_view found, std::string_view expected);
  void error(const CrtError& error) { this->error(error.where(), error.what(), error.expected()); }
  void warning(CrtSpan where, std::string_view what);

  bool has_errors() const { return !errors_.empty(); }
  bool is_full() const { return errors_.size() >= kMostFaults; }
  /// Throws one scene error that holds all errors in the order of their places.
  void throw_if_any() const;
  void add_warnings_to(LoadedScene& loaded) const;

 private:
  struct Message {
    CrtSpan where;
    std::string text;
    Diagnostic parts;
  };
  SourcePlace place(CrtSpan where) const;
  /// In bytes, where place() counts characters, as people do.
  SourcePlace byte_place(uint32_t offset) const;
  Diagnostic parts_of(CrtSpan where, std::string_view found, std::string_view expected) const;
  std::string excerpt(CrtSpan where) const;

  std::string file_;
  std::string_view text_;
  std::vector<uint32_t> line_starts_;
  std::vector<Message> errors_, warnings_;
  std::set<uint32_t> error_places_, warning_places_;
  size_t warnings_dropped_ = 0;
};

}  // namespace tessera
