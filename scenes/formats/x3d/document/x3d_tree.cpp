#include "scenes/formats/x3d/document/x3d_tree.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <limits>

#include "scenes/formats/x3d/document/x3d_nodes.h"
#include "scenes/formats/x3d/document/x3d_number.h"

namespace tessera {
namespace {

bool is_ignored(const X3dNode& node) {
  const X3dNodeType* const type = find_x3d_node_type(node.type);
  return type && type->use == X3dNodeType::Use::ignored;
}

}  // namespace

X3dGiven::X3dGiven(const X3dNode& node) {
  for (const X3dNode::Is& is : node.is) is_.try_emplace(is.field, &is);
  for (const X3dField& field : node.fields) fields_.try_emplace(field.name, &field);
  for (const X3dNode::Child& child : node.children)
    children_[child.container].push_back(child.node);
}

const X3dNode::Is* X3dGiven::passed_on(std::string_view interface_field) const {
  const auto known = is_.find(interface_field);
  return known == is_.end() ? nullptr : known->second;
}

const X3dField* X3dGiven::field(std::string_view name) const {
  const auto known = fields_.find(name);
  return known == fields_.end() ? nullptr : known->second;
}

const std::vector<X3dNode*>& X3dGiven::children(std::string_view container) const {
  static const std::vector<X3dNode*> none;
  const auto known = children_.find(container);
  return known == children_.end() ? none : known->second;
}

X3dNode& X3dTree::place(size_t offset) {
  X3dNode& node = (scopes_.size() > 1 ? document_.templates_ : document_.nodes_).emplace_back();
  node.offset = offset;
  return node;
}

void X3dTree::check_depth(size_t offset, int depth) const {
  if (depth > X3dDocument::kMaxDepth)
    throw document_.error(offset, "nodes nested too deep",
                          fmt::format("at most {} levels", X3dDocument::kMaxDepth));
}

X3dNode& X3dTree::add(std::string type, size_t offset, int depth) {
  check_depth(offset, depth);
  X3dNode& node = place(offset);
  node.type = std::move(type);
  return node;
}

void X3dTree::begin(X3dNode& node, std::string name) {
  if (is_ignored(node)) ++ignored_;
  if (name.empty()) return;
  node.def = std::move(name);
  X3dNode*& named = scopes_.back().defs[node.def];
  if (named) scopes_.back().earlier[&node] = named;
  named = &node;
  open_.insert(&node);
}

void X3dTree::finish(const X3dNode& node) {
  if (is_ignored(node)) --ignored_;
  open_.erase(&node);
}

X3dNode* X3dTree::use(const std::string& name, std::string_view type, size_t offset) {
  const auto& defs = scopes_.back().defs;
  const auto known = defs.find(name);
  if (known == defs.end()) {
    constexpr size_t kMostSuggested = 50;  // finding the nearest name takes time
    std::vector<std::string> names;
    if (document_.remarks_.size() < kMostSuggested)
      for (const auto& entry : defs) names.push_back(entry.first);
    document_.remarks_.push_back(
        {offset, fmt::format("USE of '{}', which is not defined{}", name, suggestion(name, names)),
         "the DEF name of a node before it", "it is left out"});
    return nullptr;
  }
  X3dNode* found = known->second;
  while (found && open_.contains(found)) {
    const auto& earlier = scopes_.back().earlier;
    const auto before = earlier.find(found);
    found = before == earlier.end() ? nullptr : before->second;
  }
  if (!found) {
    // Scripts refer to what they are a part of, and nothing of them is taken.
    if (ignored_ == 0)
      document_.remarks_.push_back({offset, fmt::format("USE of '{}' inside itself", name),
                                    "a graph without cycles", "it is left out"});
    return nullptr;
  }
  X3dNode& node = *found;
  if (!type.empty() && node.type != type)
    document_.remarks_.push_back(
        {offset, fmt::format("{} with USE of '{}', which is a {}", type, name, node.type),
         "the same type", "the node of that name is taken"});
  ++node.uses;
  return &node;
}

void X3dTree::add_child(X3dNode& parent, const std::string& container, X3dNode* node) {
  if (!node) return;
  parent.height = std::max(parent.height, node->height + 1);
  if (parent.height > X3dDocument::kMaxHeight)
    throw document_.error(node->offset, "nodes nested too deep once USE and PROTO are followed",
                          fmt::format("at most {} levels", X3dDocument::kMaxHeight));
  parent.children.push_back({field_of(parent, container), node});
}

std::string X3dTree::field_of(const X3dNode& node, const std::string& name) {
  const bool is_old =
      (node.type == "Switch" && name == "choice") || (node.type == "LOD" && name == "level");
  return is_old ? "children" : name;
}

void X3dTree::begin_prototype() { scopes_.emplace_back(); }
void X3dTree::end_prototype() { scopes_.pop_back(); }

void X3dTree::declare(const std::string& name, X3dPrototype prototype) {
  if (scopes_.size() == 1 && first_prototype_.empty()) first_prototype_ = name;
  X3dPrototype& declared = scopes_.back().prototypes[name];
  declared = std::move(prototype);
  declared.defaults.emplace(declared.interface_node);
}

bool X3dTree::declare_elsewhere(const std::string& name, const std::vector<std::string>& urls,
                                size_t offset) {
  if (!find_) return false;
  std::string reason;
  const X3dPrototype* const found = find_(urls, document_.quotes_strings(), reason);
  if (!found) {
    document_.remarks_.push_back(
        {offset, fmt::format("the prototype '{}' is left out: {}", name, reason)});
    return false;
  }
  // Declared again, its name is not that of a prototype of this file.
  scopes_.back().prototypes.erase(name);
  X3dPrototype& declared = scopes_.back().prototypes[name];
  declared.interface_node = found->interface_node;
  declared.body = found->body;
  declared.file = found->file;
  declared.defaults.emplace(declared.interface_node);
  return true;
}

void X3dDocument::set_file_of_prototypes(const std::string* file) {
  for (auto& [name, prototype] : prototypes_->by_name)
    if (!prototype.file) prototype.file = file;
}

void X3dTree::end() {
  document_.prototypes_ = std::make_shared<X3dPrototypes>(
      X3dPrototypes{std::move(scopes_.front().prototypes), std::move(first_prototype_)});
}

const X3dPrototype* X3dTree::prototype(const std::string& name) const {
  for (auto scope = scopes_.rbegin(); scope != scopes_.rend(); ++scope) {
    const auto known = scope->prototypes.find(name);
    if (known != scope->prototypes.end()) return &known->second;
  }
  return nullptr;
}

X3dNode* X3dTree::instantiate(const X3dPrototype& prototype, const X3dNode& given) {
  if (!prototype.body) {
    X3dNode& nothing = place(given.offset);
    nothing.type = "Group";
    return &nothing;
  }
  Copying copying{prototype, given.offset, X3dGiven(given), {}};
  X3dNode* node = copy(*prototype.body, copying);
  node->def.clear();
  node->instance = given.offset;
  return node;
}

void X3dTree::count_copy(size_t offset, size_t bytes) {
  copied_bytes_ += bytes;
  if (++copies_ > kMaxCopies || copied_bytes_ > kMaxCopiedBytes)
    throw document_.error(offset, "prototypes that become too many nodes",
                          fmt::format("at most {} nodes and {} MiB of fields in all", kMaxCopies,
                                      kMaxCopiedBytes >> 20));
}

X3dNode* X3dTree::copy(const X3dNode& from, Copying& copying) {
  const auto [known, is_new] = copying.made.try_emplace(&from, nullptr);
  if (!is_new) {
    ++known->second->uses;
    return known->second;
  }
  const X3dPrototype& prototype = copying.prototype;
  X3dNode& node = place(prototype.file ? copying.offset : from.offset);
  known->second = &node;
  node.file = from.file ? from.file : prototype.file;
  size_t bytes = 0;
  for (const X3dField& field : from.fields) bytes += field.text.size();
  count_copy(copying.offset, bytes);
  node.type = from.type;
  node.def = from.def;
  node.fields = from.fields;
  if (prototype.file)
    for (X3dField& field : node.fields) field.offset = copying.offset;
  for (const X3dNode::Child& child : from.children)
    add_child(node, child.container, copy(*child.node, copying));
  for (const X3dNode::Is& is : from.is) fill(node, is, copying);
  return &node;
}

/// Gives a field what the instance says, else what the interface does.
void X3dTree::fill(X3dNode& node, const X3dNode::Is& is, Copying& copying) {
  const X3dGiven& given = copying.given;
  for (const X3dGiven* source : {&given, &*copying.prototype.defaults}) {
    const bool is_elsewhere = copying.prototype.file && source != &given;
    if (const X3dNode::Is* passed_on = source->passed_on(is.interface_field)) {
      node.is.push_back({is.field, passed_on->interface_field});
      return;
    }
    if (const X3dField* field = source->field(is.interface_field)) {
      node.fields.push_back({is.field, field->text, is_elsewhere ? copying.offset : field->offset});
      return;
    }
    const std::vector<X3dNode*>& children = source->children(is.interface_field);
    for (X3dNode* child : children) {
      count_copy(copying.offset, 0);
      if (!is_elsewhere) ++child->uses;
      add_child(node, is.field, is_elsewhere ? copy(*child, copying) : child);
    }
    if (!children.empty()) return;
  }
}

void X3dTree::set_unit(std::string_view category, std::string_view factor, size_t offset) {
  constexpr std::array<std::string_view, 4> kCategories{"angle", "force", "length", "mass"};
  double value = 0;
  const bool is_known = std::ranges::find(kCategories, category) != kCategories.end();
  const char* const rule = read_x3d_number(factor, value);
  if (!is_known)
    document_.remarks_.push_back({offset, fmt::format("a unit of '{}'", category),
                                  "angle, force, length or mass", "it is left out"});
  else if (rule || !(value >= double{std::numeric_limits<float>::min()}))
    document_.remarks_.push_back({offset, fmt::format("a {} unit of '{}'", category, factor),
                                  "a factor above 0 in the range of single precision",
                                  "it is left out"});
  else if (category == "length")
    document_.metres_per_unit_ = value;
  else if (category == "angle")
    document_.radians_per_unit_ = value;
}

void X3dTree::tell_of_second(std::string_view field, std::string_view owner, size_t offset) {
  document_.remarks_.push_back({offset, fmt::format("{} is given twice in {}", field, owner),
                                "one value", "the first one is taken"});
}

}  // namespace tessera
