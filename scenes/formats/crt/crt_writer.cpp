#include "scenes/formats/crt/crt_writer.h"

#include <fmt/format.h>

#include <set>

#include "scenes/formats/crt/crt_objects.h"
#include "scenes/formats/crt/crt_parts.h"

namespace tessera {
namespace {

constexpr char kBackgroundTexture[] = "background";

class Writer {
 public:
  Writer(const CrtProgram& program, OriginTable& origins, const std::string& name)
      : program_(program), origins_(origins), name_(name) {}

  v1::Scene write() {
    *scene_.mutable_metadata() = program_.metadata;
    write_settings();
    write_camera();
    write_background();
    for (const CrtLight* light : program_.lights) write_light(*light);
    for (const CrtEntity* entity : program_.entities) write_entity(*entity);
    return std::move(scene_);
  }

 private:
  void write_settings() {
    v1::Settings& settings = *scene_.mutable_settings();
    if (program_.image.width) settings.set_width(*program_.image.width);
    if (program_.image.height) settings.set_height(*program_.image.height);
    const uint32_t side = program_.supersampling;
    settings.mutable_sampling()->set_samples_per_pixel(side * side);
    // Said for one sample too, so that --spp on the command line keeps the original's grid.
    settings.mutable_sampling()->set_pattern(v1::Sampling::CORNER_GRID);
    settings.mutable_integrator()->set_kind("whitted");
    settings.mutable_integrator()->set_max_depth(program_.recursion_depth);
    settings.mutable_output()->set_tone_map(v1::Output::CLAMP);
    settings.mutable_output()->set_transfer(v1::Output::DISPLAY);
    settings.mutable_output()->set_quantization(v1::Output::TRUNCATE);
  }

  void write_camera() {
    v1::Camera& camera = *scene_.add_cameras();
    camera = program_.camera->message;
    camera.set_name(unique_name(program_.camera, "camera"));
    if (program_.dof_samples > 1 && camera.lens().radius_x() > 0)
      camera.mutable_lens()->set_samples(program_.dof_samples);
    else
      camera.clear_lens();
  }

  void write_background() {
    v1::Background& background = *scene_.mutable_background();
    if (!program_.background) {
      put(kWhite, background.mutable_solid());
      return;
    }
    background = program_.background->message;
    if (!background.has_panorama()) return;
    background.mutable_panorama()->set_texture(kBackgroundTexture);
    // The picture's middle lies at +z and its right at +x: the world is left-handed.
    put(Vec3{1, 1, -1}, background.mutable_orientation()->add_steps()->mutable_scale());
    v1::Texture& texture = *scene_.add_textures();
    texture.set_name(kBackgroundTexture);
    names_.insert(kBackgroundTexture);
    v1::Texture::Image& image = *texture.mutable_image();
    image.set_file(crt_file_reference(program_.background->image));
    image.set_encoding(v1::Texture::Image::ENCODING_LINEAR);
    image.set_filter(v1::Texture::Image::BILINEAR);
    image.set_texels_at_corners(true);
  }

  void write_light(const CrtLight& light) {
    v1::Node& node = *scene_.add_nodes();
    *node.mutable_light() = light.message;
    node.mutable_light()->set_name(unique_name(&light, "light"));
  }

  void write_entity(const CrtEntity& entity) {
    if (entity.kind == CrtEntity::Kind::empty) return;
    if (entity.kind == CrtEntity::Kind::include) return write_include(entity);
    write_node(entity, true, *scene_.add_nodes());
  }

  void write_include(const CrtEntity& entity) {
    v1::Include& include = *scene_.add_includes();
    include = entity.include;
    mark(entity, Origin::Kind::include, include);
    include.set_file(crt_file_reference(include.file()));
    *include.mutable_transform() = entity.modifiers;
    // Models come right-handed; mirrored, they look in this world as they do in theirs.
    put(Vec3{1, 1, -1}, include.mutable_transform()->add_steps()->mutable_scale());
    if (entity.material) include.set_material(material_name(*entity.material, false));
  }

  /// Recursion ends: the operators limit the nesting that is left after joining chains.
  void write_node(const CrtEntity& entity, bool alone, v1::Node& node) {
    if (const auto name = program_.names.find(&entity); name != program_.names.end())
      node.set_name(name->second);
    mark(entity, Origin::Kind::part, node);
    if (entity.modifiers.steps_size() > 0) *node.mutable_transform() = entity.modifiers;
    if (entity.kind == CrtEntity::Kind::shape) {
      node.mutable_transform()->MergeFrom(entity.placement);
      if (node.transform().steps_size() == 0) node.clear_transform();
      *node.mutable_shape() = entity.shape;
      node.mutable_shape()->add_materials(
          material_name(*entity.material, entity.one_sided && alone));
      return;
    }
    const auto operands = operands_of(entity);
    const auto parts =
        alone && entity.operation == v1::Csg::UNION ? parts_apart(operands) : CrtParts{operands};
    for (const auto& part : parts) {
      v1::Node& place = parts.size() == 1 ? node : *node.add_children();
      if (part.size() == 1)
        write_node(*part.front(), true, place);
      else
        write_combination(entity.operation, part, place);
    }
  }

