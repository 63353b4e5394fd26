#include "scenes/formats/gltf/gltf_file.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <cstring>
#include <nlohmann/json.hpp>
#include <set>

#include "base/file.h"
#include "base/plain_text.h"
#include "scenes/formats/gltf/gltf_meshopt.h"
#include "scenes/import/data_uri.h"
#include "scenes/import/decimal.h"

namespace tessera {
namespace {

constexpr size_t kMaxJson = size_t{256} << 20;
constexpr size_t kMaxValues = size_t{1} << 24;
constexpr int kMaxDepth = 64;

uint32_t word_at(std::string_view bytes, size_t offset) {
  uint32_t word = 0;
  std::memcpy(&word, bytes.data() + offset, sizeof word);
  return word;
}

/// Looks over a text before anything of it is kept: whether it is JSON of numbers that double
/// precision can hold, and within our bounds. (The parser that keeps values could ask as it goes,
/// but then looks through all of an array after each object in it.)
class JsonCheck final : public nlohmann::json_sax<nlohmann::json> {
 public:
  explicit JsonCheck(const std::string& name) : name_(name) {}

  size_t begin = 0;      ///< of the word that is wrong
  std::string number{};  ///< that is too large; empty: the text is no JSON

  bool null() override { return count(); }
  bool boolean(bool) override { return count(); }
  bool number_integer(number_integer_t) override { return count(); }
  bool number_unsigned(number_unsigned_t) override { return count(); }
  bool number_float(number_float_t, const string_t&) override { return count(); }
  bool string(string_t&) override { return count(); }
  bool binary(binary_t&) override { return count(); }
  bool key(string_t&) override { return count(); }
  bool start_object(size_t) override { return enter(); }
  bool end_object() override { return leave(); }
  bool start_array(size_t) override { return enter(); }
  bool end_array() override { return leave(); }
  bool parse_error(size_t read, const std::string& word,
                   const nlohmann::json::exception& problem) override {
    constexpr int kNumberTooLarge = 406;
    if (problem.id == kNumberTooLarge) number = word;
    begin = read - std::min(read, number.empty() ? 1 : word.size());
    return false;
  }

 private:
  bool count() {
    if (++values_ > kMaxValues)
      throw scene_error({name_}, "too many values", fmt::format("at most {}", kMaxValues));
    return true;
  }
  bool enter() {
    if (++depth_ > kMaxDepth)
      throw scene_error({name_}, "JSON that is nested deeper",
                        fmt::format("at most {} levels", kMaxDepth));
    return count();
  }
  bool leave() {
    --depth_;
    return true;
  }

