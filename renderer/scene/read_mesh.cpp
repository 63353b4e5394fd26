#include "renderer/scene/read_mesh.h"

#include <fmt/format.h>

#include <cmath>
#include <cstring>

#include "base/error.h"
#include "base/parallel.h"

namespace tessera {

namespace {

/// The blob as an array, or nothing where the reference is empty.
template <typename Value>
std::vector<Value> read_blob(const Where& where, std::string_view field, const v1::BlobRef& ref,
                             const BlobStore& blobs) {
  if (ref.digest().empty()) return {};
  const auto digest = Digest::parse(ref.digest());
  if (!digest) {
    fail_value(where, field, fmt::format("named '{}'", ref.digest().substr(0, 80)),
               "a digest of 64 hexadecimal digits");
  }
  const BlobData data = blobs.find(*digest);
  if (!data) {
    fail_value(where, field, fmt::format("missing: blob {}", ref.digest()), "its data");
  }
  if (data->size() != ref.size()) {
    fail_value(where, field, fmt::format("{} bytes long", data->size()),
               fmt::format("{} as the scene says", ref.size()));
  }
  if (data->size() % sizeof(Value) != 0) {
    fail_value(where, field, fmt::format("{} bytes long", data->size()),
               fmt::format("a multiple of {}", sizeof(Value)));
  }
  std::vector<Value> values(data->size() / sizeof(Value));
  if (!values.empty()) std::memcpy(static_cast<void*>(values.data()), data->data(), data->size());
  return values;
}

/// The in-line numbers as an array of `Value`.
template <typename Value, typename Numbers>
std::vector<Value> read_inline(const Where& where, std::string_view field, const Numbers& numbers) {
  using Number = std::remove_cvref_t<decltype(numbers[0])>;
  constexpr int kWidth = sizeof(Value) / sizeof(Number);
  if (numbers.size() % kWidth != 0) {
    fail_value(where, field, fmt::format("{} numbers", numbers.size()),
               fmt::format("a multiple of {}", kWidth));
  }
  std::vector<Value> values(static_cast<size_t>(numbers.size() / kWidth));
  if (!values.empty())
    std::memcpy(static_cast<void*>(values.data()), numbers.data(), values.size() * sizeof(Value));
  return values;
}

template <typename Value, typename Numbers>
std::vector<Value> read_array(const Where& where, std::string_view field, const v1::BlobRef& ref,
                              const Numbers& numbers, const BlobStore& blobs) {
  if (ref.digest().empty()) {
    return read_inline<Value>(where, fmt::format("inline_{}", field), numbers);
  }
  if (!numbers.empty()) {
    fail_value(where, field, "given both as a blob and in line", "one of them");
  }
  return read_blob<Value>(where, field, ref, blobs);
}

void check_count(const Where& where, std::string_view field, size_t count, size_t expected,
                 std::string_view per) {
  if (count == 0 || count == expected) return;
  fail_value(where, fmt::format("the number of {}", field), std::to_string(count),
             fmt::format("{}, one a {}", expected, per));
}

// Of values that one thread looks at; of several faults the first is told.
constexpr size_t kPiece = 1 << 16;

template <typename Value>
void check_finite(const Where& where, std::string_view field, const std::vector<Value>& values,
                  int threads) {
  constexpr size_t kWidth = sizeof(Value) / sizeof(float);
  for_each_piece_parallel(values.size(), kPiece, threads, [&](size_t begin, size_t end) {
    for (size_t i = begin; i < end; ++i) {
      float numbers[kWidth];
      std::memcpy(numbers, &values[i], sizeof(Value));
      for (const float number : numbers) {
        if (!std::isfinite(number)) {
          fail_value(where, fmt::format("{}[{}]", field, i), fmt::format("{}", number),
                     "finite numbers");
        }
      }
    }
  });
}

void check_indices(const Where& where, const TriangleMesh& mesh, int threads) {
  const size_t vertices = mesh.positions.size();
  for_each_piece_parallel(mesh.triangles.size(), kPiece, threads, [&](size_t begin, size_t end) {
    for (size_t i = begin; i < end; ++i) {
      for (const uint32_t index : mesh.triangles[i]) {
        if (index >= vertices) {
          fail_value(where, fmt::format("triangles[{}]", i),
                     fmt::format("a reference to vertex {}", index),
                     fmt::format("an index below {}", vertices));
        }
      }
    }
  });
}

}  // namespace

TriangleMesh read_mesh(const Where& where, const v1::TriangleMesh& in, const BlobStore& blobs,
                       size_t material_count, int threads) {
  TriangleMesh mesh;
  mesh.positions =
      read_array<Float3>(where, "positions", in.positions(), in.inline_positions(), blobs);
  mesh.triangles =
      read_array<TriangleIndices>(where, "triangles", in.triangles(), in.inline_triangles(), blobs);
  mesh.normals = read_array<Float3>(where, "normals", in.normals(), in.inline_normals(), blobs);
  mesh.colors = read_blob<Float4>(where, "colors", in.colors(), blobs);
  mesh.face_materials = read_blob<uint32_t>(where, "face_materials", in.face_materials(), blobs);
  check_count(where, "normals", mesh.normals.size(), mesh.positions.size(), "vertex");
  check_count(where, "colors", mesh.colors.size(), mesh.positions.size(), "vertex");
  check_count(where, "face_materials", mesh.face_materials.size(), mesh.triangles.size(),
              "triangle");
  mesh.uvs = read_array<Float2>(where, "uvs", in.uvs(), in.inline_uvs(), blobs);
  check_count(where, "uvs", mesh.uvs.size(), mesh.positions.size(), "vertex");
  mesh.second_uvs = read_blob<Float2>(where, "second_uvs", in.second_uvs(), blobs);
  check_count(where, "second_uvs", mesh.second_uvs.size(), mesh.positions.size(), "vertex");
  mesh.tangents = read_blob<Float4>(where, "tangents", in.tangents(), blobs);
  check_count(where, "tangents", mesh.tangents.size(), mesh.positions.size(), "vertex");
  check_finite(where, "tangents", mesh.tangents, threads);
  check_finite(where, "uvs", mesh.uvs, threads);
  check_finite(where, "second_uvs", mesh.second_uvs, threads);
  check_finite(where, "positions", mesh.positions, threads);
  check_finite(where, "normals", mesh.normals, threads);
  check_finite(where, "colors", mesh.colors, threads);
  check_indices(where, mesh, threads);
  for (size_t i = 0; i < mesh.face_materials.size(); ++i) {
    if (mesh.face_materials[i] >= std::max<size_t>(material_count, 1)) {
      fail_value(where, fmt::format("face_materials[{}]", i),
                 std::to_string(mesh.face_materials[i]),
                 fmt::format("an index below {}, the number of materials", material_count));
    }
  }
  return mesh;
}

}  // namespace tessera
