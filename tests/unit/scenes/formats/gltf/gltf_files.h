#pragma once

#include <gtest/gtest.h>

#include <cstdint>
#include <string>
#include <vector>

#include "scenes/formats/gltf/gltf_reader.h"
#include "tests/error_of.h"
#include "tests/unit/scenes/scene_testing.h"

namespace tessera::gltf_files {

using Floats = std::vector<float>;
using Indices = std::vector<uint32_t>;

/// The binary part of a file, with a buffer view for each array that is put in.
class Binary {
 public:
  template <typename T>
  Binary& put(const std::vector<T>& values, size_t stride = 0) {
    const size_t begin = bytes_.size(), size = values.size() * sizeof(T);
    bytes_.append(reinterpret_cast<const char*>(values.data()), size);
    views_ += views_.empty() ? "" : ",";
    views_ += R"({"buffer":0,"byteOffset":)" + std::to_string(begin) + R"(,"byteLength":)" +
              std::to_string(size) +
              (stride > 0 ? R"(,"byteStride":)" + std::to_string(stride) : "") + "}";
    bytes_.resize((bytes_.size() + 3) / 4 * 4);
    return *this;
  }
  /// A buffer view of `rows` bytes that stand in meshoptimizer's form, with `how` of its extension.
  Binary& put_packed(const std::vector<unsigned char>& bytes, size_t rows, const std::string& how) {
    views_ += (views_.empty() ? "" : ",") +
              (R"({"buffer":0,"byteLength":)" + std::to_string(rows)) +
              R"(,"extensions":{"EXT_meshopt_compression":{"buffer":0,"byteOffset":)" +
              std::to_string(bytes_.size()) + R"(,"byteLength":)" + std::to_string(bytes.size()) +
              "," + how + "}}}";
    bytes_.append(reinterpret_cast<const char*>(bytes.data()), bytes.size());
    bytes_.resize((bytes_.size() + 3) / 4 * 4);
    return *this;
  }
  /// A .glb of the members of the JSON object and these arrays.
  std::string glb(const std::string& members) const {
    std::string json = R"({"asset":{"version":"2.0"},"buffers":[{"byteLength":)" +
                       std::to_string(bytes_.size()) + R"(}],"bufferViews":[)" + views_ + "]," +
                       members + "}";
    json.resize((json.size() + 3) / 4 * 4, ' ');
    const auto word = [](size_t value) {
      const auto number = static_cast<uint32_t>(value);
      return std::string(reinterpret_cast<const char*>(&number), sizeof number);
    };
    return "glTF" + word(2) + word(28 + json.size() + bytes_.size()) + word(json.size()) + "JSON" +
           json + word(bytes_.size()) + std::string("BIN\0", 4) + bytes_;
  }

 private:
  std::string bytes_, views_;
};

inline LoadedScene read(const std::string& bytes) { return parse_gltf(bytes, "t.glb"); }
inline std::string error(const std::string& bytes) {
  return error_of([&] { parse_gltf(bytes, "t.gltf"); });
}

struct Mesh {
  Floats positions, normals, uvs, colors;
  Indices triangles, face_materials;
};

inline Mesh mesh_of(const v1::Shape& shape, const BlobStore& blobs) {
  const v1::TriangleMesh& in = shape.mesh();
  return {blob_values<float>(in.positions(), blobs),
          blob_values<float>(in.normals(), blobs),
          blob_values<float>(in.uvs(), blobs),
          blob_values<float>(in.colors(), blobs),
          blob_values<uint32_t>(in.triangles(), blobs),
          blob_values<uint32_t>(in.face_materials(), blobs)};
}

inline Mesh first_mesh(const LoadedScene& loaded) {
  return mesh_of(loaded.scene.nodes(0).shape(), loaded.blobs);
}

inline const Floats kSquare{0, 0, 0, 1, 0, 0, 1, 1, 0, 0, 1, 0};
inline const std::string kNode = R"("nodes":[{"mesh":0}],)";

inline std::string accessor(int view, int type, int count, const std::string& kind,
                            const std::string& more = "") {
  return R"({"bufferView":)" + std::to_string(view) + R"(,"componentType":)" +
         std::to_string(type) + R"(,"count":)" + std::to_string(count) + R"(,"type":")" + kind +
         "\"" + more + "}";
}

inline std::string mesh(const std::string& primitives) {
  return R"("meshes":[{"primitives":[)" + primitives + "]}]";
}

inline const std::string kTriangle = mesh(R"({"attributes":{"POSITION":0}})") +
                                     R"(,"accessors":[)" + accessor(0, 5126, 3, "VEC3") + "]";

inline std::string material(const std::string& body, const std::string& more = "") {
  return Binary().put(kSquare).glb(kNode + mesh(R"({"attributes":{"POSITION":0},"material":0})") +
                                   R"(,"accessors":[)" + accessor(0, 5126, 3, "VEC3") +
                                   R"(],"materials":[{)" + body + "}]" + more);
}

inline std::vector<std::string> warnings(const std::string& text) {
  return parse_gltf(text, "t.gltf").warnings;
}

inline std::string with_node(const std::string& node) {
  return R"({"asset":{"version":"2.0"},"nodes":[{"camera":0},{"camera":0,)" + node +
         R"(,"children":[2]},{"camera":0}],"cameras":[{"type":"perspective","perspective":)"
         R"({"yfov":1}}]})";
}

/// The warnings without the place, where there is but one.
inline std::string only_warning(const LoadedScene& loaded) {
  EXPECT_EQ(loaded.warnings.size(), 1u) << testing::PrintToString(loaded.warnings);
  if (loaded.warnings.empty()) return "";
  const std::string& whole = loaded.warnings.front();
  return whole.substr(whole.find(": ") + 2);
}

}  // namespace tessera::gltf_files
