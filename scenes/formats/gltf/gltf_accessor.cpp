#include "scenes/formats/gltf/gltf_accessor.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cstring>
#include <limits>

namespace tessera {
namespace {

/// Zeros cost the file nothing, so that their number has to be bounded some other way.
constexpr uint64_t kMaxZeros = uint64_t{1} << 24;

template <typename Number>
Number load(const char* at) {
  Number number;
  std::memcpy(&number, at, sizeof number);
  return number;
}

}  // namespace

std::optional<GltfAccessor> GltfAccessor::read(GltfFile& file, const GltfValue& reference,
                                               std::string_view taken) {
  std::optional<GltfAccessor> out;
  const auto index = reference.index(file.root()["accessors"].size(), "accessor", taken);
  if (index)
    file.attempt(taken, [&] { out = GltfAccessor(file, *index); });
  else
    file.keep_problem(reference.error("no accessor", "its index"));
  return out;
}

GltfAccessor::Component GltfAccessor::component_of(const GltfValue& type) {
  constexpr std::array<std::pair<uint64_t, Component>, 6> kTypes{{{5120, Component::int8},
                                                                  {5121, Component::uint8},
                                                                  {5122, Component::int16},
                                                                  {5123, Component::uint16},
                                                                  {5125, Component::uint32},
                                                                  {5126, Component::float32}}};
  const uint64_t number = type.required_whole();
  for (const auto& [known, component] : kTypes)
    if (number == known) return component;
  throw type.error(fmt::format("{}", number), "5120 to 5123, 5125 or 5126");
}

size_t GltfAccessor::size_of(Component component) {
  constexpr std::array<size_t, 6> kSizes{1, 1, 2, 2, 4, 4};
  return kSizes[static_cast<size_t>(component)];
}

GltfAccessor::Form GltfAccessor::form_of(const GltfValue& accessor) {
  constexpr std::array<std::pair<std::string_view, size_t>, 5> kTypes{
      {{"SCALAR", 1}, {"VEC2", 2}, {"VEC3", 3}, {"VEC4", 4}, {"MAT4", 16}}};
  const Component component = component_of(accessor["componentType"]);
  const GltfValue type = accessor["type"];
  const std::string name = type.text("");
  const auto found = std::find_if(kTypes.begin(), kTypes.end(),
                                  [&](const auto& known) { return known.first == name; });
  if (found == kTypes.end()) throw type.error(type.shown(), "SCALAR, VEC2, VEC3, VEC4 or MAT4");
  return {component, found->second};
}

GltfAccessor::GltfAccessor(GltfFile& file, size_t index)
    : value_(file.element("accessors", index)) {
  const Form form = form_of(value_);
  component_ = form.component;
  components_ = form.components;
  normalized_ = value_["normalized"].flag(false) && component_ != Component::float32;
  uint64_t count = value_["count"].required_whole();
  if (const GltfFile::Rows* const unpacked = file.unpacked(index)) {
    if (count != unpacked->count)
      value_["count"].repair(fmt::format("{} rows", count),
                             fmt::format("{}, as its compressed mesh has", unpacked->count),
                             "these are taken");
    count = unpacked->count;
    rows_ = {unpacked->bytes.data(), components_ * size_of(component_)};
  } else if (value_["bufferView"]) {
    rows_ = rows(file, value_, count, components_, component_);
  } else if (count > kMaxZeros) {
    throw value_["count"].error(fmt::format("{} zeros", count),
                                fmt::format("at most {}", kMaxZeros));
  }
  count_ = count;
  if (const GltfValue sparse = value_["sparse"]) read_sparse(file, sparse);
}

GltfAccessor::Rows GltfAccessor::rows(GltfFile& file, const GltfValue& holder, size_t count,
                                      size_t components, Component type) {
  const size_t size = size_of(type), row_size = components * size;
  const auto which = holder["bufferView"].index(file.root()["bufferViews"].size(), "buffer view");
  if (!which) throw holder.error("no bufferView", "its index");
  const GltfFile::View view = file.view(*which);
  const size_t stride = view.stride == 0 ? row_size : view.stride;
  if (stride < row_size)
    throw holder.error(fmt::format("rows of {} bytes every {}", row_size, stride),
                       "rows that do not overlap");
  const uint64_t offset = holder["byteOffset"].whole().value_or(0);
  constexpr std::string_view kTaken = "it is taken all the same";
  const std::string rule = fmt::format("a multiple of {}, the size of a component", size);
  if ((view.begin + offset) % size != 0)
    holder.repair(fmt::format("byte {} of the buffer", view.begin + offset), rule, kTaken);
  if (stride % size != 0)
    file.element("bufferViews", *which)["byteStride"].repair(fmt::format("{}", stride), rule,
                                                             kTaken);
  const size_t held = view.bytes.size();
  const size_t rows_held =
      offset > held || held - offset < row_size ? 0 : (held - offset - row_size) / stride + 1;
  if (count > rows_held)
    throw holder.error(fmt::format("{} rows in a buffer view that holds {}", count, rows_held),
                       "rows that it holds");
  return {view.bytes.data() + std::min<uint64_t>(offset, held), stride};
}

void GltfAccessor::read_sparse(GltfFile& file, const GltfValue& sparse) {
  const uint64_t count = sparse["count"].required_whole();
  if (count > count_)
    throw sparse["count"].error(fmt::format("{} of {} rows", count, count_), "no more than all");
  file.spend(count, sparse);
  const GltfValue indices = sparse["indices"];
  const Component type = component_of(indices["componentType"]);
  if (type != Component::uint8 && type != Component::uint16 && type != Component::uint32)
    throw indices["componentType"].error("a type of no index", "5121, 5123 or 5125");
  const Rows numbers = rows(file, indices, count, 1, type);
  sparse_.values = rows(file, sparse["values"], count, components_, component_);
  for (size_t i = 0; i < count; ++i) {
    const char* const at = numbers.data + i * numbers.stride;
    const uint32_t row = type == Component::uint8    ? load<uint8_t>(at)
                         : type == Component::uint16 ? load<uint16_t>(at)
                                                     : load<uint32_t>(at);
    const bool increases = sparse_.rows.empty() || row > sparse_.rows.back();
    if (row >= count_ || !increases)
      throw indices.error(fmt::format("index {} of {}", row, count_),
                          "increasing ones below the accessor's count");
    sparse_.rows.push_back(row);
  }
}

const char* GltfAccessor::row(size_t index) const {
  const auto found = std::lower_bound(sparse_.rows.begin(), sparse_.rows.end(), index);
  if (found != sparse_.rows.end() && *found == index)
    return sparse_.values.data +
           static_cast<size_t>(found - sparse_.rows.begin()) * sparse_.values.stride;
  return rows_.data ? rows_.data + index * rows_.stride : nullptr;
}

double GltfAccessor::value(const char* row, size_t component) const {
  if (!row) return 0;
  const char* const at = row + component * size_of(component_);
  switch (component_) {
    case Component::int8:
      return normalized_ ? std::max(load<int8_t>(at) / 127.0, -1.0) : load<int8_t>(at);
    case Component::uint8:
      return load<uint8_t>(at) / (normalized_ ? 255.0 : 1.0);
    case Component::int16:
      return normalized_ ? std::max(load<int16_t>(at) / 32767.0, -1.0) : load<int16_t>(at);
    case Component::uint16:
      return load<uint16_t>(at) / (normalized_ ? 65535.0 : 1.0);
    case Component::uint32:
      return load<uint32_t>(at) / (normalized_ ? 4294967295.0 : 1.0);
    case Component::float32:
      break;
  }
  return double{load<float>(at)};
}

std::vector<float> GltfAccessor::floats(size_t first, size_t last, size_t width) const {
  std::vector<float> out;
  out.reserve((last - first) * width);
  for (size_t i = first; i < last; ++i) {
    const char* const at = row(i);
    for (size_t c = 0; c < width; ++c) {
      out.push_back(static_cast<float>(c < components_ ? value(at, c) : 1));
    }
  }
  return out;
}

std::vector<uint32_t> GltfAccessor::indices() const {
  if (components_ != 1 || component_ == Component::float32 || normalized_)
    throw value_.error("other numbers than an index", "SCALAR of whole numbers");
  std::vector<uint32_t> out;
  out.reserve(count_);
  for (size_t i = 0; i < count_; ++i) {
    const double number = value(row(i), 0);
    out.push_back(number < 0 ? std::numeric_limits<uint32_t>::max()
                             : static_cast<uint32_t>(number));
  }
  return out;
}

}  // namespace tessera
