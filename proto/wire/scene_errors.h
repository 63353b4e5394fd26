#pragma once

#include <google/protobuf/descriptor.h>
#include <google/protobuf/io/tokenizer.h>

#include <string>
#include <string_view>
#include <vector>

#include "base/all_failures.h"
#include "base/error.h"

namespace tessera {

/// The line and column of a byte of `text`.
SourcePlace place_of(const std::string& file, std::string_view text, size_t offset);

/// The offset of a place as protobuf's tokenizer counts it: from 0, tabs to multiples of 8.
size_t offset_of(std::string_view text, int line, int column);

/// Of a message type, of an enumeration: the names that may be written.
std::vector<std::string> field_names(const google::protobuf::Descriptor& type);
std::vector<std::string> value_names(const google::protobuf::EnumDescriptor& type);

/// "one of a, b, c; did you mean 'b'?" where `written` is none of them.
std::string one_of(const std::vector<std::string>& names, const std::string& written);

/// Takes the complaints of protobuf's text parser, each unknown field and the first of what ends
/// it, and says them in our words.
class TextErrors : public google::protobuf::io::ErrorCollector {
 public:
  /// `text` must outlive this.
  TextErrors(std::string file, std::string_view text) : file_(std::move(file)), text_(text) {}
  void AddError(int line, int column, const std::string& message) override;
  /// Of a field that the parser was told to skip.
  void AddWarning(int line, int column, const std::string& message) override;
  void throw_if_any() const { all_.throw_if_any(); }

 private:
  /// The offset of the word meant, where the parser is already past it.
  size_t place(int line, int column, const std::string& culprit) const;

  std::string file_;
  std::string_view text_;
  AllFailures all_{kMostFaults};
  size_t unknown_end_ = std::string_view::npos;  ///< where the name of the last unknown field ends
};

/// Throws where `text` is no JSON, is nested deeper than kMaxSceneDepth, names fields that a scene
/// does not have, or gives them values of another type: tells all of these up to the first fault of
/// form.
void check_scene_json(std::string_view text, const std::string& file);
/// What protobuf's JSON parser still complains of, such as wrong base64, with its place: messages
/// begin with the path in parentheses.
Error scene_json_error(const std::string& file, std::string_view text, std::string_view message);

}  // namespace tessera
