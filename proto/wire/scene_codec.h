#pragma once

#include <cstdint>
#include <filesystem>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "base/error.h"
#include "proto/tessera/v1/scene.pb.h"
#include "proto/wire/blob_store.h"

namespace tessera {

/// The three forms of a scene of our own in a file; each holds the same message without loss.
enum class SceneEncoding {
  text,    ///< protobuf text format, `.tessera`
  binary,  ///< protobuf wire format, `.tesserab`
  json,    ///< protobuf's JSON mapping, `.json`
};

/// A description and, apart from it, its bulk data: scene.blobs() is empty.
struct SceneWithBlobs {
  v1::Scene scene;
  BlobStore blobs;
};

/// Blobs of at most this many bytes in all are written into the file, more of them beside it.
inline constexpr uint64_t kMaxEmbeddedBlobBytes = uint64_t{64} << 20;
/// Longer files are refused unread.
inline constexpr uint64_t kMaxSceneFileBytes = uint64_t{1} << 30;
/// Messages inside messages below the scene, in every form alike; as many as protobuf can write as
/// JSON. Deeper ones are refused.
inline constexpr int kMaxSceneDepth = 64;

/// By the ending of `path`, in any case; nothing for an ending that is not ours.
std::optional<SceneEncoding> scene_encoding_of(std::string_view path);

/// Throws scene_error, with `name` for its place, where `scene` holds a number that is not finite,
/// a number that its enumeration does not have, or messages nested deeper than kMaxSceneDepth.
void check_scene(const v1::Scene& scene, const std::string& name);

/// Reads `text`, which came from the file `name`; empty: a program wrote it, and places are paths
/// of fields. It passes check_scene, every string is UTF-8, every embedded blob has the digest that
/// it claims. Throws scene_error with the place.
SceneWithBlobs decode_scene(std::string_view text, SceneEncoding encoding, const std::string& name);
/// `blobs` that `scene` does not refer to are left out; none are embedded where `embed` is false.
/// The same scene gives the same bytes. Throws scene_error as check_scene.
std::string encode_scene(const v1::Scene& scene, const BlobStore& blobs, SceneEncoding encoding,
                         bool embed = true);

/// As decode_scene, and fetches the blobs that lie in the folder `PATH.blobs`, verified. One that a
/// link leads to outside of `root` is not read; empty: the folder of the file.
SceneWithBlobs read_scene_file(const std::string& path, SceneEncoding encoding,
                               const std::filesystem::path& root = {});
/// A scene as a file holds it.
struct EncodedScene {
  std::string text;
  std::vector<v1::BlobRef> blobs_beside;  ///< too large to embed: files of their own
};
/// The scene as the file `path` holds it, by its ending. Throws usage_error for an ending that is
/// not ours, scene_error as check_scene.
EncodedScene encode_scene_file(const std::string& path, const v1::Scene& scene,
                               const BlobStore& blobs);
/// Writes `path`, and `PATH.blobs/DIGEST` for each blob beside it. Each file appears whole or not
/// at all. Throws render_error where one cannot be written.
void write_scene_file(const std::string& path, const EncodedScene& scene, const BlobStore& blobs);
/// Encodes and writes.
void write_scene_file(const std::string& path, const v1::Scene& scene, const BlobStore& blobs);

/// Where the file `path` writes what `message`, an error of building its scene, begins with:
/// "node 'hall' > node 3 > shape: sphere.radius is ...". Without line and column where the file is
/// neither text nor JSON, or does not tell. Reads it anew: for the way out.
SourcePlace place_in_scene_file(const std::string& path, std::string_view message);

/// The digests that `scene` refers to, each once, in the order of the message; nothing where one is
/// no digest.
std::optional<std::vector<v1::BlobRef>> referenced_blobs(const v1::Scene& scene);

/// The canonical wire form: equal scenes, equal bytes.
std::string serialize_scene(const v1::Scene& scene);
/// The digest of that, in hexadecimal, which names the scene.
std::string scene_digest(const v1::Scene& scene);
/// The scene in bytes that may be hostile; nothing where they are none or check_scene would throw.
/// Never throws.
std::optional<v1::Scene> parse_scene(std::string_view bytes);

}  // namespace tessera
