#pragma once

#include <map>
#include <optional>
#include <set>
#include <string>
#include <vector>

#include "scenes/formats/x3d/document/x3d_document.h"

namespace tessera {

/// What a prototype's fields are given: the fields, children and passed-on fields of a node by
/// name. Refers to the node.
class X3dGiven {
 public:
  explicit X3dGiven(const X3dNode& node);

  const X3dNode::Is* passed_on(std::string_view interface_field) const;
  const X3dField* field(std::string_view name) const;
  const std::vector<X3dNode*>& children(std::string_view container) const;

 private:
  std::map<std::string_view, const X3dNode::Is*> is_;
  std::map<std::string_view, const X3dField*> fields_;
  std::map<std::string_view, std::vector<X3dNode*>> children_;
};

/// PROTO, however it is written. Stays where it is once it is declared.
struct X3dPrototype {
  X3dNode interface_node;              ///< its fields and children are the defaults
  X3dNode* body = nullptr;             ///< the first node, which an instance becomes; may be null
  const std::string* file = nullptr;   ///< as X3dNode has it; null: of the document's own file
  std::optional<X3dGiven> defaults{};  ///< of interface_node; the tree sets it
};

struct X3dPrototypes {
  std::map<std::string, X3dPrototype> by_name;
  std::string first;  ///< the name of the one that stands first; empty: there is none
};

/// What the readers of all encodings build a document's nodes with: names, prototypes and limits.
class X3dTree {
 public:
  static constexpr size_t kMaxCopies = 200000;          ///< nodes that prototypes become
  static constexpr size_t kMaxCopiedBytes = 64u << 20;  ///< of text in their fields
  /// So many fields of a node are looked through for a second one of a name, which takes time in
  /// their number.
  static constexpr size_t kMaxSearched = 100;

  X3dTree(X3dDocument& document, const X3dPrototypeFinder& find)
      : document_(document), find_(find) {
    scopes_.emplace_back();
  }

  /// Throws where something is written at too many levels below the scene.
  void check_depth(size_t offset, int depth) const;
  /// A new node at `depth` levels below the scene.
  X3dNode& add(std::string type, size_t offset, int depth);
  /// What follows until finish() are the node's parts. Of one with a name, which may be empty, the
  /// node itself must not be among them.
  void begin(X3dNode& node, std::string name);
  void finish(const X3dNode& node);
  /// The last node of that name before it, none that it is a part of; null where there is none,
  /// which is told unless the part is ignored. `type` may be empty: any.
  X3dNode* use(const std::string& name, std::string_view type, size_t offset);
  void add_child(X3dNode& parent, const std::string& container, X3dNode* node);
  /// What a field of that node is called, which VRML97 may call otherwise.
  static std::string field_of(const X3dNode& node, const std::string& name);

  /// Between these, nodes are a prototype's, with names and prototypes of their own.
  void begin_prototype();
  void end_prototype();
  void declare(const std::string& name, X3dPrototype prototype);
  /// Declares what is in another file. False, which is told where files may be read, where it
  /// cannot be found.
  bool declare_elsewhere(const std::string& name, const std::vector<std::string>& urls,
                         size_t offset);
  /// Gives the document its prototypes, when all is read.
  void end();
  /// The prototype of that name, or null. Stays where it is.
  const X3dPrototype* prototype(const std::string& name) const;
  /// A copy of the prototype's body with the fields and children of `given` in place of its own.
  X3dNode* instantiate(const X3dPrototype& prototype, const X3dNode& given);

  /// `factor` as it is written, at `offset`.
  void set_unit(std::string_view category, std::string_view factor, size_t offset);
  /// Tells of a field, which begins at `offset`, that `owner` has already.
  void tell_of_second(std::string_view field, std::string_view owner, size_t offset);

 private:
  struct Scope {
    std::map<std::string, X3dNode*> defs;
    std::map<const X3dNode*, X3dNode*> earlier;  ///< the node that had that node's name before it
    std::map<std::string, X3dPrototype> prototypes;
  };
  struct Copying {
    const X3dPrototype& prototype;
    size_t offset;  ///< of the instance
    X3dGiven given;
    std::map<const X3dNode*, X3dNode*> made;
  };

  X3dNode& place(size_t offset);
  void count_copy(size_t offset, size_t bytes);
  X3dNode* copy(const X3dNode& from, Copying& copying);
  void fill(X3dNode& node, const X3dNode::Is& is, Copying& copying);

  X3dDocument& document_;
  const X3dPrototypeFinder& find_;
  std::string first_prototype_;  ///< outside of others
  std::vector<Scope> scopes_;
  std::set<const X3dNode*> open_;
  int ignored_ = 0;  ///< nodes around what is read now that are left out whole
  size_t copies_ = 0, copied_bytes_ = 0;
};

}  // namespace tessera
