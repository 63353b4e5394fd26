#include "scenes/formats/x3d/document/x3d_document.h"

#include <fmt/format.h>

#include <algorithm>

#include "base/file.h"
#include "base/plain_text.h"
#include "scenes/formats/x3d/document/gunzip.h"

namespace tessera {

const X3dField* X3dNode::field(std::string_view name) const {
  const auto at =
      std::find_if(fields.begin(), fields.end(), [&](const X3dField& f) { return f.name == name; });
  return at == fields.end() ? nullptr : &*at;
}

const X3dNode* X3dNode::child(std::string_view container) const {
  const auto at = std::find_if(children.rbegin(), children.rend(),
                               [&](const Child& c) { return c.container == container; });
  return at == children.rend() ? nullptr : at->node;
}

X3dDocument X3dDocument::parse(std::string_view bytes, const std::string& name,
                               const X3dPrototypeFinder& find) {
  std::string plain;
  if (is_gzip(bytes)) {
    plain = gunzip(bytes, kMaxBytes, name);
    bytes = plain;
  }
  refuse_wide_text(bytes, name);
  const std::string text = to_utf8(skip_byte_order_mark(bytes));
  const size_t start = text.find_first_not_of(" \t\r\n");
  if (start != std::string::npos && text[start] == '<') return parse_xml(text, name, find);
  return parse_classic(text, name, find);
}

SourcePlace X3dDocument::place(size_t offset) const {
  const std::string_view before = std::string_view(source_).substr(0, offset);
  const size_t line_start = before.rfind('\n') + 1;  // npos + 1 is 0
  return {name_, 1 + static_cast<int>(std::count(before.begin(), before.end(), '\n')),
          static_cast<int>(before.size() - line_start) + 1};
}

Error X3dDocument::error(size_t offset, std::string_view found, std::string_view expected) const {
  return scene_error(place(offset), found, expected);
}

std::string describe(const X3dNode& node) {
  return node.def.empty() ? node.type : fmt::format("{} '{}'", node.type, node.def);
}

}  // namespace tessera
