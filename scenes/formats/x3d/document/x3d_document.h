#pragma once

#include <deque>
#include <functional>
#include <map>
#include <memory>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "base/error.h"

namespace tessera {

/// A field as written, and where its text begins in the file.
struct X3dField {
  std::string name;
  std::string_view text;  ///< inside the document's text; strings of the classic encoding in quotes
  size_t offset = 0;
};

/// A node of the scene graph; USE makes it a child of several.
struct X3dNode {
  struct Child {
    std::string container;  ///< the field of the parent that holds it
    X3dNode* node = nullptr;
  };
  /// A field whose value comes from the interface of the prototype that the node is a part of.
  struct Is {
    std::string field, interface_field;
  };

  std::string type;
  std::string def;  ///< empty: not named
  std::vector<X3dField> fields;
  std::vector<Child> children;
  std::vector<Is> is;  ///< empty outside of prototypes
  size_t offset = 0;
  /// The file that a prototype of another file is in, as X3dPrototype has it, for what URLs mean:
  /// `offset` and those of the fields are then the instance's. Null: the document's own file.
  const std::string* file = nullptr;
  std::optional<size_t> instance{};  ///< of the prototype that it came of: where that stands
  int uses = 1;                      ///< the places where it stands
  int height = 1;                    ///< levels of nodes from here down

  const X3dField* field(std::string_view name) const;
  /// The last child in that field, or null.
  const X3dNode* child(std::string_view container) const;
};

struct X3dPrototype;
/// The prototypes of a file that stand in no other.
struct X3dPrototypes;

/// Finds the prototype that the URLs of an EXTERNPROTO name. It outlives the document that asks, in
/// which strings stand in quotes or not. Null, and `reason`, where there is none.
using X3dPrototypeFinder = std::function<const X3dPrototype*(
    const std::vector<std::string>& urls, bool quotes_strings, std::string& reason)>;

/// The nodes of a file in whatever encoding, with DEF, USE and prototypes resolved. The graph has
/// no cycle.
class X3dDocument {
 public:
  static constexpr int kMaxDepth = 80;    ///< levels as written
  static constexpr int kMaxHeight = 400;  ///< levels with USE and prototypes followed
  static constexpr size_t kMaxBytes = size_t{512} << 20;

  /// Reads what a file holds, of any of the three encodings, by its first bytes; gzipped or not.
  /// `name` is what errors call it. Nothing else is ever opened, but by `find`; without it the
  /// prototypes of other files are ignored. Throws scene_error.
  static X3dDocument parse(std::string_view bytes, const std::string& name,
                           const X3dPrototypeFinder& find = {});

  X3dDocument(X3dDocument&&) = default;
  X3dDocument& operator=(X3dDocument&&) = default;

  const X3dNode& scene() const { return *scene_; }
  /// Every node once, in the order of the file; those of prototypes where they are instantiated.
  const std::deque<X3dNode>& nodes() const { return nodes_; }
  /// Of all, those of prototypes too.
  size_t node_count() const { return nodes_.size() + templates_.size(); }
  /// 10 * major + minor: 20 (VRML97), 30 to 41; 33 where the file does not say.
  int version() const { return version_; }
  /// Whether strings stand in quotes: not in XML, where only lists of them do.
  bool quotes_strings() const { return quotes_strings_; }
  double metres_per_unit() const { return metres_per_unit_; }
  size_t length() const { return source_.size(); }  ///< of the text, in bytes
  double radians_per_unit() const { return radians_per_unit_; }
  const std::map<std::string, std::string>& metadata() const { return metadata_; }
  /// What was met on the way that a user should hear of.
  struct Remark {
    size_t offset;
    std::string text;
    std::string expected{}, taken{};  ///< of what breaks a rule, as of Warnings::repair()
  };
  const std::vector<Remark>& remarks() const { return remarks_; }
  const X3dPrototypes& prototypes() const { return *prototypes_; }
  /// Says of all prototypes of this file that they are in the one of that name, which outlives
  /// them.
  void set_file_of_prototypes(const std::string* file);
  const std::string& name() const { return name_; }

  SourcePlace place(size_t offset) const;
  Error error(size_t offset, std::string_view found, std::string_view expected) const;

 private:
  friend class X3dTree;
  friend class X3dXmlReader;
  friend class X3dClassicReader;
  /// Without nodes as yet.
  X3dDocument(std::string_view text, const std::string& name, bool quotes_strings)
      : name_(name), source_(text), text_(text), quotes_strings_(quotes_strings) {}

  static X3dDocument parse_xml(std::string_view text, const std::string& name,
                               const X3dPrototypeFinder& find);
  static X3dDocument parse_classic(std::string_view text, const std::string& name,
                                   const X3dPrototypeFinder& find);

  std::string name_;
  std::string source_;  ///< the text as it came, for places
  std::string text_;    ///< the text that the fields point into
  std::deque<X3dNode> nodes_;
  std::deque<X3dNode> templates_;  ///< the bodies of prototypes
  const X3dNode* scene_ = nullptr;
  int version_ = 33;
  bool quotes_strings_ = false;
  double metres_per_unit_ = 1, radians_per_unit_ = 1;
  std::map<std::string, std::string> metadata_;
  std::vector<Remark> remarks_;
  std::shared_ptr<X3dPrototypes> prototypes_;
};

/// "Sphere 'S'" or "a Sphere".
std::string describe(const X3dNode& node);

}  // namespace tessera
