#include "studio/scene_reading.h"

#include <fmt/format.h>

#include <algorithm>
#include <chrono>
#include <filesystem>
#include <map>
#include <optional>
#include <utility>
#include <vector>

#include "base/error.h"
#include "base/file.h"
#include "base/input_scope.h"
#include "base/open_input.h"
#include "front/load_frame.h"
#include "front/located.h"
#include "front/render_options.h"
#include "scenes/edit/outline.h"
#include "scenes/import/asset_folder.h"
#include "studio/scene_extent.h"
#include "studio/source_map.h"
#include "studio/wall_clock.h"

namespace tessera {
namespace {

namespace fs = std::filesystem;

/// Makes problems of what readers say, whose places are in files as the system has them.
class ProblemMaker {
 public:
  ProblemMaker(const ReadOrder& order, const ReadingPlaces& places)
      : order_(order), folder_(order.is_sample ? places.samples : places.folder) {}

  Problem make(bool is_error, const Diagnostic& diagnostic, std::string message) const {
    Problem problem{.is_error = is_error,
                    .message = std::move(message),
                    .found = diagnostic.found,
                    .expected = diagnostic.expected,
                    .suggestion = diagnostic.suggestion};
    const SourcePlace& place = diagnostic.place;
    problem.file = place.file.empty() ? order_.file : name_of(place.file);
    set_range(place, diagnostic.end, problem);
    return problem;
  }
  /// Below the folder, where it is there.
  std::string name_of(const std::string& path) const {
    const fs::path relative = fs::path(path).lexically_relative(folder_);
    return relative.empty() || *relative.begin() == ".." ? path : relative.generic_string();
  }
  /// The text of the file, as it is open or as the disk has it; null where neither is known.
  const Document* text_of(const std::string& file) const {
    if (const auto open = order_.texts.find(file); open != order_.texts.end()) return &open->second;
    const auto [at, is_new] = on_disk_.try_emplace(file);
    if (is_new) {
      try {
        at->second = Document(read_input_file((folder_ / file).string(), Document::kMostBytes));
      } catch (const Error&) {
        // A file that is too long, or gone, has places alone.
      }
    }
    return at->second ? &*at->second : nullptr;
  }

 private:
  void set_range(const SourcePlace& place, const SourcePlace& end, Problem& problem) const {
    if (place.line <= 0) return;
    const auto at = [](int number) { return static_cast<size_t>(std::max(number, 0)); };
    const Document* const text = text_of(problem.file);
    if (!text) {
      problem.line = problem.end_line = at(place.line);
      problem.column = problem.end_column = at(place.column);
      return;
    }
    const LineRule rule = line_rule_of(problem.file);
    const auto position = [&](const SourcePlace& of) {
      return text->position_of_place(at(of.line), at(of.column), rule);
    };
    const TextPosition from = position(place);
    const std::string bytes = text->bytes();
    const SourcePlace behind = end.line > 0 ? end : end_of_word(skip_byte_order_mark(bytes), place);
    const TextPosition to = behind.line > 0 ? position(behind) : from;
    problem.line = from.line;
    problem.column = from.column;
    problem.end_line = to.line;
    problem.end_column = to.column;
  }

