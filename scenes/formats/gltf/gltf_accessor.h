#pragma once

#include <cstddef>
#include <cstdint>
#include <optional>
#include <vector>

#include "scenes/formats/gltf/gltf_file.h"

namespace tessera {

/// An array of a glTF file: what an accessor says, checked against its bytes. Refers to the file.
class GltfAccessor {
 public:
  /// The accessor that `reference` holds the index of. Where it cannot be read, nothing, with a
  /// warning that says what is `taken`.
  static std::optional<GltfAccessor> read(GltfFile& file, const GltfValue& reference,
                                          std::string_view taken);

  size_t count() const { return count_; }
  size_t components() const { return components_; }  ///< 1 to 4; 16 of a matrix
  /// Whole numbers that are not normalised.
  bool is_whole() const { return component_ != Component::float32 && !normalized_; }
  bool is_float() const { return component_ == Component::float32; }
  bool is_normalized() const { return normalized_; }
  /// Rows [first, last) as floats, `width` each: further components are left out, missing ones
  /// are 1. Normalised integers become shares. Floats may be anything, NaN too.
  std::vector<float> floats(size_t first, size_t last, size_t width) const;
  /// All rows' first components; the largest number for one below 0. Throws where they are no
  /// indices.
  std::vector<uint32_t> indices() const;

  GltfValue place() const { return value_; }

  enum class Component : uint8_t { int8, uint8, int16, uint16, uint32, float32 };
  /// What a row of an accessor is.
  struct Form {
    Component component = Component::float32;
    size_t components = 1;
    size_t size() const { return size_of(component); }  ///< of a component, in bytes
  };
  /// Throws where the accessor does not tell.
  static Form form_of(const GltfValue& accessor);

 private:
  /// Throws where it leaves its data.
  GltfAccessor(GltfFile& file, size_t index);

  struct Rows {
    const char* data = nullptr;  ///< null: zeros
    size_t stride = 0;
  };
  struct Sparse {
    std::vector<uint32_t> rows;  ///< increasing
    Rows values;
  };

  static Component component_of(const GltfValue& type);
  static size_t size_of(Component component);
  static Rows rows(GltfFile& file, const GltfValue& holder, size_t count, size_t components,
                   Component type);
  void read_sparse(GltfFile& file, const GltfValue& sparse);
  const char* row(size_t index) const;
  double value(const char* row, size_t component) const;

  GltfValue value_;
  Component component_ = Component::float32;
  size_t components_ = 1, count_ = 0;
  bool normalized_ = false;
  Rows rows_;
  Sparse sparse_;
};

}  // namespace tessera
