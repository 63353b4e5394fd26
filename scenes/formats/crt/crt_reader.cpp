#include "scenes/formats/crt/crt_reader.h"

#include <fmt/format.h>

#include <filesystem>

#include "base/file.h"
#include "base/plain_text.h"
#include "scenes/formats/crt/crt_evaluator.h"
#include "scenes/formats/crt/crt_parser.h"
#include "scenes/formats/crt/crt_writer.h"

namespace tessera {
namespace {

constexpr uint64_t kMaxBytes = uint64_t{8} << 20;

void check_file(const std::string& written, CrtSpan where, const AssetFolder& assets,
                CrtDiagnostics& diagnostics) {
  const std::string reference = crt_file_reference(written);
  if (reference.empty() || reference.find('\0') != std::string::npos) {
    diagnostics.error(where, "a file without a name", "the name of one");
    return;
  }
  const auto file = assets.find_asset(reference).file;
  if (!file)
    diagnostics.error(where,
                      fmt::format("'{}' is not inside {}", written, assets.shown_root(reference)),
                      "a file in that folder or below it");
  else if (!is_input_file(*file))
    diagnostics.error(where, fmt::format("there is no file '{}'", file->string()),
                      fmt::format("a file in {} or below it", assets.shown_root()));
}

void check_files(const CrtProgram& program, const AssetFolder& assets,
                 CrtDiagnostics& diagnostics) {
  const CrtBackground* background = program.background;
  if (background && background->message.has_panorama())
    check_file(background->image, background->image_span, assets, diagnostics);
  for (const CrtEntity* entity : program.entities)
    if (entity->kind == CrtEntity::Kind::include)
      check_file(entity->include.file(), entity->span, assets, diagnostics);
}

}  // namespace

LoadedScene parse_crt(const std::string& text, const std::string& name,
                      const std::optional<AssetFolder>& assets, int32_t frame, bool keep_origins) {
  CrtDiagnostics diagnostics(name, text);
  CrtSyntaxPool pool;
  const CrtSyntax& script = CrtParser(text, pool, diagnostics).parse();
  diagnostics.throw_if_any();
  CrtHeap heap;
  const CrtProgram program = CrtEvaluator(heap, diagnostics, keep_origins).run(script, frame);
  if (assets) check_files(program, *assets, diagnostics);
  diagnostics.throw_if_any();
  LoadedScene loaded;
  loaded.scene = write_crt_scene(program, loaded.origins, name);
  // The original's pictures come through a library that heeds colour profiles.
  for (const v1::Texture& texture : loaded.scene.textures())
    if (texture.has_image()) loaded.profiled_pictures.insert(texture.image().file());
  diagnostics.add_warnings_to(loaded);
  loaded.depends_on_frame = program.uses_time;
  return loaded;
}

LoadedScene read_crt(const std::string& path, const ReadOptions& options) {
  const std::string bytes = read_input_file(path, kMaxBytes);
  refuse_wide_text(bytes, path);
  const std::string text = to_utf8(skip_byte_order_mark(bytes));
  return parse_crt(text, path, AssetFolder(path, options.assets), options.frame, options.origins);
}

}  // namespace tessera
