#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <optional>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "front/free_camera.h"
#include "scenes/edit/placement.h"
#include "studio/client_id.h"
#include "studio/files/document.h"

namespace tessera::page {

/// What a page asks of the text of a document, at version `base`. Only the fields that `what` needs
/// are set.
struct Source {
  enum class What {
    set,             ///< `field` of `entity` becomes `text`
    reset,           ///< `field` of `entity` is left out of the text, so that it has its default
    add,             ///< what the template `kind` makes, in `entity`; "include" and "panorama":
                     ///< of the file `text`
    remove,          ///< `entity`
    duplicate,       ///< `entity`
    write_camera,    ///< `camera` becomes the one called `text`, or the first
    write_settings,  ///< `options` of `tessera render` become the scene's settings
    place,           ///< `entity`, or without one a new include, gets `placement`
    fields,          ///< of `entity`, those included that the text does not have
    placement,       ///< of `entity`
    complete,        ///< what can be typed at `offset`
    hover,           ///< what is known of the word at `offset`
    camera_text,     ///< what write_camera would leave of the camera's text
  };
  What what = What::fields;
  std::string file;
  uint64_t base = 0;
  std::string entity{}, field{}, text{}, kind{};
  std::optional<FreeCamera> camera{};
  double aspect = 0;  ///< of the picture that it sees, width over height; 0: unknown
  std::optional<edit::Placement> placement{};
  std::optional<std::array<double, 3>> position{};  ///< of what is added
  std::vector<std::pair<std::string, std::string>> options{};
  size_t offset = 0;    ///< in UTF-16 code units
  uint64_t number = 0;  ///< of the question, which the answer repeats

  bool changes_text() const;
};

/// The name of the message that asks for it.
const char* name_of(Source::What what);
/// What the message of that name asks for; nothing where it is about no text.
std::optional<Source::What> source_of(std::string_view message);

}  // namespace tessera::page

namespace tessera {

/// To be answered by SourceReader.
struct SourceOrder {
  ClientId client = 0;
  page::Source request;
  Document document;
};

/// The outline of a document is to be made.
struct OutlineOrder {
  std::string file;
  uint64_t ticket = 0;  ///< which the result has too
  Document document;
};

/// The entities of a document's text, as pages are told of them. Never changes.
struct FileOutline {
  std::string file;
  uint64_t ticket = 0;
  uint64_t version = 0;  ///< of the document
  std::string message;   ///< the text frame; empty where the file is not edited as a scene
};

}  // namespace tessera
