#include "proto/wire/scene_codec.h"

#include <fmt/format.h>
#include <google/protobuf/io/coded_stream.h>
#include <google/protobuf/io/zero_copy_stream_impl_lite.h>
#include <google/protobuf/stubs/logging.h>
#include <google/protobuf/text_format.h>
#include <google/protobuf/util/json_util.h>

#include <filesystem>
#include <unordered_set>

#include "base/digest.h"
#include "base/error.h"
#include "base/file.h"
#include "base/lower_case.h"
#include "base/plain_text.h"
#include "proto/wire/scene_errors.h"
#include "proto/wire/scene_place.h"
#include "proto/wire/scene_walk.h"

namespace tessera {
namespace {

namespace fs = std::filesystem;
namespace pb = google::protobuf;

constexpr std::string_view kHeading =
    "# proto-file: proto/tessera/v1/scene.proto\n"
    "# proto-message: tessera.v1.Scene\n\n";

/// Protobuf's own bound, which counts otherwise in each form: above ours, below its stack's.
constexpr int kParserDepth = kMaxSceneDepth + 32;

/// Of a path as deep as a scene may be, its last steps.
std::string short_path(const SceneFault& fault) {
  constexpr size_t kShown = 80;
  if (fault.path.empty()) return "the scene";
  if (fault.path.size() <= kShown) return fault.path;
  const size_t dot = fault.path.find('.', fault.path.size() - kShown);
  return "..." + fault.path.substr(dot == std::string::npos ? fault.path.size() - kShown : dot);
}

Error fault_error(const SourcePlace& place, const SceneFault& fault) {
  // The path is told once.
  const std::string found =
      place.file == fault.path ? fault.found : fmt::format("{} {}", short_path(fault), fault.found);
  return scene_error(place, found, fault.expected);
}

v1::Scene parse_text(std::string_view text, const std::string& name,
                     pb::TextFormat::ParseInfoTree& places) {
  TextErrors errors(name, text);
  pb::TextFormat::Parser parser;
  parser.RecordErrorsTo(&errors);
  parser.AllowUnknownField(true);  // and go on: each of them is an error
  parser.WriteLocationsTo(&places);
  parser.SetRecursionLimit(kParserDepth);
  pb::io::ArrayInputStream input(text.data(), static_cast<int>(text.size()));
  v1::Scene scene;
  const bool parsed = parser.Parse(&input, &scene);
  errors.throw_if_any();
  if (!parsed) throw scene_error({name}, "the text cannot be read", "a scene in text format");
  return scene;
}

v1::Scene parse_json(std::string_view text, const std::string& name) {
  check_scene_json(text, name);
  v1::Scene scene;
  const auto status =
      pb::util::JsonStringToMessage(pb::StringPiece(text.data(), text.size()), &scene);
  if (!status.ok()) throw scene_json_error(name, text, std::string(status.message()));
  return scene;
}

bool parse_binary(std::string_view bytes, v1::Scene& scene) {
  const pb::LogSilencer silencer;  // the caller says what is wrong, once
  pb::io::CodedInputStream input(reinterpret_cast<const uint8_t*>(bytes.data()),
                                 static_cast<int>(bytes.size()));
  input.SetRecursionLimit(kParserDepth);
  return scene.ParseFromCodedStream(&input) && input.ConsumedEntireMessage();
}

/// A scene as text or JSON, which tell where they write its fields. Throws scene_error where there
/// is none; `text` has to outlive this.
class WrittenScene {
 public:
  WrittenScene(std::string_view text, SceneEncoding encoding, std::string name)
      : text_(text), is_json_(encoding == SceneEncoding::json), name_(std::move(name)) {
    scene_ = is_json_ ? parse_json(text_, name_) : parse_text(text_, name_, places_);
  }
  v1::Scene& scene() { return scene_; }
  SourcePlace place_of(const std::string& path) const {
    return is_json_ ? place_in_json(name_, text_, path)
                    : place_in_text(name_, text_, path, places_);
  }

