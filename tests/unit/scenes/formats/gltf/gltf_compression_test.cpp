#include <draco/compression/encode.h>
#include <draco/mesh/triangle_soup_mesh_builder.h>
#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <meshoptimizer.h>

#include <array>

#include "tests/unit/scenes/formats/gltf/gltf_files.h"

namespace tessera::gltf_files {
namespace {

using Bytes = std::vector<unsigned char>;
using testing::HasSubstr;

// ------------------------------------------------------------------------------- meshoptimizer

template <typename T>
Bytes packed_rows(const std::vector<T>& values, size_t stride) {
  const size_t count = values.size() * sizeof(T) / stride;
  Bytes out(meshopt_encodeVertexBufferBound(count, stride));
  out.resize(meshopt_encodeVertexBuffer(out.data(), out.size(), values.data(), count, stride));
  return out;
}

Bytes packed_corners(const Indices& corners, bool are_triangles) {
  Bytes out(are_triangles ? meshopt_encodeIndexBufferBound(corners.size(), 100)
                          : meshopt_encodeIndexSequenceBound(corners.size(), 100));
  using Encode = size_t (*)(unsigned char*, size_t, const unsigned*, size_t);
  const Encode triangles = meshopt_encodeIndexBuffer, sequence = meshopt_encodeIndexSequence;
  const Encode encode = are_triangles ? triangles : sequence;
  out.resize(encode(out.data(), out.size(), corners.data(), corners.size()));
  return out;
}

std::string rows(size_t stride, size_t count, const std::string& more = "") {
  return R"("byteStride":)" + std::to_string(stride) + R"(,"count":)" + std::to_string(count) +
         R"(,"mode":"ATTRIBUTES")" + more;
}

const Indices kCorners{0, 1, 2, 0, 2, 3};

/// A square whose positions and corners stand in that form: `how` is said of the positions.
std::string square(const std::string& how, const std::string& mode = "TRIANGLES",
                   Bytes positions = packed_rows(kSquare, 12)) {
  return Binary()
      .put_packed(positions, 48, how)
      .put_packed(packed_corners(kCorners, mode == "TRIANGLES"), 24,
                  R"("byteStride":4,"count":6,"mode":")" + mode + "\"")
      .glb(kNode + R"("extensionsRequired":["EXT_meshopt_compression"],)" +
           mesh(R"({"attributes":{"POSITION":0},"indices":1})") + R"(,"accessors":[)" +
           accessor(0, 5126, 4, "VEC3") + "," + accessor(1, 5125, 6, "SCALAR") + "]");
}

TEST(GltfCompression, MeshoptimizersRowsAndCornersAreUnpacked) {
  for (const char* mode : {"TRIANGLES", "INDICES"}) {
    const LoadedScene loaded = read(square(rows(12, 4), mode));
    EXPECT_EQ(loaded.warnings, std::vector<std::string>{});
    EXPECT_EQ(first_mesh(loaded).positions, kSquare) << mode;
    EXPECT_EQ(first_mesh(loaded).triangles.size(), 6u) << mode;
  }
}

TEST(GltfCompression, MeshoptimizersFiltersAreUndone) {
  const std::vector<std::array<float, 4>> normals{
      {0, 0, 1, 0}, {0, 1, 0, 0}, {0.6F, 0, 0.8F, 0}, {0, -0.6F, -0.8F, 0}};
  std::vector<int16_t> turned(16);
  meshopt_encodeFilterOct(turned.data(), 4, 8, 16, normals.front().data());
  Floats exponents(12);
  meshopt_encodeFilterExp(exponents.data(), 4, 12, 20, kSquare.data());
  const LoadedScene loaded = read(
      Binary()
          .put_packed(packed_rows(exponents, 12), 48, rows(12, 4, R"(,"filter":"EXPONENTIAL")"))
          .put_packed(packed_rows(turned, 8), 32, rows(8, 4, R"(,"filter":"OCTAHEDRAL")"))
          .glb(kNode + mesh(R"({"attributes":{"POSITION":0,"NORMAL":1},"mode":5})") +
               R"(,"accessors":[)" + accessor(0, 5126, 4, "VEC3") + "," +
               accessor(1, 5122, 4, "VEC4", R"(,"normalized":true)") + "]"));
  EXPECT_EQ(loaded.warnings, std::vector<std::string>{});
  const Mesh mesh = first_mesh(loaded);
  EXPECT_EQ(mesh.positions, kSquare);
  ASSERT_EQ(mesh.normals.size(), 12u);
  for (size_t i = 0; i < 12; ++i) EXPECT_NEAR(mesh.normals[i], normals[i / 3][i % 3], 1e-4) << i;
}

TEST(GltfCompression, WhatIsNotInMeshoptimizersFormIsToldWithItsPlace) {
  const auto check = [](const std::string& how, const std::string& problem) {
    EXPECT_THAT(error(square(how)),
                HasSubstr("bufferViews/0/extensions/EXT_meshopt_compression" + problem))
        << how;
  };
  check(rows(10, 4), "/byteStride: rows of 10 bytes; expected a multiple of 4 up to 256");
  check(rows(0, 4), "/byteStride: rows of 0 bytes");
  check(rows(260, 4), "/byteStride: rows of 260 bytes");
  check(rows(12, 500), ": what is not in meshoptimizer's form; expected 500 rows");
  check(rows(12, size_t{1} << 40), "/count: 1099511627776 rows in ");
  check(rows(12, 4, R"(,"filter":"QUATERNION")"), "/byteStride: rows of 12 bytes; expected 8");
  check(rows(12, 4, R"(,"filter":"SMOOTH")"), "/filter: 'SMOOTH'; expected NONE, OCTAHEDRAL");
  check(R"("byteStride":12,"count":4,"mode":"ROWS")", "/mode: 'ROWS'; expected ATTRIBUTES");
  check(R"("byteStride":4,"count":4,"mode":"TRIANGLES")", "/count: 4 corners of triangles");
  Bytes cut = packed_rows(kSquare, 12);
  for (size_t size = 0; size < cut.size(); ++size) {
    EXPECT_THAT(error(square(rows(12, 4), "TRIANGLES", Bytes(cut.begin(), cut.begin() + size))),
                HasSubstr("EXT_meshopt_compression"))
        << size;
  }
}

TEST(GltfCompression, MeshoptimizersOwnStrideIsTaken) {
  // Corners of four bytes that the accessor reads as two.
  const std::string wide =
      Binary()
          .put_packed(packed_rows(kSquare, 12), 48, rows(12, 4))
          .put_packed(packed_corners(kCorners, true), 24,
                      R"("byteStride":4,"count":6,"mode":"TRIANGLES")")
          .glb(kNode + mesh(R"({"attributes":{"POSITION":0},"indices":1})") + R"(,"accessors":[)" +
               accessor(0, 5126, 4, "VEC3") + "," + accessor(1, 5123, 6, "SCALAR") + "]");
  EXPECT_EQ(first_mesh(read(wide)).triangles.size(), 6u);
  EXPECT_EQ(first_mesh(read(wide)).positions, kSquare);
}

// --------------------------------------------------------------------------------------- Draco

/// The square with normals and texture coordinates as unique attributes 0, 1 and 2; exact.
std::vector<char> draco_square() {
  draco::TriangleSoupMeshBuilder builder;
  builder.Start(2);
  const std::array<int, 3> ids{
      builder.AddAttribute(draco::GeometryAttribute::POSITION, 3, draco::DT_FLOAT32),
      builder.AddAttribute(draco::GeometryAttribute::NORMAL, 3, draco::DT_FLOAT32),
      builder.AddAttribute(draco::GeometryAttribute::TEX_COORD, 2, draco::DT_FLOAT32)};
  const std::array<float, 3> up{0, 0, 1};
  for (size_t face = 0; face < 2; ++face) {
    const auto corner = [&](size_t i) { return &kSquare[size_t{kCorners[3 * face + i]} * 3]; };
    const draco::FaceIndex at(static_cast<uint32_t>(face));
    builder.SetAttributeValuesForFace(ids[0], at, corner(0), corner(1), corner(2));
    builder.SetAttributeValuesForFace(ids[1], at, up.data(), up.data(), up.data());
    builder.SetAttributeValuesForFace(ids[2], at, corner(0), corner(1), corner(2));
  }
  const auto mesh = builder.Finalize();
  draco::Encoder encoder;
  draco::EncoderBuffer buffer;
  EXPECT_TRUE(encoder.EncodeMeshToBuffer(*mesh, &buffer).ok());
  return {buffer.data(), buffer.data() + buffer.size()};
}

std::string loose(int type, int count, const std::string& kind) {
  return R"({"componentType":)" + std::to_string(type) + R"(,"count":)" + std::to_string(count) +
         R"(,"type":")" + kind + "\"}";
}

