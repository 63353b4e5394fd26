#include <fmt/format.h>

#include <algorithm>
#include <functional>
#include <initializer_list>
#include <pugixml.hpp>
#include <set>

#include "scenes/formats/x3d/document/x3d_document.h"
#include "scenes/formats/x3d/document/x3d_nodes.h"
#include "scenes/formats/x3d/document/x3d_tree.h"

namespace tessera {

/// Turns elements into nodes. pugixml opens no file, expands no entity and skips the DOCTYPE.
class X3dXmlReader {
 public:
  X3dXmlReader(std::string_view text, const std::string& name, const X3dPrototypeFinder& find)
      : document_(text, name, false), tree_(document_, find) {}

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
    xml_.find_node([this](const pugi::xml_node& each) {
      tell_of_second_attributes(each);
      return false;
    });
    const pugi::xml_node root = xml_.document_element();
    if (std::string_view(root.name()) != "X3D")
      throw document_.error(offset(root), fmt::format("element '{}'", root.name()), "'X3D'");
    read_version(root.attribute("version"));
    const pugi::xml_node scene = root.child("Scene");
    if (!scene) throw document_.error(offset(root), "no Scene element", "one inside X3D");
    tell_of_unread(xml_, {"X3D"}, {}, "one X3D in a file");
    tell_of_unread(root, {"head", "Scene"}, {}, "one head and one Scene in X3D");
    read_head(root.child("head"));
    document_.scene_ = element(scene, 0);
    tree_.end();
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

  void tell_of_second_attributes(const pugi::xml_node& xml) {
    size_t count = 0;
    for (const pugi::xml_attribute& each : xml.attributes())
      if (++count <= X3dTree::kMaxSearched && xml.attribute(each.name()) != each)
        tree_.tell_of_second(each.name(), xml.name(), offset(each));
  }

  void tell_of_text(const pugi::xml_node& parent, const pugi::xml_node& child) {
    if (child.type() != pugi::node_pcdata) return;
    const size_t at = std::string_view(child.value()).find_first_not_of(" \t\r\n");
    if (at == std::string_view::npos) return;
    document_.remarks_.push_back({offset(child) + at, fmt::format("text in {}", parent.name()),
                                  "attributes and elements", "it is not read"});
  }

  using Names = std::initializer_list<std::string_view>;
  /// Tells of elements that have no meaning in `parent`, or that may stand there only once.
  void tell_of_unread(const pugi::xml_node& parent, Names once, Names often,
                      std::string_view expected) {
    std::set<std::string_view> seen;
    for (const pugi::xml_node& child : parent.children()) {
      tell_of_text(parent, child);
      const auto is_one_of = [&](Names names) {
        return std::ranges::find(names, child.name()) != names.end();
      };
      if (child.type() != pugi::node_element || is_one_of(often)) continue;
      const bool is_first = seen.insert(child.name()).second;
      if (is_first && is_one_of(once)) continue;
      document_.remarks_.push_back(
          {offset(child), fmt::format("{} '{}'", is_first ? "an element" : "another", child.name()),
           std::string(expected), "it is not read"});
    }
  }

  void read_version(const pugi::xml_attribute& attribute) {
    const std::string_view text = attribute.value();
    if (text.size() >= 3 && text[0] >= '3' && text[0] <= '4' && text[1] == '.' && text[2] >= '0' &&
        text[2] <= '9')
      document_.version_ = (text[0] - '0') * 10 + (text[2] - '0');
    else if (attribute)
      document_.remarks_.push_back(
          {offset(attribute), fmt::format("unknown version '{}' is read as 3.3", text)});
  }

  void read_head(const pugi::xml_node& head) {
    tell_of_unread(head, {}, {"component", "unit", "meta"}, "component, unit or meta in head");
    for (const pugi::xml_node& entry : head.children()) {
      const std::string_view name = entry.name();
      if (name == "meta")
        document_.metadata_[entry.attribute("name").value()] = entry.attribute("content").value();
      if (name == "unit") {
        const pugi::xml_attribute factor = entry.attribute("conversionFactor");
        tree_.set_unit(entry.attribute("category").value(), factor.as_string("1"),
                       factor ? offset(factor) : offset(entry));
      }
    }
  }

  X3dNode* element(const pugi::xml_node& xml, int depth) {
    X3dNode& node = tree_.add(xml.name(), offset(xml), depth);
    const X3dNodeType* type = find_x3d_node_type(xml.name());
    for (const pugi::xml_attribute& attribute : xml.attributes()) {
      const std::string_view name = attribute.name();
      const bool is_of_html = name == "class" || name == "id" || name == "style";
      if (name != "DEF" && name != "USE" && name != "containerField" &&
          name.find(':') == std::string_view::npos &&
          (!is_of_html || (type && type->has_field(name))))
        node.fields.push_back({std::string(name), attribute.value(), offset(attribute)});
    }
    tree_.begin(node, xml.attribute("DEF").value());
    add_children(node, xml, depth);
    tree_.finish(node);
    return &node;
  }

