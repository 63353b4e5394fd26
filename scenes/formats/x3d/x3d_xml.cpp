#include <fmt/format.h>

#include <algorithm>
#include <functional>
#include <pugixml.hpp>
#include <set>

#include "base/file.h"
#include "scenes/formats/x3d/x3d_document.h"
#include "scenes/formats/x3d/x3d_nodes.h"

namespace tessera {

/// Turns elements into nodes. pugixml opens no file, expands no entity and skips the DOCTYPE.
class X3dXmlReader {
 public:
  X3dXmlReader(std::string_view text, const std::string& name) {
    document_.name_ = name;
    if (text.starts_with("\xFF\xFE") || text.starts_with("\xFE\xFF"))
      throw scene_error({name}, "text in UTF-16", "UTF-8");
    document_.source_ = to_utf8(text);
    document_.text_ = document_.source_;
  }

  X3dDocument read() {
    std::string& text = document_.text_;
    // Line ends stay as they are, so that a place in a field is a place in the file.
    const pugi::xml_parse_result result = xml_.load_buffer_inplace(
        text.data(), text.size(), pugi::parse_escapes, pugi::encoding_utf8);
    if (!result) {
      const size_t at = std::min(static_cast<size_t>(result.offset), document_.source_.size());
      throw document_.error(at, fmt::format("not well-formed XML: {}", result.description()),
                            "an X3D document");
    }
    const pugi::xml_node root = xml_.document_element();
    if (std::string_view(root.name()) != "X3D")
      throw document_.error(offset(root), fmt::format("element '{}'", root.name()), "'X3D'");
    read_version(root.attribute("version"));
    const pugi::xml_node scene = root.child("Scene");
    if (!scene) throw document_.error(offset(root), "no Scene element", "one inside X3D");
    read_head(root.child("head"));
    document_.scene_ = element(scene, 0);
    return std::move(document_);
  }

 private:
  static size_t offset(const pugi::xml_node& node) {
    return static_cast<size_t>(std::max<ptrdiff_t>(0, node.offset_debug()));
  }
  size_t offset(const pugi::xml_attribute& attribute) const {
    const std::string& text = document_.text_;
    const std::less_equal<const char*> ordered;
    const bool inside = ordered(text.data(), attribute.value()) &&
                        ordered(attribute.value(), text.data() + text.size());
    return inside ? static_cast<size_t>(attribute.value() - text.data()) : 0;
  }

  void read_version(const pugi::xml_attribute& attribute) {
    const std::string_view text = attribute.value();
    if (text.size() >= 3 && text[0] >= '3' && text[0] <= '4' && text[1] == '.' && text[2] >= '0' &&
        text[2] <= '9')
      document_.version_ = (text[0] - '0') * 10 + (text[2] - '0');
    else if (!text.empty())
      document_.remarks_.push_back(fmt::format("unknown version '{}' is read as 3.3", text));
  }

  void read_head(const pugi::xml_node& head) {
    for (const pugi::xml_node& entry : head.children()) {
      const std::string_view name = entry.name();
      if (name == "meta")
        document_.metadata_[entry.attribute("name").value()] = entry.attribute("content").value();
      if (name == "unit" && entry.attribute("conversionFactor").as_double(1) != 1)
        document_.remarks_.push_back(
            fmt::format("unit of {} is not read yet", entry.attribute("category").value()));
    }
  }

  X3dNode* element(const pugi::xml_node& xml, int depth) {
    if (depth > X3dDocument::kMaxDepth)
      throw document_.error(offset(xml), "elements nested too deep",
                            fmt::format("at most {} levels", X3dDocument::kMaxDepth));
    X3dNode& node = document_.nodes_.emplace_back();
    node.type = xml.name();
    node.offset = offset(xml);
    for (const pugi::xml_attribute& attribute : xml.attributes()) {
      const std::string_view name = attribute.name();
      if (name == "DEF")
        node.def = attribute.value();
      else if (name != "USE" && name != "containerField" && name != "class" && name != "id" &&
               name != "style" && name.find(':') == std::string_view::npos)
        node.fields.push_back({std::string(name), attribute.value(), offset(attribute)});
    }
    if (!node.def.empty()) {
      defs_[node.def] = &node;
      open_.insert(&node);
    }
    // The body of a prototype is no part of the scene.
    if (node.type != "ProtoDeclare" && node.type != "ExternProtoDeclare")
      for (const pugi::xml_node& child : xml.children())
        if (child.type() == pugi::node_element) add_child(node, child, depth);
    open_.erase(&node);
    return &node;
  }

  void add_child(X3dNode& parent, const pugi::xml_node& xml, int depth) {
    const pugi::xml_attribute use = xml.attribute("USE");
    const X3dNode* node = use ? used(xml, use) : element(xml, depth + 1);
    std::string container = xml.attribute("containerField").value();
    if (container.empty()) {
      const X3dNodeType* type = find_x3d_node_type(node->type);
      container = type ? type->container : "children";
    }
    parent.children.push_back({std::move(container), node});
  }

  const X3dNode* used(const pugi::xml_node& xml, const pugi::xml_attribute& use) {
    const std::string name = use.value();
    const auto known = defs_.find(name);
    if (known == defs_.end()) {
      std::vector<std::string> names;
      for (const auto& entry : defs_) names.push_back(entry.first);
      throw document_.error(offset(use), fmt::format("USE of '{}', which is not defined", name),
                            "the DEF name of a node before it" + suggestion(name, names));
    }
    X3dNode& node = *known->second;
    if (open_.contains(&node))
      throw document_.error(offset(use), fmt::format("USE of '{}' inside itself", name),
                            "a graph without cycles");
    if (node.type != xml.name())
      throw document_.error(
          offset(xml),
          fmt::format("{} with USE of '{}', which is a {}", xml.name(), name, node.type),
          "the same type");
    ++node.uses;
    return &node;
  }

  X3dDocument document_;
  pugi::xml_document xml_;
  std::map<std::string, X3dNode*> defs_;
  std::set<const X3dNode*> open_;
};

X3dDocument X3dDocument::parse_xml(std::string_view text, const std::string& name) {
  return X3dXmlReader(text, name).read();
}

}  // namespace tessera
