#pragma once

#include <nlohmann/json.hpp>
#include <string>
#include <string_view>
#include <vector>

#include "studio/files/document.h"
#include "studio/files/draft_store.h"
#include "studio/files/folder.h"
#include "studio/scene_reading.h"
#include "studio/studio_orders.h"

namespace tessera {

// What the program says to a page, as text frames: {"KIND": {...}}.

/// The message for one client. Text that is no UTF-8 is replaced.
SendText page_answer(ClientId client, std::string_view kind, nlohmann::json fields);

/// `number`: as of page::MessageName. `existing`: what the page may have replaced all the same.
SendText refusal(ClientId client, std::string_view request, std::string_view file,
                 std::string_view why, uint64_t number = 0, const ExistingFiles& existing = {});
nlohmann::json document_json(const std::string& file, const Document& document, const Digest& hash,
                             bool is_read_only, bool is_dirty, const TextDraft* draft);
nlohmann::json draft_json(const TextDraft& draft);
/// The names that options of `tessera render` take, by their long names, and those of channels.
nlohmann::json choices_json();
/// The largest numbers that the page may ask for, those of options by their long names.
nlohmann::json limits_json();
/// What a new scene can begin with.
nlohmann::json templates_json();
/// The folders but the one that is served, each with the command line that opens it.
nlohmann::json recent_json(const std::vector<std::string>& folders, const std::string& served);
nlohmann::json files_json(const FileList& list);
nlohmann::json problems_json(const SceneReading& reading);
/// Of a reading that has a scene.
nlohmann::json summary_json(const SceneReading& reading);
/// What the picture holds at that pixel; without values where nothing is there.
nlohmann::json probed_json(const ViewId& view, int x, int y,
                           const std::optional<PictureStream::Value>& value);
/// Which worker traced which tile of a pass of that scale: [x, y, width, height, worker].
nlohmann::json tiles_json(const ViewId& view, const PassTiles& tiles, int scale);
nlohmann::json legend_json(const ViewId& view, const Legend& legend);
/// What the languages of files are called: by their endings.
std::string language_of(std::string_view file);

}  // namespace tessera
