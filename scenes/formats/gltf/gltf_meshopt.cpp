#include "scenes/formats/gltf/gltf_meshopt.h"

#include <fmt/format.h>
#include <meshoptimizer.h>

namespace tessera {
namespace {

/// Zeros take least of all: 2 bits for 16 bytes.
constexpr uint64_t kMostGrowth = 64;

}  // namespace

std::string unpack_meshopt(GltfFile& file, const GltfValue& extension, std::string_view packed) {
  const GltfValue given_stride = extension["byteStride"], given_count = extension["count"];
  const uint64_t stride = given_stride.required_whole(), count = given_count.required_whole();
  const std::string mode = extension["mode"].text(""), filter = extension["filter"].text("NONE");
  const bool is_rows = mode == "ATTRIBUTES", is_triangles = mode == "TRIANGLES";
  if (!is_rows && !is_triangles && mode != "INDICES")
    throw extension["mode"].error(extension["mode"].shown(), "ATTRIBUTES, TRIANGLES or INDICES");
  const bool is_of_rows = stride % 4 == 0 && stride > 0 && stride <= 256;
  if (is_rows ? !is_of_rows : stride != 2 && stride != 4)
    throw given_stride.error(fmt::format("rows of {} bytes", stride),
                             is_rows ? "a multiple of 4 up to 256" : "2 or 4");
  if (is_triangles && count % 3 != 0)
    throw given_count.error(fmt::format("{} corners of triangles", count), "a multiple of 3");
  if (count > kMostGrowth * packed.size())
    throw given_count.error(fmt::format("{} rows in {} bytes", count, packed.size()), "fewer");
  file.spend(count * stride, extension);
  std::string rows(count * stride, '\0');
  const auto* const bytes = reinterpret_cast<const unsigned char*>(packed.data());
  using Decode = int (*)(void*, size_t, size_t, const unsigned char*, size_t);
  Decode decode = meshopt_decodeVertexBuffer;
  if (is_triangles) decode = meshopt_decodeIndexBuffer;
  if (mode == "INDICES") decode = meshopt_decodeIndexSequence;
  if (decode(rows.data(), count, stride, bytes, packed.size()) != 0)
    throw extension.error("what is not in meshoptimizer's form", fmt::format("{} rows", count));
  if (filter == "NONE" || !is_rows) return rows;
  const auto needs = [&](bool fits, const char* expected) {
    if (!fits) throw given_stride.error(fmt::format("rows of {} bytes", stride), expected);
  };
  if (filter == "OCTAHEDRAL") {
    needs(stride == 4 || stride == 8, "4 or 8, as the filter has");
    meshopt_decodeFilterOct(rows.data(), count, stride);
  } else if (filter == "QUATERNION") {
    needs(stride == 8, "8, as the filter has");
    meshopt_decodeFilterQuat(rows.data(), count, stride);
  } else if (filter == "EXPONENTIAL") {
    meshopt_decodeFilterExp(rows.data(), count, stride);
  } else {
    throw extension["filter"].error(extension["filter"].shown(),
                                    "NONE, OCTAHEDRAL, QUATERNION or EXPONENTIAL");
  }
  return rows;
}

}  // namespace tessera