std::string draco_file(const std::vector<char>& bytes, const std::string& attributes,
                       const std::string& more = "", int count = 4) {
  return Binary().put(bytes).put(kSquare).glb(
      kNode + R"("extensionsRequired":["KHR_draco_mesh_compression"],)" +
      mesh(R"({"attributes":{"POSITION":0,"NORMAL":1,"TEXCOORD_0":2},"indices":3,)"
           R"("extensions":{"KHR_draco_mesh_compression":{"bufferView":0,"attributes":{)" +
           attributes + "}}}" + more + "}") +
      R"(,"accessors":[)" + loose(5126, count, "VEC3") + "," + loose(5126, count, "VEC3") + "," +
      loose(5126, count, "VEC2") + "," + loose(5123, 6, "SCALAR") + "]");
}

const std::string kAll = R"("POSITION":0,"NORMAL":1,"TEXCOORD_0":2)";

/// The corners of the triangles one by one.
Floats corners_of(const Mesh& mesh, const Floats& values, size_t width) {
  Floats out;
  for (const uint32_t corner : mesh.triangles)
    out.insert(out.end(), values.begin() + static_cast<ptrdiff_t>(corner * width),
               values.begin() + static_cast<ptrdiff_t>((corner + 1) * width));
  return out;
}

TEST(GltfCompression, DracosMeshesAreUnpacked) {
  // A strip too is held triangle by triangle.
  for (const char* more : {"", R"(,"mode":5)"}) {
    const LoadedScene loaded = read(draco_file(draco_square(), kAll, more));
    EXPECT_EQ(loaded.warnings, std::vector<std::string>{});
    const Mesh mesh = first_mesh(loaded);
    ASSERT_EQ(mesh.triangles.size(), 6u) << more;
    EXPECT_EQ(mesh.positions.size(), 12u);
    double area = 0;
    const Floats p = corners_of(mesh, mesh.positions, 3);
    for (size_t t = 0; t < 18; t += 9)
      area += (p[t + 3] - p[t]) * (p[t + 7] - p[t + 1]) - (p[t + 6] - p[t]) * (p[t + 4] - p[t + 1]);
    EXPECT_EQ(area / 2, 1) << "counter-clockwise, without overlap";
    for (size_t i = 0; i < 4; ++i) {
      EXPECT_EQ(mesh.uvs[2 * i], mesh.positions[3 * i]);
      EXPECT_EQ(mesh.uvs[2 * i + 1], 1 - mesh.positions[3 * i + 1]) << "as glTF counts";
      EXPECT_EQ(mesh.normals[3 * i + 2], 1);
    }
  }
}