  void add_children(X3dNode& node, const pugi::xml_node& xml, int depth) {
    for (const pugi::xml_node& child : xml.children()) {
      tell_of_text(xml, child);
      if (child.type() != pugi::node_element) continue;
      const std::string_view name = child.name();
      if (name == "IS")
        add_connections(node, child);
      else if (name == "ProtoDeclare")
        declare(child, depth + 1);
      else if (name == "ExternProtoDeclare" && declare_elsewhere(child))
        continue;
      else
        add_child(node, child, depth);
    }
  }

  void add_connections(X3dNode& node, const pugi::xml_node& xml) {
    tell_of_unread(xml, {}, {"connect"}, "connect in IS");
    for (const pugi::xml_node& connect : xml.children("connect"))
      node.is.push_back(
          {connect.attribute("nodeField").value(), connect.attribute("protoField").value()});
  }

  void add_child(X3dNode& parent, const pugi::xml_node& xml, int depth) {
    const pugi::xml_attribute use = xml.attribute("USE");
    const std::string_view type = xml.name();
    X3dNode* node;
    if (*use.value())
      node =
          tree_.use(use.value(), type == "ProtoInstance" ? std::string_view() : type, offset(use));
    else
      node = type == "ProtoInstance" ? instance(xml, depth + 1) : element(xml, depth + 1);
    if (node)
      tree_.add_child(parent, container(parent, *node, xml.attribute("containerField")), node);
  }

  /// The field that holds the node: that of its type where none is named, or one that the parent
  /// does not have.
  std::string container(const X3dNode& parent, const X3dNode& node,
                        const pugi::xml_attribute& named) {
    const X3dNodeType* type = find_x3d_node_type(node.type);
    const X3dNodeType* holder = find_x3d_node_type(parent.type);
    std::string usual(type ? type->container : "children");
    if (!*named.value()) return usual;
    const std::string name = X3dTree::field_of(parent, named.value());
    if (!type || !holder || holder->has_node_field(name) || !holder->has_node_field(usual))
      return name;
    document_.remarks_.push_back(
        {offset(named), fmt::format("{} has no field '{}' for {}; '{}' is taken", parent.type, name,
                                    describe(node), usual)});
    return usual;
  }

  /// The values of field or fieldValue elements, as fields and children of `node`.
  void add_values(X3dNode& node, const pugi::xml_node& xml, const char* element_name, int depth) {
    for (const pugi::xml_node& entry : xml.children(element_name)) {
      const std::string name = entry.attribute("name").value();
      const pugi::xml_attribute value = entry.attribute("value");
      if (value) node.fields.push_back({name, value.value(), offset(value)});
      X3dNode holder;
      add_children(holder, entry, depth);
      for (const X3dNode::Child& child : holder.children) tree_.add_child(node, name, child.node);
    }
  }

  void declare(const pugi::xml_node& xml, int depth) {
    tree_.check_depth(offset(xml), depth);
    tell_of_unread(xml, {"ProtoInterface", "ProtoBody"}, {}, "one of each part of ProtoDeclare");
    X3dPrototype made;
    tree_.begin_prototype();
    const pugi::xml_node interface = xml.child("ProtoInterface");
    tell_of_unread(interface, {}, {"field"}, "field in ProtoInterface");
    add_values(made.interface_node, interface, "field", depth);
    X3dNode holder;
    add_children(holder, xml.child("ProtoBody"), depth);
    tree_.end_prototype();
    if (!holder.children.empty()) made.body = holder.children.front().node;
    tree_.declare(xml.attribute("name").value(), std::move(made));
  }

  bool declare_elsewhere(const pugi::xml_node& xml) {
    const std::string_view text = xml.attribute("url").value();
    std::vector<std::string> urls;
    for (size_t at = text.find('"'); at != text.npos;) {
      const size_t end = text.find('"', at + 1);
      urls.emplace_back(text.substr(at + 1, end == text.npos ? text.npos : end - at - 1));
      at = end == text.npos ? end : text.find('"', end + 1);
    }
    if (urls.empty() && !text.empty()) urls.emplace_back(text);
    return tree_.declare_elsewhere(xml.attribute("name").value(), urls, offset(xml));
  }

  X3dNode* instance(const pugi::xml_node& xml, int depth) {
    const X3dPrototype* prototype = tree_.prototype(xml.attribute("name").value());
    if (!prototype) return element(xml, depth);
    tree_.check_depth(offset(xml), depth);
    X3dNode given;
    given.offset = offset(xml);
    tell_of_unread(xml, {}, {"fieldValue", "IS"}, "fieldValue or IS in ProtoInstance");
    add_values(given, xml, "fieldValue", depth);
    for (const pugi::xml_node& is : xml.children("IS")) add_connections(given, is);
    X3dNode* node = tree_.instantiate(*prototype, given);
    tree_.begin(*node, xml.attribute("DEF").value());
    tree_.finish(*node);
    return node;
  }

  X3dDocument document_;
  X3dTree tree_;
  pugi::xml_document xml_;
};

X3dDocument X3dDocument::parse_xml(std::string_view text, const std::string& name,
                                   const X3dPrototypeFinder& find) {
  return X3dXmlReader(text, name, find).read();
}

}  // namespace tessera
