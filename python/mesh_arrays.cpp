#include "python/mesh_arrays.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <atomic>
#include <cmath>
#include <cstring>
#include <map>
#include <memory>
#include <optional>
#include <span>
#include <tuple>
#include <utility>
#include <vector>

#include "python/array_kernels.h"
#include "python/array_source.h"
#include "python/bindings.h"
#include "python/interruptible.h"
#include "renderer/film/tile.h"
#include "renderer/math/encodings.h"
#include "renderer/shapes/mesh_boundary.h"

namespace py = pybind11;

namespace tessera {
namespace {

/// "expected (8, 3), one a vertex", or "(any, 3)" where the number of rows is not known.
void check_shape(const ArraySource& source, const std::string& field, py::ssize_t columns,
                 py::ssize_t rows) {
  const Array::Shape& shape = source.shape;
  const bool is_empty = shape.size() == 1 && shape[0] == 0;
  const bool has_columns =
      columns == 0
          ? shape.size() == 1
          : shape.size() == 2 && (shape[1] == columns || (field == "colors" && shape[1] == 3));
  const bool has_rows = rows < 0 || (!shape.empty() && shape[0] == rows);
  if ((has_columns || is_empty) && has_rows) return;
  const std::string count = rows < 0 ? "any" : std::to_string(rows);
  const char* meaning = field == "triangles"        ? ""
                        : field == "face_materials" ? ", one a triangle"
                        : field == "positions"      ? ""
                                                    : ", one a vertex";
  wrong_shape(field, shape,
              columns == 0        ? fmt::format("({},){}", count, meaning)
              : field == "colors" ? fmt::format("({0}, 3) or ({0}, 4){1}", count, meaning)
                                  : fmt::format("({}, {}){}", count, columns, meaning));
}

Array::Shape blob_shape(const ArraySource& source, py::ssize_t columns) {
  const py::ssize_t rows = source.shape.empty() ? 0 : source.shape[0];
  return columns == 0 ? Array::Shape{rows} : Array::Shape{rows, columns};
}

/// About as many as are read and written where an array is converted.
size_t bytes_worked_on(const ArraySource& source) {
  return static_cast<size_t>(source.count() * source.item_size);
}

/// Copies indices as uint32; returns whether each is less than `limit`.
bool narrow_indices(const ArraySource& source, uint64_t limit, uint32_t* out) {
  const auto count = static_cast<size_t>(source.count());
  if (!source.swapped && source.is_contiguous()) {
    if (source.item_size == 4 && limit <= uint64_t{1} << 31) {
      return copy_indices<uint32_t>(source.data, count, limit, out);
    }
    if (source.item_size == 8) return copy_indices<uint64_t>(source.data, count, limit, out);
  }
  uint64_t worst = 0;  // a negative number is a huge one here
  for_each_element<uint64_t>(source, 0, source.count(), [&](uint64_t index) {
    worst = std::max(worst, index);
    *out++ = static_cast<uint32_t>(index);
  });
  return worst < limit || count == 0;
}

/// Indices as uint32, each held against `limit` before it is made narrow.
std::shared_ptr<const uint32_t[]> to_indices(const ArraySource& source, const std::string& field,
                                             uint64_t limit) {
  if (source.is_huge)
    throw py::value_error(
        fmt::format("{}: a number beyond 64 bits; expected 0 to {}", field, limit - 1));
  if (source.kind != 'i' && source.kind != 'u' && source.count() > 0) {
    throw py::type_error(fmt::format("{}: {}; expected an integer type", field,
                                     source.kind == 'f' ? "floats" : "booleans"));
  }
  const auto [indices, all_fit] =
      run_unlocked(bytes_worked_on(source), [source, limit](const std::atomic<bool>&) {
        const auto out =
            std::make_shared_for_overwrite<uint32_t[]>(static_cast<size_t>(source.count()));
        const bool fit = narrow_indices(source, limit, out.get());
        return std::pair(out, fit);
      });
  if (all_fit) return indices;
  std::optional<py::ssize_t> first;
  py::ssize_t at = 0;
  for_each_element<uint64_t>(source, 0, source.count(), [&](uint64_t index) {
    if (index >= limit && !first) first = at;
    ++at;
  });
  const py::ssize_t bad = first.value_or(0);  // another thread may have mended it meanwhile
  std::string found;
  for_each_element<int64_t>(source, bad, 1, [&](int64_t index) {
    found =
        source.kind == 'i' ? std::to_string(index) : std::to_string(static_cast<uint64_t>(index));
  });
  const py::ssize_t columns = source.shape.size() > 1 ? source.shape[1] : 1;
  const bool is_of_vertices = field == "triangles" && limit < uint64_t{1} << 32;
  throw py::value_error(fmt::format(
      "{}: index {} in row {}; expected {}", field, found, bad / std::max<py::ssize_t>(columns, 1),
      limit == 0 ? "none, since the mesh has no vertices"
                 : fmt::format("0 to {}{}", limit - 1, is_of_vertices ? ", a vertex" : "")));
}

/// Colours of vertices as linear RGB and alpha. uint8 and uint16 are codes in sRGB, as in files.
std::vector<float> to_colors(const ArraySource& source) {
  const bool is_code = source.kind == 'u' && source.item_size <= 2;
  const double largest = source.item_size == 1 ? 255 : 65535;
  // To decode a code takes as long as to hash about 32 bytes.
  auto [colors, worst] = run_unlocked(
      bytes_worked_on(source) * (is_code ? 32 : 1),
      [source, is_code, largest](const std::atomic<bool>& stop) {
        const py::ssize_t columns = source.shape.size() == 2 ? source.shape[1] : 4;
        std::vector<float> made;
        made.reserve(static_cast<size_t>(source.count() / columns * 4));
        py::ssize_t column = 0;
        double wrong = 0;
        for_each_element<double>(source, stop, [&](double value) {
          const double level = is_code ? value / largest : value;
          if (level < 0 || level > 1) wrong = level;
          made.push_back(static_cast<float>(is_code && column < 3 ? srgb_to_linear(level) : level));
          if (columns == 3 && column == 2) made.push_back(1);
          column = (column + 1) % columns;
        });
        return std::pair(std::move(made), wrong);
      });
  if (source.kind != 'f' && worst != 0) {
    throw py::value_error(fmt::format(
        "colors: the whole number {}; expected floats, or uint8 or uint16 codes in sRGB", worst));
  }
  return std::move(colors);
}

std::vector<float> to_floats(const ArraySource& source) {
  return run_unlocked(bytes_worked_on(source), [source](const std::atomic<bool>& stop) {
    std::vector<float> floats;
    if (source.is_plain(kElementOf<float>)) {
      floats.resize(static_cast<size_t>(source.count()));
      if (!floats.empty()) std::memcpy(floats.data(), source.data, floats.size() * sizeof(float));
      return floats;
    }
    floats.reserve(static_cast<size_t>(source.count()));
    for_each_element<float>(source, stop, [&](float number) { floats.push_back(number); });
    return floats;
  });
}

/// Whether `copy` of Mesh is False.
bool refuses_to_copy(py::handle copy) {
  if (copy.is_none()) return false;
  if (py::isinstance<py::bool_>(copy)) return !copy.cast<bool>();
  throw py::type_error(fmt::format("copy: {}; expected True, False or None",
                                   py::repr(copy).cast<std::string>().substr(0, 100)));
}

/// What keeps an array's memory from being used as one of `type` and `shape`; empty: nothing.
std::string what_prevents_sharing(const ArraySource& source, ElementType type,
                                  const Array::Shape& shape) {
  if (source.count() > 0 && source.shape != shape) return "it has another shape";
  if (source.is_plain(type))
    return source.read_only ? "" : "it, or what it is a view of, can be written to";
  if (source.swapped) return "it has another byte order";
  return source.is_contiguous() ? "its elements are of another type" : "it is not contiguous";
}

/// Texels keep their type where textures have it.
ElementType kept_texel_type(const ArraySource& source) {
  if (source.kind == 'u' && source.item_size == 1) return texel_type(8);
  if (source.kind == 'f') return texel_type(source.item_size == 2 ? 16 : 32);
  throw py::type_error(fmt::format("texels: {}; expected uint8, uint16 or floats",
                                   source.count() == 0  ? "no numbers"
                                   : source.kind == '?' ? "booleans"
                                   : source.kind == 'i' && source.item_size == 1
                                       ? "signed integers"
                                       : "other integers"));
}

Array share(const ArraySource& source, ElementType type, Array::Shape shape) {
  return {source.owner, source.data, type, std::move(shape)};
}

Array copy_texels(const ArraySource& source, ElementType type) {
  if (type.code == 'f') return {to_floats(source), source.shape};
  const auto kept = run_unlocked(bytes_worked_on(source), [source, type](const std::atomic<bool>&) {
    std::vector<uint8_t> bytes(static_cast<size_t>(source.count() * type.size));
    if (source.is_contiguous() && !source.swapped) {
      if (!bytes.empty()) std::memcpy(bytes.data(), source.data, bytes.size());
    } else {
      ArraySource raw = source;  // the same elements as integers, which keep their bits
      raw.kind = 'u';
      std::byte* out = reinterpret_cast<std::byte*>(bytes.data());
      for_each_element<uint16_t>(raw, 0, source.count(), [&](uint16_t texel) {
        std::memcpy(out, &texel, static_cast<size_t>(type.size));
        out += type.size;
      });
    }
    return std::make_shared<const std::vector<uint8_t>>(std::move(bytes));
  });
  return {kept, kept->data(), type, source.shape};
}

/// Writes all vertices less `middle` in single precision.
VertexBounds round_all(const ArraySource& source, const std::array<double, 3>& middle, float* out) {
  VertexBounds bounds;
  if (source.is_plain(kElementOf<double>)) {
    round_vertices(source.data, static_cast<size_t>(source.count() / 3), middle, out, bounds);
    return bounds;
  }
  // Other elements are made doubles, some at a time.
  std::array<double, 3 * 512> some;
  for (py::ssize_t at = 0; at < source.count(); at += some.size()) {
    const py::ssize_t length = std::min<py::ssize_t>(some.size(), source.count() - at);
    double* next = some.data();
    for_each_element<double>(source, at, length, [&](double number) { *next++ = number; });
    round_vertices(reinterpret_cast<const std::byte*>(some.data()), static_cast<size_t>(length / 3),
                   middle, out + at, bounds);
  }
  return bounds;
}

/// The largest move of a vertex by rounding, where that is more than a millionth of their extent;
/// else 0.
double large_move(const ArraySource& source, const std::array<double, 3>& middle,
                  const float* rounded, const VertexBounds& bounds) {
  const double allowed = bounds.extent() * 1e-6;
  if (bounds.largest_move * std::sqrt(3.0) <= allowed) return 0;
  double largest = 0;
  std::array<double, 3> by{};
  size_t i = 0;
  for_each_element<double>(source, 0, source.count(), [&](double number) {
    const size_t axis = i % 3;
    by[axis] = static_cast<double>(rounded[i++]) - (number - middle[axis]);
    if (axis == 2) largest = std::max(largest, std::hypot(by[0], by[1], by[2]));
  });
  return largest > allowed ? largest : 0;
}

/// Positions as single precision with the middle of their bounds taken off, if that is wanted:
/// (array, middle or None, large_move()).
py::tuple take_positions(py::handle given, py::handle copy, bool recenter) {
  const ArraySource source = array_source(given, "positions");
  check_shape(source, "positions", 3, -1);
  const bool refuses_copy = refuses_to_copy(copy);
  if (refuses_copy && recenter) {
    throw py::value_error(
        "positions: copy=False, but recenter=True moves them; expected one of the two");
  }
  if (!recenter && (refuses_copy || (source.kind == 'f' && source.item_size <= 4))) {
    return py::make_tuple(take_blob_array(given, "positions", copy), py::none(), 0.0);
  }
  const auto [rounded, middle, moved] =
      run_unlocked(bytes_worked_on(source), [source, recenter](const std::atomic<bool>&) {
        const auto count = static_cast<size_t>(source.count());
        const auto out = std::make_shared_for_overwrite<float[]>(count);
        std::array<double, 3> center{};
        VertexBounds bounds = round_all(source, center, out.get());
        if (recenter && count > 0) {
          for (size_t axis = 0; axis < 3; ++axis)
            center[axis] = bounds.least[axis] + (bounds.most[axis] - bounds.least[axis]) / 2;
          bounds = round_all(source, center, out.get());
        }
        return std::tuple(out, center, large_move(source, center, out.get(), bounds));
      });
  const Array array(rounded, rounded.get(), kElementOf<float>, blob_shape(source, 3));
  return py::make_tuple(array,
                        recenter ? py::object(py::make_tuple(middle[0], middle[1], middle[2]))
                                 : py::object(py::none()),
                        moved);
}

}  // namespace

ElementType texel_type(uint32_t bits) {
  if (bits == 32) return kElementOf<float>;
  return bits == 16 ? ElementType{'e', 2} : kElementOf<uint8_t>;
}

namespace {

using BlobLayouts = std::map<std::string, std::pair<ElementType, py::ssize_t>>;
const BlobLayouts& blob_layouts() {
  static const BlobLayouts layouts = {
      {"positions", {kElementOf<float>, 3}},    {"normals", {kElementOf<float>, 3}},
      {"uvs", {kElementOf<float>, 2}},          {"colors", {kElementOf<float>, 4}},
      {"triangles", {kElementOf<uint32_t>, 3}}, {"face_materials", {kElementOf<uint32_t>, 0}},
      {"tangents", {kElementOf<float>, 4}},     {"second_uvs", {kElementOf<float>, 2}},
      {"texels", {kElementOf<uint8_t>, 0}}};
  return layouts;
}

}  // namespace

std::pair<ElementType, py::ssize_t> blob_layout(const std::string& field) {
  return blob_layouts().at(field);
}

void check_texel_sides(const ArraySource& source) {
  // Those of a scene are in a row.
  if (source.shape.size() > 1 && std::max(source.shape[0], source.shape[1]) > kMaxFrameSide) {
    wrong_shape("texels", source.shape, fmt::format("sides of at most {}", kMaxFrameSide));
  }
}

py::object take_blob_array(py::handle given, const std::string& field, py::handle copy,
                           py::ssize_t rows) {
  auto [type, columns] = blob_layout(field);
  const ArraySource source = array_source(given, field);
  const bool is_texels = field == "texels";
  if (is_texels) {
    check_texel_sides(source);
    type = kept_texel_type(source);
  } else {
    // The number of triangles is free; `rows` bounds what they refer to.
    check_shape(source, field, columns, field == "triangles" ? -1 : rows);
  }
  const Array::Shape shape = is_texels ? source.shape : blob_shape(source, columns);
  const bool is_index = type.code == 'I';
  // The memory of an Array of indices is its own, and without `rows` there is nothing to check.
  const bool is_kept = py::isinstance<Array>(given) && rows < 0;
  const std::string obstacle = is_index && !is_kept ? "indices are checked and kept apart"
                                                    : what_prevents_sharing(source, type, shape);
  const bool refuses = refuses_to_copy(copy);
  if (py::isinstance<Array>(given) && obstacle.empty() && shape == source.shape) {
    return py::reinterpret_borrow<py::object>(given);
  }
  if (obstacle.empty() && (copy.is_none() || refuses)) return py::cast(share(source, type, shape));
  if (refuses && !is_index)
    throw py::value_error(fmt::format("{}: copy=False, but {}", field, obstacle));
  if (is_texels) return py::cast(copy_texels(source, type));
  if (is_index) {
    const uint64_t limit =
        field == "triangles" && rows >= 0 ? static_cast<uint64_t>(rows) : uint64_t{1} << 32;
    const auto indices = to_indices(source, field, limit);
    return py::cast(Array(indices, indices.get(), type, shape));
  }
  return py::cast(Array(field == "colors" ? to_colors(source) : to_floats(source), shape));
}

std::pair<Digest, BlobData> blob_of(const Array& array) {
  if (!array.blob().second) {
    const std::span<const std::byte> bytes = array.bytes();
    // Assigned with the GIL held, as other threads may read it at any time.
    array.blob() =
        run_unlocked(bytes.size(), [kept = array.owner(), bytes](const std::atomic<bool>&) {
          return std::pair(Digest::of(bytes), BlobData(Blob::share(kept, bytes)));
        });
  }
  return array.blob();
}

Array array_of_blob(BlobData blob, ElementType type, Array::Shape shape) {
  const void* data = blob->data();
  return {std::move(blob), data, type, std::move(shape)};
}

/// The geometry of a Mesh's arrays `positions` (v, 3) and `triangles` (t, 3).
static TriangleMesh mesh_of(const Array& positions, const Array& triangles) {
  TriangleMesh mesh;
  mesh.positions.resize(positions.bytes().size() / sizeof(Float3));
  mesh.triangles.resize(triangles.bytes().size() / sizeof(TriangleIndices));
  const auto copy = [](std::span<const std::byte> from, auto& to) {
    std::copy(from.begin(), from.end(), std::as_writable_bytes(std::span(to)).begin());
  };
  copy(positions.bytes(), mesh.positions);
  copy(triangles.bytes(), mesh.triangles);
  return mesh;
}

static Array open_edges_of(const Array& positions, const Array& triangles) {
  const std::vector<OpenEdge> edges =
      run_abandonably([positions, triangles](const std::atomic<bool>&) {
        return open_edges(mesh_of(positions, triangles));
      });
  std::vector<uint32_t> rows;
  for (const OpenEdge& edge : edges) rows.insert(rows.end(), {edge.from, edge.to});
  return {std::move(rows), {static_cast<py::ssize_t>(edges.size()), 2}};
}

static Array merged_positions(const Array& positions, double distance) {
  std::vector<float> merged = run_abandonably([positions, distance](const std::atomic<bool>&) {
    TriangleMesh mesh = mesh_of(positions, Array(std::vector<uint32_t>(), {0, 3}));
    merge_vertices(mesh, distance);
    std::vector<float> numbers(3 * mesh.positions.size());
    const auto bytes = std::as_bytes(std::span(mesh.positions));
    std::copy(bytes.begin(), bytes.end(), std::as_writable_bytes(std::span(numbers)).begin());
    return numbers;
  });
  return {std::move(merged), positions.shape()};
}

void bind_mesh_arrays(py::module_& module) {
  py::list fields;
  for (const auto& [field, layout] : blob_layouts()) fields.append(field);
  module.attr("array_fields") = py::tuple(fields);
  module.def("refuse_masked", &refuse_masked);
  module.def("open_edges", &open_edges_of, py::arg("positions"), py::arg("triangles"),
             "As Mesh.open_edges().");
  module.def("merged_positions", &merged_positions, py::arg("positions"), py::arg("distance"),
             "Those of Mesh.merge_vertices().");
  module.def("take_array", &take_blob_array, py::arg("given"), py::arg("field"),
             py::arg("copy") = py::none(), py::arg("rows") = -1,
             "The array of a mesh or texture as the renderer wants it.");
  module.def(
      "take_positions", &take_positions, py::arg("given"), py::arg("copy"), py::arg("recenter"),
      "Positions in single precision: (array, middle, the largest move by rounding if one is "
      "large, else 0).");
}

}  // namespace tessera
