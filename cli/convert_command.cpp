#include <fmt/format.h>

#include <CLI/CLI.hpp>
#include <filesystem>
#include <memory>

#include "base/file.h"
#include "cli/add_options.h"
#include "cli/command_line.h"
#include "cli/say.h"
#include "front/placement.h"
#include "front/read_options.h"
#include "front/standard_input.h"
#include "front/texture_decoder.h"
#include "proto/wire/scene_codec.h"
#include "scenes/formats/read_scene.h"
#include "scenes/generate/accuracy_scenes.h"
#include "scenes/generate/generate_scene.h"

namespace tessera {
namespace {

/// "forest:10000" or "error:glossy", and no file of that name.
bool is_generated(const std::string& input) {
  return input.find(':') != std::string::npos && !std::filesystem::exists(input);
}

/// Procedural ones, and those of `tessera bench error`.
LoadedScene make_scene(const std::string& what) {
  constexpr std::string_view kOfErrorBench = "error:";
  if (!what.starts_with(kOfErrorBench)) return generate_scene(what);
  return make_accuracy_scene(what.substr(kOfErrorBench.size())).loaded;
}

struct ConvertOptions {
  std::string input, output;
  ReadOptions reading{.decode_texture = decode_texture,
                      .decode_texture_bytes = decode_texture_bytes};
};

ExitCode convert(const ConvertOptions& options) {
  if (!scene_encoding_of(options.output)) {
    throw usage_error(
        fmt::format("'{}': no format to write; expected an ending of .tessera, .tesserab or .json",
                    options.output));
  }
  check_output_file(options.output, "OUT");
  check_not_input(options.output, options.input, "OUT");
  const LoadedScene loaded = is_generated(options.input)
                                 ? make_scene(options.input)
                                 : read_scene(options.input, options.reading);
  for (const std::string& warning : loaded.warnings) say_warning(warning);
  write_scene_file(options.output, loaded.scene, loaded.blobs);
  return ExitCode::done;
}

}  // namespace

void add_convert_command(CLI::App& app, Action& action) {
  auto options = std::make_shared<ConvertOptions>();
  CLI::App* command = app.add_subcommand("convert", "Rewrite a scene as one of our own files");
  command->footer(
      "The endings choose the formats. Every form of our own holds the scene without loss:\n"
      "  .tessera   text, to read and edit      .tesserab  binary, small and fast      .json\n"
      "Examples:\n"
      "  tessera convert bunny.obj bunny.tessera\n"
      "  tessera convert bunny.tessera bunny.json\n"
      "  tessera convert forest:10000 forest.tesserab\n"
      "  tessera convert error:glossy glossy.tessera");
  command
      ->add_option("IN", options->input,
                   fmt::format("The scene to read, '-' being standard input; or one to make, as "
                               "NAME:NUMBER, of {}; or "
                               "error:SCENE, one of `bench error`",
                               fmt::join(generated_scene_names(), ", ")))
      ->required()
      ->type_name("FILE");
  command->add_option("OUT", options->output, "The file to write")->required()->type_name("FILE");
  OptionList list;
  add_place_option(list, options->reading.placements);
  add_read_options(list, options->reading);
  add_options(*command, list);
  command->callback([options, &action] {
    action = [options] {
      take_standard_input(options->input, options->reading);
      return convert(*options);
    };
  });
}

}  // namespace tessera
