#include "scenes/formats/x3d/x3d_reader.h"

#include "base/file.h"
#include "scenes/formats/x3d/document/x3d_document.h"
#include "scenes/formats/x3d/x3d_translator.h"

namespace tessera {
namespace {

LoadedScene read_first(std::string_view bytes, const std::string& name, const ReadOptions& options,
                       X3dFiles files) {
  X3dBuild build{.options = options, .files = std::move(files)};
  const X3dDocument document = X3dDocument::parse(bytes, name, build.prototype_finder(""));
  // Its warnings and errors come again, among all that there are.
  AllFailures on_the_way;
  on_the_way.attempt([&] {
    X3dTranslator ahead(document, build, "");
    build.view = ahead.first_view();
    if (build.view.frame_all()) build.framed_extent = ahead.rough_extent();
  });
  X3dTranslator translator(document, build, "");
  translator.add_all({}, 1, *build.out.scene.mutable_nodes());
  on_the_way.throw_if_any();
  translator.finish();
  return std::move(build.out);
}

}  // namespace

LoadedScene read_x3d(const std::string& path, const ReadOptions& options) {
  return read_first(read_input_file(path, X3dDocument::kMaxBytes), path, options,
                    X3dFiles(path, options.assets));
}

LoadedScene parse_x3d(std::string_view bytes, const std::string& name, const ReadOptions& options) {
  return read_first(bytes, name, options, {});
}

}  // namespace tessera