  void mark(const CrtEntity& entity, Origin::Kind kind, google::protobuf::Message& message) {
    const auto made = program_.made.find(&entity);
    if (made == program_.made.end()) return;
    const auto [at, is_new] = origin_numbers_.try_emplace(&entity);
    if (is_new) {
      at->second = origins_.add({.kind = kind,
                                 .file = origins_.file(name_),
                                 .offset = made->second.where.offset,
                                 .above = making_origin(made->second.in)});
    }
    set_origin(message, at->second);
  }

  /// What stands above a making has a smaller number.
  uint32_t making_origin(uint32_t number) {
    while (making_origins_.size() < number) {
      const CrtProgram::Making& making = program_.makings[making_origins_.size()];
      making_origins_.push_back(
          origins_.add({.kind = making.turn > 0 ? Origin::Kind::turn : Origin::Kind::call,
                        .file = origins_.file(name_),
                        .offset = making.where.offset,
                        .turn = making.turn,
                        .above = making.above == 0 ? 0 : making_origins_[making.above - 1]}));
    }
    return number == 0 ? 0 : making_origins_[number - 1];
  }

  void write_combination(v1::Csg::Operation operation,
                         const std::vector<const CrtEntity*>& operands, v1::Node& node) {
    v1::Csg& csg = *node.mutable_shape()->mutable_csg();
    csg.set_operation(operation);
    for (const CrtEntity* operand : operands) write_node(*operand, false, *csg.add_operands());
  }

  /// a + b + c is one union of three, a - b - c and a - (b + c) one difference.
  static std::vector<const CrtEntity*> operands_of(const CrtEntity& whole) {
    struct Open {
      const CrtEntity* entity;
      bool is_first;
    };
    std::vector<const CrtEntity*> operands;
    std::vector<Open> open{{whole.right, false}, {whole.left, true}};
    while (!open.empty()) {
      const auto [entity, is_first] = open.back();
      open.pop_back();
      const bool keeps_apart =
          entity->kind != CrtEntity::Kind::set_operation || entity->modifiers.steps_size() > 0;
      const v1::Csg::Operation joined =
          whole.operation == v1::Csg::DIFFERENCE && !is_first ? v1::Csg::UNION : whole.operation;
      if (keeps_apart || entity->operation != joined) {
        operands.push_back(entity);
        continue;
      }
      open.push_back({entity->right, false});
      open.push_back({entity->left, is_first});
    }
    return operands;
  }

  std::string material_name(const CrtMaterial& material, bool one_sided) {
    auto& known = material_names_[one_sided ? 1 : 0];
    const auto [at, is_new] = known.try_emplace(&material);
    if (!is_new) return at->second;
    at->second = unique_name(&material, "material");
    v1::Material& made = *scene_.add_materials();
    made = material.message;
    made.set_name(at->second);
    if (one_sided) made.set_sides(v1::Material::FRONT_ONLY);
    if (material.color)
      made.mutable_classic()->mutable_diffuse()->set_texture(texture_name(*material.color));
    if (material.bump) {
      made.mutable_bump()->set_texture(texture_name(*material.bump));
      made.mutable_bump()->set_value(material.bump_height);
    }
    return at->second;
  }

  std::string texture_name(const CrtTexture& texture) {
    const auto [at, is_new] = texture_names_.try_emplace(&texture);
    if (!is_new) return at->second;
    at->second = unique_name(&texture, "texture");
    v1::Texture& made = *scene_.add_textures();
    made = texture.message;
    made.set_name(at->second);
    return at->second;
  }

  /// The variable's name, or `kind`, with a number where it is taken.
  std::string unique_name(const void* thing, const std::string& kind) {
    const auto given = program_.names.find(thing);
    const std::string base = given != program_.names.end() ? given->second : kind;
    int& count = counts_[base];
    std::string name = base;
    while (!names_.insert(name).second) name = fmt::format("{} {}", base, ++count + 1);
    return name;
  }

  const CrtProgram& program_;
  OriginTable& origins_;
  const std::string& name_;
  std::unordered_map<const CrtEntity*, uint32_t> origin_numbers_;
  std::vector<uint32_t> making_origins_;
  v1::Scene scene_;
  std::set<std::string> names_;
  std::map<std::string, int> counts_;
  std::map<const CrtMaterial*, std::string> material_names_[2];
  std::map<const CrtTexture*, std::string> texture_names_;
};

}  // namespace

v1::Scene write_crt_scene(const CrtProgram& program, OriginTable& origins,
                          const std::string& name) {
  return Writer(program, origins, name).write();
}

std::string crt_file_reference(const std::string& written) {
  return written.substr(std::min(written.find_first_not_of('/'), written.size()));
}

}  // namespace tessera
