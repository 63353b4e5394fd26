#include "scenes/formats/x3d/x3d_reader.h"

#include "base/file.h"
#include "scenes/formats/x3d/x3d_document.h"
#include "scenes/formats/x3d/x3d_translator.h"

namespace tessera {
namespace {

constexpr uint64_t kMaxFileBytes = uint64_t{512} << 20;

}  // namespace

LoadedScene read_x3d(const std::string& path, const ReadOptions& options) {
  return parse_x3d(read_input_file(path, kMaxFileBytes), path, options);
}

LoadedScene parse_x3d(std::string_view text, const std::string& name, const ReadOptions& options) {
  const X3dDocument document = X3dDocument::parse_xml(text, name);
  return X3dTranslator(document, options).translate(name);
}

}  // namespace tessera
