#include "studio/files/file_name.h"

#include <fmt/format.h>

#include "base/file.h"

namespace tessera {
namespace {

constexpr size_t kLongestName = 1024, kLongestPart = 255;

std::string fault_of_part(std::string_view part) {
  if (part.empty()) return "a part of its path is empty";
  if (part == "." || part == "..") return fmt::format("its path has '{}'", part);
  if (part.front() == '.') return "a part of its path is hidden: it begins with '.'";
  if (part.size() > kLongestPart)
    return fmt::format("a part of its path has more than {} bytes", kLongestPart);
  return {};
}

}  // namespace

std::string fault_of_name(std::string_view name) {
  if (name.empty()) return "it is empty";
  if (name.size() > kLongestName) return fmt::format("it has more than {} bytes", kLongestName);
  if (find_invalid_utf8(name) != std::string_view::npos) return "it is not UTF-8";
  for (const char c : name) {
    if (static_cast<unsigned char>(c) < ' ' || c == '\x7f') return "it has control characters";
  }
  if (name.front() == '/') return "it does not begin in the folder";
  while (true) {
    const size_t end = name.find('/');
    if (std::string fault = fault_of_part(name.substr(0, end)); !fault.empty()) return fault;
    if (end == std::string_view::npos) return {};
    name.remove_prefix(end + 1);
  }
}

}  // namespace tessera
