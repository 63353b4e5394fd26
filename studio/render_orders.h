#pragma once

#include <cstdint>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "front/animation_files.h"
#include "renderer/film/tone_map.h"
#include "studio/file_tasks.h"
#include "studio/full_frame.h"

namespace tessera {

// What full pictures and exports ask of the threads around the state machine. Plain values.

/// Has the frame traced, going on from tiles that were finished before.
struct TraceFrame {
  uint64_t job = 0;
  FullFrame frame;
};
/// Ends the tracing of that job, of whose end nothing is told any more.
struct EndFrame {
  uint64_t job = 0;
  bool keeps_tiles = false;  ///< it will be traced on
};
/// How the tracing of a frame ended.
struct FrameEnd {
  uint64_t job = 0;
  std::shared_ptr<JobResult> result{};  ///< null where it could not be begun
  std::string failure{};                ///< why, if that is so
  double seconds = 0;
};

/// Where files go.
struct FileGoal {
  std::vector<std::string> names{};  ///< below the folder; of a download its one name
  bool is_download = false;
  bool is_shown = false;        ///< of a download: the page shows it instead of saving it
  bool statistics = false;      ///< also as a file, beside the first
  bool force = false;           ///< also over files that are there
  std::optional<int> number{};  ///< of the frame, which the names get; nothing: it is the only one
  /// Of files that hold all frames, which are written with the last one; null: there is one frame.
  std::shared_ptr<AnimationFiles> animations{};
  bool is_first_frame = false, is_last_frame = false;  ///< of those
};
/// Makes a picture of what was traced, and its files.
struct FinishFrame {
  uint64_t job = 0;
  FullFrame frame;
  std::shared_ptr<JobResult> result;
  double seconds = 0;
  FileGoal goal;
};
struct FrameFinished {
  uint64_t job = 0;
  std::shared_ptr<const RenderedPicture> picture{};  ///< null where that failed
  std::vector<std::string> written;                  ///< below the folder
  std::string failure;                               ///< what failed; empty: nothing
};
/// Makes a file of a picture or scene that there is.
struct ExportFile {
  ClientId client = 0;
  uint64_t number = 0;  ///< of the page's order, as of page::Export
  FullFrame frame{};
  std::shared_ptr<const RenderedPicture> picture{};  ///< null: the scene is exported
  OutputSettings output{};
  FileGoal goal{};
};
struct FileExported {
  std::string name;
  std::string failure{};                         ///< empty: it is done
  ExistingFiles existing{};                      ///< as of FileFailed
  std::shared_ptr<const std::string> content{};  ///< of a download; else null
  bool is_shown = false;                         ///< as of FileGoal
  std::string statistics{};                      ///< to download beside it; empty: none
};
/// The same of what is done of a full picture that is being traced.
struct ExportUnfinished {
  ExportFile file;
  uint64_t job = 0;
};
/// Makes a file of the picture that a pane shows, which another thread has.
struct ExportView {
  ClientId client = 0;
  uint64_t number = 0;  ///< as of ExportFile
  uint32_t pane = 0;
  FileGoal goal;
};

/// "room.stats.json" beside "room.png".
std::string statistics_name(const std::string& picture_name);

}  // namespace tessera