TEST(GltfCompression, DracosOwnCountsAreTaken) {
  const LoadedScene loaded = read(draco_file(draco_square(), kAll, "", 9));
  EXPECT_EQ(first_mesh(loaded).positions.size(), 12u);
  ASSERT_FALSE(loaded.warnings.empty());
  EXPECT_THAT(loaded.warnings[0], HasSubstr("accessors/0/count: 9 rows; expected 4, as its "
                                            "compressed mesh has; these are taken"));
}

TEST(GltfCompression, WhatIsNotInDracosFormIsToldWithItsPlace) {
  const std::string place = "KHR_draco_mesh_compression";
  const std::vector<char> whole = draco_square();
  for (size_t size = 0; size < whole.size(); ++size) {
    const std::string told =
        error(draco_file({whole.begin(), whole.begin() + static_cast<ptrdiff_t>(size)}, kAll));
    EXPECT_THAT(told, HasSubstr(place)) << size;
  }
  EXPECT_THAT(error(draco_file(whole, R"("POSITION":7)")),
              HasSubstr(place + "/attributes/POSITION: attribute 7; expected one that the mesh"));
}

/// A file with these primitives, whose accessors 0 to 3 are as in draco_file() and 4 to 7 as these.
std::string draco_primitives(const std::string& primitives, int corners = 5123) {
  const std::string own = loose(5126, 4, "VEC3") + "," + loose(5126, 4, "VEC3") + "," +
                          loose(5126, 4, "VEC2") + "," + loose(corners, 6, "SCALAR");
  return Binary()
      .put(draco_square())
      .put(draco_square())
      .glb(kNode + mesh(primitives) + R"(,"accessors":[)" + own + "," + own + "]");
}

std::string draco_primitive(int view, const std::string& accessors, const std::string& packed,
                            const std::string& more = "") {
  return R"({"attributes":{)" + accessors + R"(},"indices":3,"extensions":)" +
         R"({"KHR_draco_mesh_compression":{"bufferView":)" + std::to_string(view) +
         R"(,"attributes":{)" + packed + "}}}" + more + "}";
}