  const ReadOrder& order_;
  fs::path folder_;
  mutable std::map<std::string, std::optional<Document>> on_disk_;  ///< of files that are not open
};

/// Without the place that it begins with, and the lines of the source below it.
std::string without_place(std::string_view text, const SourcePlace& place) {
  const std::string begin = place.str() + ": ";
  if (text.starts_with(begin)) text.remove_prefix(begin.size());
  return std::string(text.substr(0, text.find('\n')));
}

/// What is said of it, without its place.
std::string message_of(const Diagnostic& diagnostic) {
  std::string out = diagnostic.found;
  if (!diagnostic.expected.empty()) out += "; expected " + diagnostic.expected;
  if (!diagnostic.suggestion.empty()) out += "; did you mean '" + diagnostic.suggestion + "'?";
  return out;
}

RenderOptions options_of(const ReadOrder& order, const ReadingPlaces& places) {
  RenderOptions options = order.options ? *order.options : RenderOptions();
  options.reading.cache = places.cache;
  options.reading.origins = true;
  if (order.is_sample) {
    options.scene = (fs::path(places.samples) / order.file).string();
    return options;
  }
  options.scene = (fs::path(places.folder) / order.file).string();
  options.reading.assets = places.assets.empty() ? places.folder : places.assets;
  options.reading.text_of = [&order, folder = fs::path(places.folder)](
                                const fs::path& path) -> std::shared_ptr<const std::string> {
    const auto open = order.texts.find(path.lexically_relative(folder).generic_string());
    // Of a file that is too long the page has the beginning alone; nobody edits it.
    if (open == order.texts.end() || !open->second.is_editable()) return nullptr;
    return std::make_shared<const std::string>(open->second.bytes());
  };
  return options;
}

/// The folders that files are read from.
std::vector<fs::path> roots_of(const ReadOrder& order, const ReadingPlaces& places) {
  std::vector<fs::path> roots{order.is_sample ? whole_path(places.samples)
                                              : fs::path(places.folder)};
  if (!order.is_sample && !places.assets.empty()) roots.push_back(whole_path(places.assets));
  return roots;
}

/// Links that lead out of the folder are not followed, as Folder does not.
void check_place(const ReadOrder& order, const ReadingPlaces& places) {
  if (order.is_sample || resolve_inside(places.folder, order.file)) return;
  throw scene_error("'" + order.file + "' leads out of the folder, or nowhere");
}

void note_error(const Error& error, const ProblemMaker& maker, SceneReading& reading) {
  if (error.diagnostics().empty()) {
    reading.problems.push_back(maker.make(true, {}, error.what()));
    return;
  }
  if (error.diagnostics().size() == 1) {
    const Diagnostic& only = error.diagnostics().front();
    reading.problems.push_back(maker.make(true, only, without_place(error.what(), only.place)));
    return;
  }
  for (const Diagnostic& diagnostic : error.diagnostics())
    reading.problems.push_back(maker.make(true, diagnostic, message_of(diagnostic)));
}

/// The range that tells the entity from others: its name, where the text has it, else all of it.
edit::SourceRange telling_range(const edit::Entity& entity) {
  const auto name = std::find_if(entity.fields.begin(), entity.fields.end(),
                                 [](const edit::Field& field) { return field.name == "name"; });
  return name == entity.fields.end() ? entity.range : name->value;
}

/// Where the text of the scene's own file defines what its summary calls "material 'red'". Nothing
/// of long texts, whose outlines would make each key wait.
std::map<std::string, edit::SourceRange> defined_places(const std::string& file,
                                                        const Document& text) {
  constexpr size_t kMostUnits = size_t{1} << 20;
  const auto language = edit::language_of(file);
  std::map<std::string, edit::SourceRange> places;
  if (!language || text.units() > kMostUnits) return places;
  const edit::Outline outline = edit::outline(*language, text.text());
  for (const edit::Entity& entity : outline.entities()) {
    if (entity.name.empty()) continue;
    places.try_emplace(fmt::format("{} '{}'", edit::name_of(entity.kind), entity.name),
                       telling_range(entity));
  }
  return places;
}

void note_unused(const std::vector<std::string>& unused, const ProblemMaker& maker,
                 SceneReading& reading) {
  if (unused.empty()) return;
  const Document* const text = maker.text_of(reading.file);
  std::map<std::string, edit::SourceRange> places;
  if (text) places = defined_places(reading.file, *text);
  for (const std::string& what : unused) {
    Problem problem = maker.make(false, {}, what + " is not used");
    if (const auto at = places.find(what); at != places.end()) {
      const auto position = [&](uint32_t byte) {
        return text->position_of(text->offset_of_text_byte(byte));
      };
      const TextPosition begin = position(at->second.begin), end = position(at->second.end);
      problem.line = begin.line;
      problem.column = begin.column;
      problem.end_line = end.line;
      problem.end_column = end.column;
    }
    reading.problems.push_back(std::move(problem));
  }
}

}  // namespace

SceneReading read_for_studio(const ReadOrder& order, const ReadingPlaces& places) {
  const auto begin = std::chrono::steady_clock::now();
  SceneReading reading{.file = order.file,
                       .is_sample = order.is_sample,
                       .frame = order.frame,
                       .revision = order.revision,
                       .job = order.job,
                       .scene = {}};
  if (const auto open = order.texts.find(order.file); open != order.texts.end())
    reading.version = open->second.version();
  reading.texts = order.texts;
  reading.roots = roots_of(order, places);
  reading.filter = order.filter;
  const ProblemMaker maker(order, places);
  const RenderOptions options = options_of(order, places);
  // Also for errors, whose texts are read for their positions.
  const InputRoots roots(reading.roots);
  try {
    check_place(order, places);
    auto scene =
        std::make_shared<FrameScene>(measured([&] { return load_frame(options, order.frame); }));
    for (const Diagnostic& warning : scene->loaded.warning_diagnostics)
      reading.problems.push_back(maker.make(false, warning, warning.found));
    reading.summary = summarize(scene->loaded.scene, scene->loaded.blobs);
    note_unused(reading.summary.unused, maker, reading);
    note_unused(scene->loaded.unused, maker, reading);
    reading.bounds = rough_bounds(scene->loaded);
    reading.settings =
        FrameRender(options, *scene,
                    scene->loaded.depends_on_frame ? std::optional(order.frame) : std::nullopt)
            .settings();
    reading.scene = std::move(scene);
    if (!order.filter.empty()) {
      SourceMap map(std::make_shared<const SceneReading>(reading), places.folder);
      reading.hidden = hidden_nodes(order.filter, map);
    }
    if (!order.failure.empty() && order.failed_digest == reading.scene->digest)
      note_error(located(options.scene, order.failure), maker, reading);
  } catch (const Error& error) {
    note_error(error, maker, reading);
  } catch (const std::bad_alloc&) {
    reading.problems.push_back(maker.make(true, {}, "the scene does not fit into memory"));
  }
  reading.read_at = milliseconds_since_1970();
  reading.seconds = std::chrono::duration<double>(std::chrono::steady_clock::now() - begin).count();
  return reading;
}

}  // namespace tessera
