#include "scenes/formats/gltf/gltf_draco.h"

#include <draco/compression/decode.h>
#include <fmt/format.h>

#include <array>
#include <limits>
#include <memory>
#include <new>
#include <stdexcept>
#include <utility>

#include "scenes/formats/gltf/gltf_accessor.h"

namespace tessera {
namespace {

std::unique_ptr<const draco::Mesh> decode(const GltfValue& extension, std::string_view bytes) {
  const auto fail = [&](std::string_view why) {
    return extension.error(fmt::format("what is no mesh in Draco's form ({})", why), "one");
  };
  draco::DecoderBuffer buffer;
  buffer.Init(bytes.data(), bytes.size());
  try {
    draco::Decoder decoder;
    auto mesh = decoder.DecodeMeshFromBuffer(&buffer);
    if (!mesh.ok()) throw fail(mesh.status().error_msg_string());
    return std::move(mesh).value();
  } catch (const std::bad_alloc&) {
    throw fail("it asks for more memory than there is");
  } catch (const std::length_error&) {
    throw fail("it asks for more memory than there is");
  }
}

template <typename Number>
std::string rows_of(const GltfValue& place, const draco::Mesh& mesh,
                    const draco::PointAttribute& attribute, size_t components) {
  std::string bytes;
  bytes.reserve(mesh.num_points() * components * sizeof(Number));
  std::array<Number, 16> row{};
  for (draco::PointIndex point(0); point < mesh.num_points(); ++point) {
    if (!attribute.ConvertValue(attribute.mapped_index(point), static_cast<int8_t>(components),
                                row.data()))
      throw place.error("numbers of another type in Draco's form", "those that its accessor has");
    bytes.append(reinterpret_cast<const char*>(row.data()), components * sizeof(Number));
  }
  return bytes;
}

std::string rows_of(const GltfValue& place, const draco::Mesh& mesh,
                    const draco::PointAttribute& attribute, const GltfAccessor::Form& form) {
  using Component = GltfAccessor::Component;
  const bool are_floats =
      attribute.data_type() == draco::DT_FLOAT32 || attribute.data_type() == draco::DT_FLOAT64;
  if (are_floats && form.component != Component::float32)
    throw place.error("whole numbers", "floats, as in Draco's form");
  if (static_cast<size_t>(attribute.num_components()) != form.components)
    place.repair(fmt::format("rows of {}", form.components),
                 fmt::format("rows of {}, as in Draco's form", attribute.num_components()),
                 "what there is not is 0");
  switch (form.component) {
    case Component::int8:
      return rows_of<int8_t>(place, mesh, attribute, form.components);
    case Component::uint8:
      return rows_of<uint8_t>(place, mesh, attribute, form.components);
    case Component::int16:
      return rows_of<int16_t>(place, mesh, attribute, form.components);
    case Component::uint16:
      return rows_of<uint16_t>(place, mesh, attribute, form.components);
    case Component::uint32:
      return rows_of<uint32_t>(place, mesh, attribute, form.components);
    case Component::float32:
      break;
  }
  return rows_of<float>(place, mesh, attribute, form.components);
}

std::string corners_of(const GltfValue& place, const draco::Mesh& mesh,
                       const GltfAccessor::Form& form) {
  std::string bytes;
  bytes.reserve(size_t{mesh.num_faces()} * 3 * form.size());
  const uint64_t most = uint64_t{1} << (8 * form.size());
  if (mesh.num_points() > most)
    throw place.error(fmt::format("{} vertices in Draco's form", mesh.num_points()),
                      fmt::format("at most {}, as its indices' type has", most));
  for (draco::FaceIndex face(0); face < mesh.num_faces(); ++face)
    for (const draco::PointIndex& corner : mesh.face(face)) {
      const uint32_t index = corner.value();
      bytes.append(reinterpret_cast<const char*>(&index), form.size());  // little-endian
    }
  return bytes;
}

}  // namespace

void unpack_draco(GltfFile& file, const GltfValue& primitive, const GltfValue& extension) {
  const auto view = extension["bufferView"].index(file.root()["bufferViews"].size(), "buffer view");
  if (!view) throw extension.error("no bufferView", "its index");
  const std::string_view bytes = file.view(*view).bytes;
  file.spend(bytes.size(), extension);
  const auto mesh = decode(extension, bytes);
  const auto give = [&](const GltfValue& reference, const std::string& rows, const auto& bytes_of,
                        size_t count) {
    const auto index = reference.index(file.root()["accessors"].size(), "accessor");
    if (!index) throw reference.error("no accessor", "its index");
    std::string source = fmt::format("{} of view {}", rows, *view);
    const GltfFile::Rows* const known = file.unpacked(*index);
    if (known && known->source == source) return;
    if (known)
      throw reference.error(fmt::format("accessor {}, which has other compressed rows", *index),
                            "one for each");
    const GltfValue accessor = file.element("accessors", *index);
    const GltfAccessor::Form form = GltfAccessor::form_of(accessor);
    file.spend(uint64_t{count} * form.components, extension);
    file.unpack(*index, {bytes_of(accessor, form), count, std::move(source)});
  };
  give(
      primitive["indices"], "corners",
      [&](const GltfValue& at, const GltfAccessor::Form& form) {
        return corners_of(at, *mesh, form);
      },
      size_t{mesh->num_faces()} * 3);
  const GltfValue packed = extension["attributes"], attributes = primitive["attributes"];
  for (const std::string& name : packed.keys()) {
    const uint64_t id = packed[name.c_str()].required_whole();
    const draco::PointAttribute* const attribute =
        id > std::numeric_limits<uint32_t>::max()
            ? nullptr
            : mesh->GetAttributeByUniqueId(static_cast<uint32_t>(id));
    if (!attribute)
      throw packed[name.c_str()].error(fmt::format("attribute {}", id), "one that the mesh has");
    if (!attributes[name.c_str()]) continue;
    give(
        attributes[name.c_str()], fmt::format("attribute {}", id),
        [&](const GltfValue& at, const GltfAccessor::Form& form) {
          return rows_of(at, *mesh, *attribute, form);
        },
        mesh->num_points());
  }
  for (const std::string& name : attributes.keys()) {
    const auto index = attributes[name.c_str()].index(file.root()["accessors"].size(), "accessor");
    if (packed[name.c_str()] || !index) continue;
    const GltfValue accessor = file.element("accessors", *index);
    if (accessor["bufferView"] || accessor["sparse"]) continue;
    constexpr std::string_view kExpected = "its number in the compressed mesh";
    if (name == "POSITION") throw packed.error("no POSITION", kExpected);
    packed.repair("no " + name, kExpected, "zeros are read");
  }
}

}  // namespace tessera