TEST(GltfCompression, AnAccessorHasTheRowsOfOneDracoMesh) {
  const std::string at = R"("POSITION":0)";
  const LoadedScene twice =
      read(draco_primitives(draco_primitive(0, at, at) + "," + draco_primitive(0, at, at)));
  EXPECT_EQ(twice.warnings, std::vector<std::string>{}) << "the same ones are no contradiction";
  EXPECT_EQ(first_mesh(twice).triangles.size(), 12u);
  const LoadedScene other =
      read(draco_primitives(draco_primitive(0, at, at) + "," + draco_primitive(1, at, at)));
  EXPECT_EQ(first_mesh(other).triangles.size(), 6u) << "the second primitive is left out";
  EXPECT_THAT(only_warning(other),
              HasSubstr("accessor 3, which has other compressed rows; expected one for each"));
  EXPECT_THAT(error(draco_primitives(
                  draco_primitive(0, R"("NORMAL":0,"POSITION":0)", R"("NORMAL":1,"POSITION":0)"))),
              HasSubstr("attributes/POSITION: accessor 0, which has other compressed rows"));
}

TEST(GltfCompression, WhatADracoMeshLacksIsTold) {
  EXPECT_THAT(error(draco_primitives(draco_primitive(0, R"("POSITION":0)", ""))),
              HasSubstr("KHR_draco_mesh_compression/attributes: no POSITION; expected its number"));
  const LoadedScene loaded =
      read(draco_primitives(draco_primitive(0, R"("POSITION":0,"NORMAL":1)", R"("POSITION":0)")));
  EXPECT_THAT(only_warning(loaded), HasSubstr("no NORMAL; expected its number in the compressed "
                                              "mesh; zeros are read"));
  // Texture coordinates as positions, and the other way round.
  const LoadedScene narrow =
      read(draco_primitives(draco_primitive(0, R"("POSITION":0)", R"("POSITION":2)")));
  EXPECT_THAT(only_warning(narrow), HasSubstr("rows of 3; expected rows of 2, as in Draco's form"));
  EXPECT_THAT(error(draco_primitives(
                  draco_primitive(0, R"("POSITION":0,"_ID":7)", R"("POSITION":0,"_ID":0)"))),
              HasSubstr("whole numbers; expected floats, as in Draco's form"));
  const LoadedScene mode = read(
      draco_primitives(draco_primitive(0, R"("POSITION":0)", R"("POSITION":0)", R"(,"mode":1)")));
  EXPECT_EQ(first_mesh(mode).triangles.size(), 6u);
  EXPECT_THAT(only_warning(mode),
              HasSubstr("1; expected 4 or 5, as of compressed meshes; triangles are read"));
}

TEST(GltfCompression, TheSameBytesAreNotUnpackedAgainAndAgain) {
  const std::string one =
      R"({"attributes":{"POSITION":0},"indices":1,"extensions":{"KHR_draco_mesh_compression":)"
      R"({"bufferView":0,"attributes":{"POSITION":0}}}})";
  std::string all = one;
  for (int i = 0; i < 2100; ++i) all += "," + one;
  EXPECT_THAT(error(Binary()
                        .put(std::vector<char>(size_t{1} << 20, 'x'))
                        .glb(kNode + mesh(all) + R"(,"accessors":[)" + loose(5126, 3, "VEC3") +
                             "," + loose(5123, 3, "SCALAR") + "]")),
              HasSubstr("too much in all"));
}

TEST(GltfCompression, WithoutDracoWhatIsThereIsRead) {
  const std::string file =
      Binary()
          .put(std::vector<char>(40, 'x'))
          .put(kSquare)
          .glb(
              kNode + R"("extensionsUsed":["KHR_draco_mesh_compression"],)" +
              mesh(
                  R"({"attributes":{"POSITION":0},"mode":5,"extensions":{"KHR_draco_mesh_compression":)"
                  R"({"bufferView":0,"attributes":{"POSITION":0}}}})") +
              R"(,"accessors":[)" + accessor(1, 5126, 4, "VEC3") + "]");
  const LoadedScene loaded = read(file);
  EXPECT_EQ(first_mesh(loaded).positions, kSquare);
  EXPECT_EQ(first_mesh(loaded).triangles.size(), 6u);
  EXPECT_THAT(only_warning(loaded), HasSubstr("what it has without compression is read"));
}

}  // namespace
}  // namespace tessera::gltf_files
