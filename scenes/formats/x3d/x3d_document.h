#pragma once

#include <deque>
#include <map>
#include <string>
#include <string_view>
#include <vector>

#include "base/error.h"

namespace tessera {

/// A field as written, and where its text begins in the file.
struct X3dField {
  std::string name;
  std::string_view text;  ///< inside the document's text
  size_t offset = 0;
};

/// A node of the scene graph; USE makes it a child of several.
struct X3dNode {
  struct Child {
    std::string container;  ///< the field of the parent that holds it
    const X3dNode* node = nullptr;
  };

  std::string type;
  std::string def;  ///< empty: not named
  std::vector<X3dField> fields;
  std::vector<Child> children;
  size_t offset = 0;
  int uses = 1;  ///< the places where it stands

  const X3dField* field(std::string_view name) const;
  /// The last child in that field, or null.
  const X3dNode* child(std::string_view container) const;
};

/// The nodes of a file in whatever encoding, with DEF and USE resolved. The graph has no cycle.
class X3dDocument {
 public:
  static constexpr int kMaxDepth = 80;

  /// Reads the XML encoding; `name` is what errors call it. Nothing else is ever opened.
  static X3dDocument parse_xml(std::string_view text, const std::string& name);

  X3dDocument(X3dDocument&&) = default;
  X3dDocument& operator=(X3dDocument&&) = default;

  const X3dNode& scene() const { return *scene_; }
  /// Every node once, in the order of the file.
  const std::deque<X3dNode>& nodes() const { return nodes_; }
  /// 10 * major + minor: 30 to 41; 33 where the file does not say.
  int version() const { return version_; }
  const std::map<std::string, std::string>& metadata() const { return metadata_; }
  /// What was met on the way that a user should hear of, without the file's name.
  const std::vector<std::string>& remarks() const { return remarks_; }

  SourcePlace place(size_t offset) const;
  Error error(size_t offset, std::string_view found, std::string_view expected) const;

 private:
  friend class X3dXmlReader;
  X3dDocument() = default;

  std::string name_;
  std::string source_;  ///< the text as it came, for places
  std::string text_;    ///< the text that the fields point into
  std::deque<X3dNode> nodes_;
  const X3dNode* scene_ = nullptr;
  int version_ = 33;
  std::map<std::string, std::string> metadata_;
  std::vector<std::string> remarks_;
};

/// "Sphere 'S'" or "a Sphere".
std::string describe(const X3dNode& node);

}  // namespace tessera
