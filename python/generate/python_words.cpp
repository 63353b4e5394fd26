#include "python/generate/python_words.h"

#include <fmt/format.h>

#include <algorithm>
#include <cctype>
#include <map>

#include "python/generate/enum_names.h"

namespace tessera {
namespace {

namespace pb = google::protobuf;

void add_words(const pb::EnumDescriptor& type, std::map<std::string, std::string>& words) {
  for (int i = 0; i < type.value_count(); ++i) {
    words[type.value(i)->name()] = fmt::format("\"{}\"", python_name(*type.value(i)));
  }
}

void add_words(const pb::Descriptor& message, std::map<std::string, std::string>& words) {
  for (int i = 0; i < message.nested_type_count(); ++i) add_words(*message.nested_type(i), words);
  for (int i = 0; i < message.enum_type_count(); ++i) add_words(*message.enum_type(i), words);
}

}  // namespace

std::string with_python_words(const std::string& text, const pb::FileDescriptor& file) {
  std::map<std::string, std::string> words;
  for (int i = 0; i < file.message_type_count(); ++i) add_words(*file.message_type(i), words);
  const auto is_part = [](char c) {
    return std::isalnum(static_cast<unsigned char>(c)) || c == '_';
  };
  std::string out;
  for (auto at = text.begin(); at != text.end();) {
    const auto end = std::find_if_not(at, text.end(), is_part);
    const std::string word(at, end);
    out += words.contains(word) ? words.at(word) : word;
    at = std::find_if(end, text.end(), is_part);
    out.append(end, at);
  }
  return out;
}

}  // namespace tessera
