#pragma once

#include <cstdint>
#include <list>
#include <memory>
#include <string>

#include "scenes/edit/edit.h"
#include "studio/source_json.h"
#include "studio/studio_orders.h"

namespace tessera {

/// Does what is asked of texts: outlines, edits, completions. For one thread, as it keeps the
/// outlines that it made last. Nothing that is asked makes it throw.
class SourceReader {
 public:
  FileOutline outline(const OutlineOrder& order);
  SendText answer(const SourceOrder& order);

 private:
  struct Read {
    std::string file;
    uint64_t version = 0;
    std::string text;
    edit::Outline outline;
    EntityIds ids;
  };
  static constexpr size_t kMostKept = 4;

  /// Null where the file is of no language whose texts are edited.
  const Read* read(const std::string& file, const Document& document);

  std::list<Read> kept_;  ///< the one that was used last first
};

}  // namespace tessera
