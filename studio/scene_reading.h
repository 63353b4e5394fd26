#pragma once

#include <cstdint>
#include <filesystem>
#include <functional>
#include <map>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "front/render_frame.h"
#include "renderer/math/bounds.h"
#include "scenes/formats/scene_summary.h"
#include "scenes/import/read_cache.h"
#include "studio/files/document.h"
#include "studio/view_filter.h"

namespace tessera {

/// Something that is wrong with a text, or unusual in it. Lines and columns count from 1, columns
/// in UTF-16 code units; 0: not known.
struct Problem {
  bool is_error = true;
  /// Its path below the opened folder; of a file elsewhere its path as the system has it.
  std::string file{};
  size_t line = 0, column = 0, end_line = 0, end_column = 0;
  std::string message{}, found{}, expected{}, suggestion{};
  friend bool operator==(const Problem&, const Problem&) = default;
};

/// Open documents by their names below the folder. What is not among them is read from disk.
using OpenTexts = std::map<std::string, Document>;

/// A scene to be read.
struct ReadOrder {
  std::string file{};      ///< where it starts, below the folder
  bool is_sample = false;  ///< below that of the samples, where no texts stand for files
  int frame = 0;           ///< of its animation
  uint64_t revision = 0;   ///< of the texts: newer is larger
  OpenTexts texts;
  ViewFilter filter{};
  uint64_t job = 0;  ///< the full picture that it is for; 0: for views
  std::shared_ptr<const RenderOptions> options{};  ///< of that; null: the scene's
  /// What building the scene of that digest failed with: where the texts still make that scene, its
  /// place in them is told.
  std::string failure{}, failed_digest{};
};

/// A scene as it was read. Never changes.
struct SceneReading {
  std::string file{};
  bool is_sample = false;  ///< as of the order
  int frame = 0;
  uint64_t revision = 0;
  uint64_t version = 0;  ///< of the document of `file`; 0 where it is not open
  uint64_t job = 0;      ///< as of the order
  /// Null where the texts are wrong: then a problem says why.
  std::shared_ptr<const FrameScene> scene;
  OpenTexts texts{};  ///< that it was read from
  /// Where its files may lie, as of InputRoots.
  std::vector<std::filesystem::path> roots{};
  ViewFilter filter{};
  /// The nodes that views leave out for it, by their numbers; the scene has them.
  std::vector<uint32_t> hidden{};
  SceneSummary summary{};
  Bounds3 bounds{};              ///< as of rough_bounds()
  v1::FrameSettings settings{};  ///< of its own picture
  std::vector<Problem> problems{};
  int64_t read_at = 0;  ///< milliseconds since 1970
  double seconds = 0;   ///< that it took
};

/// How files are read for the studio. What it refers to is shared by all readings.
struct ReadingPlaces {
  std::string folder;     ///< the opened one, absolute
  std::string assets{};   ///< as of ReadOptions; empty: the opened folder
  std::string samples{};  ///< of those that ship with the program, absolute
  ReadCache* cache = nullptr;
};

/// Reads the scene: on the thread that calls, for as long as it takes. Throws nothing that is wrong
/// with the texts.
SceneReading read_for_studio(const ReadOrder& order, const ReadingPlaces& places);

}  // namespace tessera
