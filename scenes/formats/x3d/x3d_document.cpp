#include "scenes/formats/x3d/x3d_document.h"

#include <fmt/format.h>

#include <algorithm>

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
