#pragma once

#include <cstddef>
#include <cstdint>
#include <functional>
#include <map>
#include <optional>
#include <set>
#include <string>
#include <string_view>
#include <vector>

#include "base/error.h"
#include "base/input_scope.h"
#include "proto/tessera/v1/scene.pb.h"
#include "proto/wire/blob_store.h"
#include "renderer/math/stored_samples.h"
#include "scenes/import/origin_table.h"

namespace tessera {

/// The one number that a texture takes of a coloured picture's texels.
enum class PictureChannel { luminance, alpha_or_luminance };

/// What an importer makes of a file. A value.
struct LoadedScene {
  v1::Scene scene;  ///< without blobs and includes in it
  BlobStore blobs;
  /// The files of pictures that came inside the scene's own file, by what Image.file calls them;
  /// empty once textures are loaded.
  std::map<std::string, std::string> pictures{};
  /// Pictures by Image.file whose embedded colour profile is heeded: taken to sRGB when read.
  std::set<std::string> profiled_pictures{};
  /// By a texture's name: what is kept of its picture, where that is one number.
  std::map<std::string, PictureChannel> picture_channels{};
  std::vector<std::string> warnings{};  ///< what was read otherwise than a user might expect
  std::vector<Diagnostic> warning_diagnostics{};  ///< the parts of each, in the same order
  /// Of the warnings those about values that break a rule of their format and were taken for the
  /// nearest that keeps it, that name files which cannot be read, or about pictures that are
  /// damaged or have numbers that are not finite, each as the error that a strict reading makes of
  /// it.
  std::vector<Diagnostic> repairs{};
  /// What the file defines and its scene does not show, so that it was not taken over: "mesh
  /// 'lid'".
  std::vector<std::string> unused{};
  bool depends_on_frame = false;  ///< a script: another ReadOptions::frame, another scene
  OriginTable origins{};          ///< of its nodes; empty unless ReadOptions::origins asks for them
};

/// A picture as textures hold it: rows from the top, tightly packed.
struct DecodedTexture {
  uint32_t width = 0, height = 0;
  uint32_t channels = 3;  ///< 1 grey, 2 grey and alpha, 3 RGB, 4 RGBA
  uint32_t bits = 8;      ///< 8, 16 (half float) or 32 (float)
  BlobData texels;
  SampleMeaning meaning{};  ///< integers of 8 bits are from integers whatever it says
  std::vector<std::string> unused_channels{};  ///< names of channels that its file has beside these
  std::string part_note{};  ///< which part of its file it is, where that is not the first
  std::string damage{};     ///< what is wrong with a file that was read as far as it goes
  float gamma = 0;          ///< exponent that made its codes, as the file says; 0: as sRGB
};
/// Reads the picture in a file. Whoever reads scenes brings it: scenes decode no pictures.
/// `to_srgb`: colours are taken from an embedded colour profile to sRGB.
using TextureDecoder = std::function<DecodedTexture(const std::string& path, bool to_srgb)>;
/// Reads the picture that a file of these bytes would hold; `name` is what errors call it.
using TextureBytesDecoder =
    std::function<DecodedTexture(std::string_view bytes, const std::string& name)>;

/// Why no picture can be made of the file `name`, or of `bytes` where they are given, which `name`
/// then only names; empty where one can.
using PictureCheck = std::function<std::string(const std::string& name, const std::string* bytes)>;

/// Why no scene can be made of the file at `path`, which includes are not looked at for; empty
/// where one can.
using SceneCheck = std::function<std::string(const std::string& path)>;

class ReadCache;

/// How a file is read. The defaults are what a user expects who gives no option.
struct ReadOptions {
  enum class Color { display, linear };
  enum class Shadows { on, file, off };
  enum class X3dTexture { by_version, replace, modulate };
  enum class Up { by_format, y, z };

  std::string format{};  ///< obj, ply, stl, gltf, glb, x3d, crt, tessera, tesserab, json; empty: by
                         ///< the ending
  /// The folder in which, and in which alone, the files are that the scene names: looked for from
  /// the folder of the file that names them where that is inside, then from this one. Empty: that
  /// of the scene's file. Placements keep to their own.
  std::string assets{};
  /// Which axis points up in a model by itself, whose camera, lights and background are then
  /// turned. By its format it is z in STL and y in others.
  Up up = Up::by_format;
  /// A panorama that stands in place of the scene's background, wherever its file lies: the light
  /// of a model by itself, too. Empty: none.
  std::string environment{};
  /// Back faces are seen, whatever the file says of materials and of X3D's `solid`.
  bool two_sided = false;
  /// The caller puts a camera of its own in place of the scene's, by `up` too.
  bool brings_camera = false;
  Color x3d_color = Color::display;   ///< how the numbers of X3D colours are meant
  Shadows x3d_shadows = Shadows::on;  ///< `file`: as the lights' own fields say
  /// What a coloured texture does to the material's colour: by the letter it takes its place up to
  /// X3D 3.3, and multiplies it from 4.0 on.
  X3dTexture x3d_texture = X3dTexture::by_version;
  double x3d_weld = 0;  ///< points this near share the normals that are made, in X3D's units
  /// What would be in LoadedScene::repairs is an error, and so is all that x3d_strict makes one.
  bool strict = false;
  bool x3d_strict = false;          ///< a picture or an Inline that is missing or wrong is an error
  TextureDecoder decode_texture{};  ///< none: textures keep the names of their files
  TextureBytesDecoder decode_texture_bytes{};  ///< of pictures inside the scene's file
  PictureCheck check_picture{};                ///< read_scene brings it where there are decoders
  SceneCheck check_scene{};                    ///< read_scene brings it
  /// Files to place beside what the scene itself includes: each from a folder of its own, by a path
  /// as the system takes it. One without a file places the scene itself, its cameras apart.
  std::vector<v1::Include> placements{};
  int32_t frame = 0;  ///< of an animation; what scripts call t
  /// Texts that stand for files: for the scene's own, for those that it names and those beside
  /// these, wherever a file is read as a text. Which are there is asked anew at each reading.
  TextOfFile text_of{};
  bool origins = false;        ///< whether to tell where nodes come from; the scene is the same
  ReadCache* cache = nullptr;  ///< of the caller, who keeps it; null: all is read at each call
};

}  // namespace tessera
