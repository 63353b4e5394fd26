#pragma once

#include <array>
#include <cstdint>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "proto/tessera/v1/scene.pb.h"
#include "renderer/film/aov.h"
#include "scenes/edit/outline.h"
#include "studio/files/document.h"
#include "studio/scene_reading.h"
#include "studio/source_json.h"

namespace tessera {

/// What a pixel shows, by the AOVs origin and primitive.
struct ScenePart {
  std::array<uint32_t, kOriginDepth> nodes{};
  uint32_t primitive = 0;  ///< from 1; 0: not asked for
  friend auto operator<=>(const ScenePart&, const ScenePart&) = default;
};

/// One of the things that what a pixel shows is, or stands in.
struct SourceLink {
  std::string kind;      ///< of an entity, or "face", "file"
  std::string name{};    ///< or else its type
  std::string file{};    ///< below the folder, or, elsewhere, as the system has it
  std::string entity{};  ///< as the file's outline calls it; empty: it has none
  uint64_t version = 0;  ///< of the text, where it is an open document; else 0
  std::optional<TextPosition> begin{}, end{};
  friend bool operator==(const SourceLink&, const SourceLink&) = default;
};

/// The innermost first.
struct SourceChain {
  std::vector<SourceLink> links;
  size_t at = 0;  ///< the link that a click selects: what is shown, not its material or face
  friend bool operator==(const SourceChain&, const SourceChain&) = default;
};

/// Leads from what a picture shows to the texts that its scene was read from. Reads the texts when
/// they are first asked for; used by one thread.
class SourceMap {
 public:
  /// `folder`: the opened one. The reading must have a scene.
  SourceMap(std::shared_ptr<const SceneReading> reading, std::string folder);
  ~SourceMap();

  SourceChain chain(const ScenePart& part);
  const SceneReading& reading() const { return *reading_; }

 private:
  struct File;

  File& file(uint32_t number);
  void add_node(uint32_t node, const std::vector<uint32_t>& outer, SourceChain& chain);
  void add_origin(uint32_t number, SourceChain& chain);
  void add_surface(const ScenePart& part, SourceChain& chain);
  std::optional<SourceLink> material(const std::string& name);

  std::shared_ptr<const SceneReading> reading_;
  std::string folder_;
  std::vector<const v1::Node*> nodes_;        ///< by number, from 1
  std::vector<std::unique_ptr<File>> files_;  ///< as of OriginTable
};

}  // namespace tessera
