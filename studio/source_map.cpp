#include "studio/source_map.h"

#include <fmt/format.h>

#include <algorithm>
#include <cstring>
#include <filesystem>
#include <set>
#include <utility>

#include "base/error.h"
#include "base/file.h"
#include "base/open_input.h"
#include "proto/wire/node_numbers.h"

namespace tessera {

namespace fs = std::filesystem;

struct SourceMap::File {
  std::string name;
  uint64_t version = 0;  ///< of an open document
  std::optional<Document> document;
  std::optional<edit::Outline> outline;
  std::optional<EntityIds> ids;

  SourceLink link(int entity) const {
    const edit::Entity& found = outline->entities()[static_cast<size_t>(entity)];
    const auto position = [&](uint32_t byte) {
      return document->position_of(document->offset_of_text_byte(byte));
    };
    return {.kind = std::string(edit::name_of(found.kind)),
            .name = found.name.empty() ? found.type : found.name,
            .file = name,
            .entity = ids->of(entity),
            .version = version,
            .begin = position(found.range.begin),
            .end = position(found.range.end)};
  }
};

SourceMap::SourceMap(std::shared_ptr<const SceneReading> reading, std::string folder)
    : reading_(std::move(reading)), folder_(std::move(folder)) {
  nodes_.push_back(nullptr);
  for_each_node(reading_->scene->loaded.scene,
                [this](const v1::Node& node) { nodes_.push_back(&node); });
  files_.resize(reading_->scene->loaded.origins.files().size());
}

SourceMap::~SourceMap() = default;

SourceMap::File& SourceMap::file(uint32_t number) {
  std::unique_ptr<File>& known = files_[number];
  if (known) return *known;
  known = std::make_unique<File>();
  const std::string& path = reading_->scene->loaded.origins.files()[number];
  const fs::path relative = fs::path(path).lexically_relative(folder_);
  const bool is_inside = !relative.empty() && *relative.begin() != "..";
  known->name = is_inside ? relative.generic_string() : path;
  const auto language = edit::language_of(known->name);
  if (!language) return *known;
  if (const auto open = reading_->texts.find(known->name);
      open != reading_->texts.end() && open->second.is_editable()) {
    known->document = open->second;
    known->version = open->second.version();
  } else {
    const InputRoots roots(reading_->roots);
    try {
      known->document.emplace(read_input_file(path, Document::kMostBytes));
    } catch (const Error&) {  // It was there when the scene was read.
      return *known;
    }
  }
  known->outline.emplace(edit::outline(*language, known->document->text()));
  known->ids.emplace(*known->outline);
  return *known;
}

SourceChain SourceMap::chain(const ScenePart& part) {
  SourceChain chain;
  const OriginTable& origins = reading_->scene->loaded.origins;
  // What made a node, a call say, is told before whatever else that call made it stand in.
  std::vector<uint32_t> nodes;
  for (const uint32_t node : part.nodes)
    if (node != 0 && node < nodes_.size()) nodes.push_back(node);
  if (nodes.empty()) return chain;
  add_surface(part, chain);
  chain.at = chain.links.size();
  for (size_t i = 0; i < nodes.size(); ++i) {
    std::vector<uint32_t> outer;
    for (size_t k = i + 1; k < nodes.size(); ++k)
      for (uint32_t at = origins.of_node(nodes[k]); at != 0; at = origins.at(at).above)
        outer.push_back(at);
    add_node(nodes[i], outer, chain);
  }
  if (chain.at >= chain.links.size()) chain.at = 0;
  return chain;
}

void SourceMap::add_node(uint32_t node, const std::vector<uint32_t>& outer, SourceChain& chain) {
  const OriginTable& origins = reading_->scene->loaded.origins;
  for (uint32_t at = origins.of_node(node); at != 0; at = origins.at(at).above) {
    if (std::find(outer.begin(), outer.end(), at) != outer.end()) continue;
    add_origin(at, chain);
  }
}

void SourceMap::add_origin(uint32_t number, SourceChain& chain) {
  const Origin& origin = reading_->scene->loaded.origins.at(number);
  const File& from = file(origin.file);
  SourceLink link{.kind = "file", .name = from.name, .file = from.name};
  if (from.outline && origin.offset != Origin::kNowhere) {
    const size_t byte =
        from.document->text_byte_of(from.document->offset_of_file_byte(origin.offset));
    if (const int entity = from.outline->entity_at(byte); entity > 0) link = from.link(entity);
  } else if (from.outline && !origin.path.empty()) {
    if (const auto entity = from.outline->entity_of_path(origin.path)) link = from.link(*entity);
  }
  if (origin.kind == Origin::Kind::turn) link.name = fmt::format("turn {}", origin.turn);
  if (origin.kind == Origin::Kind::turn) link.kind = "loop";
  const bool says_nothing_new =
      std::any_of(chain.links.begin(), chain.links.end(), [&](const SourceLink& known) {
        return known == link || (link.kind == "file" && known.file == link.file);
      });
  if (!says_nothing_new) chain.links.push_back(std::move(link));
}

void SourceMap::add_surface(const ScenePart& part, SourceChain& chain) {
  const auto shown = std::find_if(part.nodes.begin(), part.nodes.end(), [this](uint32_t node) {
    return node != 0 && node < nodes_.size() && nodes_[node]->has_shape();
  });
  if (shown == part.nodes.end()) return;
  const v1::Shape& shape = nodes_[*shown]->shape();
  if (shape.has_mesh() && part.primitive > 0)
    chain.links.push_back({.kind = "face", .name = fmt::format("triangle {}", part.primitive)});
  if (shape.materials().empty()) return;
  uint32_t index = 0;
  if (shape.materials_size() > 1) {
    if (part.primitive == 0 || !shape.has_mesh()) return;
    const auto digest = Digest::parse(shape.mesh().face_materials().digest());
    const BlobData blob = digest ? reading_->scene->loaded.blobs.find(*digest) : nullptr;
    const size_t at = (part.primitive - 1) * sizeof index;
    if (!blob || blob->size() < at + sizeof index) return;
    std::memcpy(&index, blob->data() + at, sizeof index);
  }
  const int last = shape.materials_size() - 1;
  const std::string& name = shape.materials(std::min(static_cast<int>(index), last));
  if (name.empty()) return;
  const auto found = material(name);
  chain.links.push_back(found ? *found : SourceLink{.kind = "material", .name = name});
}

std::optional<SourceLink> SourceMap::material(const std::string& name) {
  // What comes from other files has their names before its own.
  for (size_t begin = 0; begin < name.size();) {
    for (uint32_t number = 0; number < files_.size(); ++number) {
      const File& from = file(number);
      if (!from.outline) continue;
      const auto entity =
          from.outline->entity_named(edit::EntityKind::material, name.substr(begin));
      if (entity) return from.link(*entity);
    }
    const size_t slash = name.find('/', begin);
    if (slash == std::string::npos) break;
    begin = slash + 1;
  }
  return {};
}

}  // namespace tessera
