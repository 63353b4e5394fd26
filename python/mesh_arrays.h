#pragma once

#include <pybind11/pybind11.h>

#include <string>
#include <utility>

#include "base/blob.h"
#include "base/digest.h"
#include "python/array.h"
#include "python/array_source.h"

namespace tessera {

/// What Python gave for an array of a scene (TriangleMesh.positions, Image.texels ...), as the blob
/// of that field has it; converted where it has to be. Needs the GIL.
///
/// `copy`: None to share read-only memory of the right type, False to refuse a copy, True to make
/// one always. `vertices`: how many there are, -1 where that is not known; then each index is held
/// against 2^32 alone.
pybind11::object take_blob_array(pybind11::handle given, const std::string& field,
                                 pybind11::handle copy = pybind11::none(),
                                 pybind11::ssize_t vertices = -1);

/// Throws ValueError for texels of a picture that is larger than any.
void check_texel_sides(const ArraySource& source);

/// The blob of an array and its name, which is worked out once. Needs the GIL, which it lets go of.
std::pair<Digest, BlobData> blob_of(const Array& array);

/// The array of a field's blob, for handing out.
Array array_of_blob(BlobData blob, ElementType type, Array::Shape shape);

/// The type of texels of so many bits.
ElementType texel_type(uint32_t bits);

/// The type of that field's elements, and how many there are in a row (0: one, without an axis).
std::pair<ElementType, pybind11::ssize_t> blob_layout(const std::string& field);

}  // namespace tessera