 private:
  std::string_view text_;
  bool is_json_;
  std::string name_;
  v1::Scene scene_;
  pb::TextFormat::ParseInfoTree places_;
};

v1::Scene decode_message(std::string_view text, SceneEncoding encoding, const std::string& name) {
  if (text.size() > kMaxSceneFileBytes)
    throw scene_error({name}, fmt::format("{} bytes", text.size()),
                      fmt::format("at most {}", kMaxSceneFileBytes));
  if (encoding == SceneEncoding::binary) {
    v1::Scene scene;
    if (!parse_binary(text, scene))
      throw scene_error({name}, "the bytes are no scene, or a part of one",
                        "a scene as `tessera convert` writes it");
    check_scene(scene, name);
    return scene;
  }
  refuse_wide_text(text, name);
  text = skip_byte_order_mark(text);
  const size_t bad = find_invalid_utf8(text);
  if (bad != std::string_view::npos)
    throw scene_error(place_of(name, text, bad), "a byte that is not UTF-8", "text");
  WrittenScene written(text, encoding, name);
  if (const auto fault = find_fault(written.scene()))
    throw fault_error(written.place_of(fault->path), *fault);
  return std::move(written.scene());
}

/// Moves the embedded blobs of `scene` into a store, each checked against its name.
BlobStore take_blobs(v1::Scene& scene, const std::string& name) {
  BlobStore blobs;
  for (v1::Blob& blob : *scene.mutable_blobs()) {
    const auto digest = Digest::parse(blob.digest());
    const auto bytes = std::as_bytes(std::span(blob.data()));
    if (!digest || Digest::of(bytes) != *digest)
      throw scene_error({name}, fmt::format("blob '{}' does not have that digest", blob.digest()),
                        "the digest of its data (docs/scenes.md)");
    blobs.put(*digest, copy_to_blob(bytes));
    blob.clear_data();
  }
  scene.clear_blobs();
  return blobs;
}

std::vector<v1::BlobRef> present_blobs(const v1::Scene& scene, const BlobStore& blobs) {
  std::vector<v1::BlobRef> present;
  for (v1::BlobRef& ref : referenced_blobs(scene).value_or(std::vector<v1::BlobRef>{}))
    if (blobs.find(*Digest::parse(ref.digest()))) present.push_back(std::move(ref));
  return present;
}

std::string_view as_text(const Blob& bytes) {
  return {reinterpret_cast<const char*>(bytes.data()), bytes.size()};
}

/// Protobuf writes a negative zero as -0 but reads that as the whole number 0; -0.0 keeps its sign.
std::string with_negative_zeros(std::string_view json) {
  std::string result;
  result.reserve(json.size());
  bool in_string = false;
  for (size_t i = 0; i < json.size(); ++i) {
    const char c = json[i];
    result += c;
    if (c == '"') in_string = !in_string;
    if (c == '\\') result += json[++i];  // within a string: never a quote of its own
    const bool is_zero = !in_string && c == '0' && i > 0 && json[i - 1] == '-';
    const bool ends = i + 1 == json.size() ||
                      std::string_view(",]}\n ").find(json[i + 1]) != std::string_view::npos;
    if (is_zero && ends) result += ".0";
  }
  return result;
}

void fetch_blobs(const std::string& path, const fs::path& allowed, SceneWithBlobs& read) {
  std::error_code failure;
  const fs::path own = fs::weakly_canonical(fs::path(path).parent_path() / ".", failure);
  const fs::path root = allowed.empty() ? own : allowed;
  const fs::path folder =
      own.lexically_relative(root) / (fs::path(path).filename().string() + ".blobs");
  const auto refs = referenced_blobs(read.scene);
  if (!refs)
    throw scene_error({path}, "a blob's name is no digest", "64 lower-case hexadecimal digits");
  for (const v1::BlobRef& ref : *refs) {
    const Digest digest = *Digest::parse(ref.digest());
    if (read.blobs.find(digest)) continue;
    const std::string file = fmt::format("{}.blobs/{}", path, ref.digest());
    if (!resolve_inside(root, (folder / ref.digest()).string()))
      throw scene_error({file}, fmt::format("a blob that is not inside '{}'", root.string()),
                        "a file in that folder or below it");
    // Before any of it is in memory.
    const uint64_t size = check_input_file(file, UINT64_MAX);
    if (size != ref.size())
      throw scene_error({file}, fmt::format("{} bytes", size), fmt::format("{}", ref.size()));
    const std::string bytes = read_input_file(file, size);
    if (Digest::of(bytes) != digest)
      throw scene_error({file}, "the data do not have the digest of the file's name", "whole data");
    const auto view = std::as_bytes(std::span(bytes));
    read.blobs.put(digest, copy_to_blob(view));
  }
}

}  // namespace

std::optional<SceneEncoding> scene_encoding_of(std::string_view path) {
  const std::string ending = lower_case(std::filesystem::path(path).extension().string());
  if (ending == ".tessera") return SceneEncoding::text;
  if (ending == ".tesserab") return SceneEncoding::binary;
  if (ending == ".json") return SceneEncoding::json;
  return std::nullopt;
}

void check_scene(const v1::Scene& scene, const std::string& name) {
  if (const auto fault = find_fault(scene)) throw fault_error({name}, *fault);
}

SourcePlace place_in_scene_file(const std::string& path, std::string_view message) {
  const auto encoding = scene_encoding_of(path);
  if (!encoding || *encoding == SceneEncoding::binary) return {path};
  try {
    const std::string file = read_input_file(path, kMaxSceneFileBytes);
    WrittenScene written(skip_byte_order_mark(file), *encoding, path);
    const auto field = path_of_error(written.scene(), message);
    return field ? written.place_of(*field) : SourcePlace{path};
  } catch (const Error&) {  // it has changed since it was read
    return {path};
  }
}

SceneWithBlobs decode_scene(std::string_view text, SceneEncoding encoding,
                            const std::string& name) {
  SceneWithBlobs read;
  read.scene = decode_message(text, encoding, name);
  read.blobs = take_blobs(read.scene, name);
  return read;
}

std::string encode_scene(const v1::Scene& scene, const BlobStore& blobs, SceneEncoding encoding,
                         bool embed) {
  check_scene(scene, "the scene");
  v1::Scene whole = scene;
  whole.clear_blobs();
  if (embed) {
    for (const v1::BlobRef& ref : present_blobs(scene, blobs)) {
      v1::Blob* blob = whole.add_blobs();
      blob->set_digest(ref.digest());
      blob->set_data(std::string(as_text(*blobs.find(*Digest::parse(ref.digest())))));
    }
  }
  if (encoding == SceneEncoding::binary) return serialize_scene(whole);
  std::string text;
  if (encoding == SceneEncoding::text) {
    pb::TextFormat::Printer printer;
    printer.SetUseShortRepeatedPrimitives(true);
    printer.PrintToString(whole, &text);
    return std::string(kHeading) + text;
  }
  pb::util::JsonPrintOptions options;
  options.add_whitespace = true;
  options.preserve_proto_field_names = true;
  const auto status = pb::util::MessageToJsonString(whole, &text, options);
  if (!status.ok())
    throw scene_error(fmt::format("the scene cannot be JSON: {}", std::string(status.message())));
  return with_negative_zeros(text);
}

SceneWithBlobs read_scene_file(const std::string& path, SceneEncoding encoding,
                               const std::filesystem::path& root) {
  SceneWithBlobs read = decode_scene(read_input_file(path, kMaxSceneFileBytes), encoding, path);
  fetch_blobs(path, root, read);
  return read;
}

EncodedScene encode_scene_file(const std::string& path, const v1::Scene& scene,
                               const BlobStore& blobs) {
  const auto encoding = scene_encoding_of(path);
  if (!encoding)
    throw usage_error(fmt::format(
        "{}: unknown ending; expected .tessera (text), .tesserab (binary) or .json", path));
  auto present = present_blobs(scene, blobs);
  uint64_t total = 0;
  for (const v1::BlobRef& ref : present) total += blobs.find(*Digest::parse(ref.digest()))->size();
  const bool embed = total <= kMaxEmbeddedBlobBytes;
  if (embed) present.clear();
  return {encode_scene(scene, blobs, *encoding, embed), std::move(present)};
}

void write_scene_file(const std::string& path, const EncodedScene& scene, const BlobStore& blobs) {
  if (!scene.blobs_beside.empty()) {
    const std::string folder = path + ".blobs";
    std::error_code failure;
    std::filesystem::create_directories(folder, failure);
    if (failure) throw render_error(fmt::format("{}: {}", folder, failure.message()));
    for (const v1::BlobRef& ref : scene.blobs_beside)
      write_output_file(fmt::format("{}/{}", folder, ref.digest()),
                        as_text(*blobs.find(*Digest::parse(ref.digest()))));
  }
  write_output_file(path, scene.text);
}

void write_scene_file(const std::string& path, const v1::Scene& scene, const BlobStore& blobs) {
  write_scene_file(path, encode_scene_file(path, scene, blobs), blobs);
}

std::string serialize_scene(const v1::Scene& scene) {
  std::string bytes;
  bytes.reserve(scene.ByteSizeLong());
  pb::io::StringOutputStream output(&bytes);
  pb::io::CodedOutputStream coded(&output);
  coded.SetSerializationDeterministic(true);
  scene.SerializeToCodedStream(&coded);
  coded.Trim();
  return bytes;
}

std::string scene_digest(const v1::Scene& scene) {
  return Digest::of(serialize_scene(scene)).hex();
}

std::optional<v1::Scene> parse_scene(std::string_view bytes) {
  v1::Scene scene;
  if (bytes.size() > kMaxSceneFileBytes || !parse_binary(bytes, scene)) return std::nullopt;
  if (find_fault(scene)) return std::nullopt;
  return scene;
}

}  // namespace tessera
