#pragma once

#include <array>
#include <cstdint>
#include <map>
#include <optional>
#include <string>
#include <string_view>
#include <utility>
#include <variant>
#include <vector>

#include "front/free_camera.h"
#include "front/option_values.h"
#include "studio/files/document.h"
#include "studio/source_request.h"
#include "studio/view_filter.h"

namespace tessera::page {

// What a page says, as the text frames of its WebSocket have it: {"KIND": {...}}. Values; names are
// those of the wire. Positions in texts are offsets in UTF-16 code units.

/// The last version of a text that the page knows the program to have had.
struct KnownText {
  uint64_t version = 0;
  std::string sha256;  ///< of its UTF-8, in hexadecimal
};
struct Hello {
  std::string token;
  std::string resume;  ///< the id of the welcome that it had before; empty: none
  std::map<std::string, KnownText> have{};  ///< by the names of the files that it has open
};
struct List {};
struct Open {
  std::string file;
};
struct Close {
  std::string file;
  bool discard = false;  ///< with all that was not saved, and the draft of it
};
struct Reload {
  std::string file;
};
struct TakeOver {
  std::string file;
};
struct Edit {
  std::string file;
  uint64_t base = 0;
  std::vector<TextChange> changes;
};
struct Save {
  std::string file;
  std::string as;      ///< another name, at which nothing may be yet; empty: its own
  bool force = false;  ///< also over what was told last of the disk
  friend bool operator==(const Save&, const Save&) = default;
};
struct Recover {
  std::string file;
  bool take = false;
};

struct View {
  uint32_t pane = 0;
  std::string file;
  bool is_sample = false;  ///< `file` is one of those that ship with the program
  int width = 0, height = 0;
  std::string camera;                       ///< of the scene, by name; empty: its first
  std::optional<FreeCamera> free_camera{};  ///< that it was moved to
  bool moving = false;                      ///< that is being moved
  int frame = 0;
  std::string mode = "typing";  ///< or "save", "hand": when texts are rendered
  /// Options of `tessera render` by their long names, as they are typed there.
  std::vector<std::pair<std::string, std::string>> overrides{};
  std::string channel = "light";
  bool aovs = false;   ///< films are to have all values beside light, too
  bool tiles = false;  ///< the page is to be told which worker traced which tile
  std::vector<std::pair<std::string, std::string>> tone{};  ///< likewise options
  ViewFilter filter{};
  /// The digest of the scene whose picture the page has: of that scene none is made.
  std::string known{};
};
struct PaneOrder {
  enum class What { pause, resume, stop, refresh, close };
  uint32_t pane = 0;
  What what = What::refresh;
};
/// A picture that stays beside the one that a pane shows, to be held against it.
struct Pin {
  /// `shown`: what it shows now; `before`: the last whole picture of the scene as it was before.
  enum class What { shown, before, none };
  uint32_t pane = 0;
  What what = What::shown;
};
/// Asks how what the pane shows differs from what is pinned there.
struct Compare {
  uint32_t pane = 0;
};
struct Probe {
  uint32_t pane = 0;
  int x = 0, y = 0;
};
struct Pick {
  uint32_t pane = 0;
  int x = 0, y = 0;
};
struct Parts {
  uint32_t pane = 0;
};
/// Asks where the entities of the scene are that starts in the file.
struct Centers {
  std::string file;
};
/// New files: what a template makes, a scene that places a model, or a copy of a sample.
struct Create {
  std::string from_template, model, sample;
};
/// A file that follows in chunks.
struct Put {
  std::string name;  ///< below the folder
  uint64_t size = 0;
  uint32_t number = 0;  ///< that its chunks have
};
struct Settings {
  std::string json;  ///< an object, kept for the page as it is
};
/// Which files of the folder are open, and where they are looked at.
struct Workspace {
  std::string json;  ///< likewise
};

/// Of one order: their files are looked for one by one.
constexpr int kMostFrames = 100'000;
/// Of each side of a pane's picture.
constexpr int kMostViewSide = 16384;
/// The largest picture of a pane: 7680x4320.
constexpr int64_t kMostViewPixels = 33'177'600;

/// A full picture, or one of each frame, as `tessera render` makes them.
struct Render {
  uint64_t number = 0;  ///< of the order, which what is answered to it repeats; 0: none
  std::string file;
  std::string camera;                       ///< as of View
  std::optional<FreeCamera> free_camera{};  ///< in its place
  std::optional<int> frame{};               ///< of the animation
  std::optional<FrameRange> frames{};       ///< in its place: one picture each
  std::optional<double> frame_rate{};       ///< of files that hold all frames; > 0
  /// Options of `tessera render`, as of View::overrides and View::tone.
  std::vector<std::pair<std::string, std::string>> options{};
  std::vector<std::string> outputs{};  ///< files below the folder; none: it is kept in memory
  bool statistics = false;             ///< also as a file, beside the first output
  bool force = false;                  ///< also over files that are there
};
struct RenderOrder {
  enum class What { pause, resume, cancel, forget };
  uint64_t job = 0;
  What what = What::cancel;
};
/// A file of what there is: the scene where the name's ending is that of a scene, else the picture.
struct Export {
  uint64_t number = 0;            ///< as of Render
  std::optional<uint64_t> job{};  ///< the full picture
  uint32_t pane = 0;              ///< whose picture it is without a job
  std::string name;               ///< below the folder, or of the download
  bool is_download = false;
  bool is_shown = false;                   ///< a download that the page shows
  bool statistics = false, force = false;  ///< as of Render
  /// Asks for the command line alone that makes that picture.
  std::optional<Render> command{};
  std::string file;  ///< the scene's
};

using Message = std::variant<Hello, List, Open, Close, Reload, TakeOver, Edit, Save, Recover, View,
                             PaneOrder, Pin, Compare, Probe, Pick, Parts, Centers, Source, Create,
                             Put, Settings, Workspace, Render, RenderOrder, Export>;

/// What a message calls itself, which is known also where its other fields are wrong.
struct MessageName {
  std::string kind;
  uint64_t number = 0;  ///< by which the page knows the answer; 0: none
};

/// A message, nothing for a kind that is not known, which is to be ignored. Throws Error with what
/// was found and expected where it is none: no JSON, nested too deep, a field of another type.
/// Sets `name`, if it is given, to what is known of it.
std::optional<Message> parse_message(std::string_view text, MessageName* name = nullptr);

/// Whether it changes nothing but what its page sees, so that a viewer may say it.
bool is_for_viewers(const Message& message);

}  // namespace tessera::page