  const std::string& name_;
  size_t values_ = 0;
  int depth_ = 0;
};

/// Where a text goes on that begins with `before`.
SourcePlace place_behind(const std::string& name, std::string_view before) {
  const size_t line = before.rfind('\n');
  const size_t column = line == std::string_view::npos ? before.size() : before.size() - line - 1;
  return {name, 1 + static_cast<int>(std::count(before.begin(), before.end(), '\n')),
          1 + static_cast<int>(column)};
}

int hex_digit(char c) {
  if (c >= '0' && c <= '9') return c - '0';
  if (c >= 'a' && c <= 'f') return c - 'a' + 10;
  if (c >= 'A' && c <= 'F') return c - 'A' + 10;
  return -1;
}

/// What a buffer or a view of one says that it is long; all that is there where it does not.
uint64_t length_of(const GltfValue& holder, size_t there) {
  const GltfValue value = holder["byteLength"];
  if (!value) value.repair("no value", "a whole number", "what is there is read");
  return value.whole().value_or(there);
}

}  // namespace

GltfFile::GltfFile(std::string_view bytes, const std::string& name, GltfFolder folder)
    : text_{.name = name}, folder_(std::move(folder)) {
  read_container(bytes);
  parse();
  buffers_.resize(root()["buffers"].size());
}

GltfFile::~GltfFile() = default;

GltfValue GltfFile::root() { return {json_.get(), &text_, ""}; }

void GltfFile::read_container(std::string_view bytes) {
  constexpr size_t kHeader = 12, kChunkHeader = 8;
  constexpr uint32_t kJsonChunk = 0x4E4F534A, kBinaryChunk = 0x004E4942;
  if (!bytes.starts_with("glTF")) {
    refuse_wide_text(bytes, text_.name);
    text_.text = json_text_ = skip_byte_order_mark(bytes);
    return;
  }
  const auto fail = [&](std::string_view found, std::string_view expected) {
    return scene_error({text_.name}, found, expected);
  };
  if (bytes.size() < kHeader + kChunkHeader)
    throw fail("the file ends in its header", "a .glb file");
  if (word_at(bytes, 4) != 2)
    throw fail(fmt::format("version {} of the container", word_at(bytes, 4)), "version 2");
  const size_t whole = word_at(bytes, 8);
  if (whole > bytes.size())
    text_.warnings.repair(fmt::format("{} bytes in the header", whole),
                          fmt::format("at most {}, the file's length", bytes.size()),
                          "its chunks are read", {});
  bytes = bytes.substr(0, whole);
  for (size_t at = kHeader; at + kChunkHeader <= bytes.size();) {
    size_t length = word_at(bytes, at);
    const uint32_t kind = word_at(bytes, at + 4);
    at += kChunkHeader;
    if (length > bytes.size() - at) {
      text_.warnings.repair(fmt::format("a chunk of {} bytes", length),
                            fmt::format("at most {}, what is left of the file", bytes.size() - at),
                            "what is there is read", {});
      length = bytes.size() - at;
    }
    if (kind == kJsonChunk && json_text_.empty()) json_text_ = bytes.substr(at, length);
    if (kind == kBinaryChunk && binary_.empty()) binary_ = bytes.substr(at, length);
    at += length;
  }
  // Spaces are to fill it up; some programs write zeros.
  json_text_ = json_text_.substr(0, json_text_.find_last_not_of('\0') + 1);
  if (json_text_.empty()) throw fail("no chunk of JSON", "one");
}

void GltfFile::parse() {
  if (json_text_.size() > kMaxJson)
    throw scene_error({text_.name}, fmt::format("{} bytes of JSON", json_text_.size()),
                      fmt::format("at most {}; a .glb holds more", kMaxJson));
  JsonCheck check(text_.name);
  bool is_json = nlohmann::json::sax_parse(json_text_, &check);
  if (!is_json) {
    repaired_json_ = without_endless_numbers();
    JsonCheck again(text_.name);
    is_json = repaired_json_ != json_text_ && nlohmann::json::sax_parse(repaired_json_, &again);
    if (is_json) json_text_ = repaired_json_;
  }
  if (!is_json) {
    SourcePlace place{text_.name};
    if (!text_.text.empty()) place = place_behind(text_.name, json_text_.substr(0, check.begin));
    if (!check.number.empty())
      throw scene_error(place, fmt::format("the number {}", check.number),
                        "one that double precision can hold");
    throw scene_error(place, "what is no JSON", "the JSON of a glTF file");
  }
  json_ = std::make_unique<nlohmann::json>(nlohmann::json::parse(json_text_));
  if (!json_->is_object()) throw root().error("no JSON object", "the JSON of a glTF file");
}

/// The JSON with each number that is not finite in quotes, so that it counts as a value of the
/// wrong type: NaN and Infinity, which some programs write and JSON has no words for, and what
/// double precision cannot hold.
std::string GltfFile::without_endless_numbers() const {
  std::string out;
  bool is_quoted = false;
  for (size_t at = 0; at < json_text_.size();) {
    const std::string_view rest = json_text_.substr(at);
    size_t length = 1;
    if (is_quoted || rest.front() == '"') {
      if (rest.front() == '"') is_quoted = !is_quoted;
      if (rest.front() == '\\') length = std::min<size_t>(2, rest.size());
    } else if (const size_t end = rest.find_first_of(" \t\r\n,:{}[]\""); end != 0) {
      length = std::min(end, rest.size());
      // Takes "inf" and "nan" in any case, too.
      double number = 0;
      const auto [stop, problem] = read_decimal(rest.data(), rest.data() + length, number);
      const bool is_whole = stop == rest.data() + length && problem != std::errc::invalid_argument;
      if (is_whole && (problem != std::errc() || !std::isfinite(number))) {
        out += fmt::format("\"{}\"", rest.substr(0, length));
        at += length;
        continue;
      }
    }
    out += rest.substr(0, length);
    at += length;
  }
  return out;
}

std::vector<std::string> GltfFile::extension_names() {
  std::set<std::string> names;
  const GltfValue used = root()["extensionsUsed"];
  for (size_t i = 0; i < used.size(); ++i) names.insert(used.at(i).text(""));
  std::vector<const nlohmann::json*> open{json_.get()};
  while (!open.empty()) {
    const nlohmann::json& value = *open.back();
    open.pop_back();
    if (value.is_object()) {
      const auto found = value.find("extensions");
      if (found != value.end() && found->is_object())
        for (const auto& [name, content] : found->items()) names.insert(name);
    }
    if (value.is_structured())
      for (const nlohmann::json& member : value) open.push_back(&member);
  }
  names.erase("");
  return {names.begin(), names.end()};
}

void GltfFile::spend(uint64_t amount, const GltfValue& on) {
  spent_ += std::min(amount, kMostRead + 1);
  if (spent_ > kMostRead)
    throw on.error("too much in all",
                   fmt::format("at most {} numbers, or bytes of pictures", kMostRead));
}

std::optional<std::string> GltfFile::data_of_uri(const GltfValue& uri) {
  auto data = read_data_uri(uri.text(""));
  if (!data) return std::nullopt;
  if (!data->problem.empty()) throw uri.error(data->problem, data->expected);
  return std::move(data->bytes);
}

std::string GltfFile::path_of_uri(const GltfValue& uri) {
  const std::string text = uri.text("");
  std::string path;
  for (size_t i = 0; i < text.size(); ++i) {
    const int high = text[i] == '%' && i + 2 < text.size() ? hex_digit(text[i + 1]) : -1;
    const int low = high < 0 ? -1 : hex_digit(text[i + 2]);
    if (low < 0) {
      path += text[i];
    } else {
      path += static_cast<char>(high * 16 + low);
      i += 2;
    }
  }
  if (find_invalid_utf8(path) != std::string::npos)
    throw uri.error("a name that is no UTF-8", "a relative path");
  return path;
}

std::string GltfFile::load(const GltfValue& uri) {
  if (auto held = data_of_uri(uri)) return *std::move(held);
  try {
    if (!folder_) throw scene_error("other files are not read here");
    return folder_(path_of_uri(uri));
  } catch (const Error& problem) {
    throw uri.error(problem.what(), "a file that can be read");
  }
}

std::string_view GltfFile::buffer(size_t index) {
  if (const auto lost = lost_buffers_.find(index); lost != lost_buffers_.end()) throw lost->second;
  const GltfValue value = element("buffers", index);
  const GltfValue uri = value["uri"];
  std::string_view bytes = binary_;
  if (!uri.text("").empty()) {
    std::optional<std::string>& held = buffers_[index];
    try {
      if (!held) held = load(uri);
    } catch (const Error& problem) {
      lost_buffers_.emplace(index, problem);
      throw;
    }
    bytes = *held;
  } else if (index != 0 || binary_.empty()) {
    throw value.error("neither a uri nor the binary part of a .glb", "one of them");
  }
  const uint64_t length = length_of(value, bytes.size());
  if (bytes.size() < length)
    value["byteLength"].repair(fmt::format("{} bytes", length),
                               fmt::format("at most {}, which are there", bytes.size()),
                               "what is there is read");
  return bytes.substr(0, length);
}

GltfFile::View GltfFile::part(const GltfValue& value) {
  const auto which = value["buffer"].index(buffers_.size(), "buffer");
  if (!which) throw value.error("no buffer", "its index");
  const std::string_view bytes = buffer(*which);
  const uint64_t offset = std::min<uint64_t>(value["byteOffset"].whole().value_or(0), bytes.size());
  const uint64_t length = length_of(value, bytes.size() - offset);
  if (length > bytes.size() - offset)
    value.repair(fmt::format("{} bytes from byte {} on", length, offset),
                 fmt::format("an end within the buffer's {} bytes", bytes.size()),
                 "what is there is read");
  return {bytes.substr(offset, length), 0, offset};
}

GltfFile::View GltfFile::view(size_t index) {
  const GltfValue value = element("bufferViews", index);
  View view;
  if (const GltfValue packed = value["extensions"]["EXT_meshopt_compression"]) {
    auto known = unpacked_views_.find(index);
    if (known == unpacked_views_.end())
      known =
          unpacked_views_.emplace(index, unpack_meshopt(*this, packed, part(packed).bytes)).first;
    view.bytes = known->second;
    view.stride = packed["byteStride"].required_whole();
  } else {
    view = part(value);
  }
  const GltfValue given = value["byteStride"];
  const uint64_t stride = given.whole().value_or(0);
  if (view.stride > 0) {
    if (given && stride != view.stride)
      given.repair(given.shown(), fmt::format("{}, as of its compressed rows", view.stride),
                   "these are taken");
    return view;
  }
  if (given && (stride < 4 || stride > 252))
    given.repair(given.shown(), "4 to 252",
                 stride == 0 ? "the rows are next to each other" : "it is taken all the same");
  view.stride = stride;
  return view;
}

}  // namespace tessera
