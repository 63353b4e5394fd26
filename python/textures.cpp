#include <pybind11/stl.h>

#include <string>
#include <tuple>
#include <utility>

#include "base/error.h"
#include "front/texture_decoder.h"
#include "python/array.h"
#include "python/array_source.h"
#include "python/bindings.h"
#include "python/interruptible.h"
#include "python/mesh_arrays.h"
#include "renderer/math/encodings.h"
#include "scenes/import/mip_levels.h"
#include "scenes/import/picture_light.h"

namespace py = pybind11;

namespace tessera {
namespace {

/// (h, w, c) uint8, half or float.
Array array_of(const DecodedTexture& texture) {
  return Array(texture.texels, texture.texels->data(), texel_type(texture.bits),
               {texture.height, texture.width, texture.channels});
}

SampleEncoding encoding_of(const std::string& name) {
  return name == "srgb"     ? SampleEncoding::srgb
         : name == "linear" ? SampleEncoding::linear
                            : SampleEncoding::automatic;
}

/// The picture in a file, whose uint8 are as the file has them and whose floats are light, whether
/// its colours are multiplied by alpha, and what to warn of. `encoding`: as ImageTexture has it;
/// empty: none.
std::tuple<Array, bool, std::vector<std::string>> read_texture(const std::string& path,
                                                               const std::string& encoding) {
  auto [decoded, notes] =
      run_abandonably([path, encoding = encoding_of(encoding)](const std::atomic<bool>&) {
        DecodedTexture read = decode_texture(path, false);
        std::vector<PictureNote> told = prepare_picture(read, encoding);
        return std::pair(std::move(read), std::move(told));
      });
  std::vector<std::string> warnings;
  for (const PictureNote& note : notes) warnings.push_back(path + ": " + note.what);
  return {array_of(decoded), decoded.meaning.is_associated, std::move(warnings)};
}

/// Texels (h, w) or (h, w, c).
DecodedTexture texture_of(const Array& texels, bool is_associated) {
  const Array::Shape& shape = texels.shape();
  const auto side = [&](size_t axis) { return static_cast<uint32_t>(shape[axis]); };
  DecodedTexture texture{.width = side(1),
                         .height = side(0),
                         .channels = shape.size() == 3 ? side(2) : 1,
                         .bits = static_cast<uint32_t>(8 * texels.type().size),
                         .texels = copy_to_blob(texels.bytes())};
  texture.meaning.is_associated = is_associated;
  return texture;
}

/// Codes of 16 bits as floats, from 0 to 1; anything else as it is.
py::object without_codes16(py::handle given) {
  const ArraySource source = array_source(given, "texels");
  if (source.kind != 'u' || source.item_size != 2) return py::reinterpret_borrow<py::object>(given);
  check_texel_sides(source);
  return py::cast(Array(run_unlocked(bytes_worked_on(source),
                                     [source](const std::atomic<bool>& stop) {
                                       std::vector<float> floats;
                                       floats.reserve(static_cast<size_t>(source.count()));
                                       for_each_element<float>(source, stop, [&](float code) {
                                         floats.push_back(code / 65535);
                                       });
                                       return floats;
                                     }),
                        source.shape));
}

/// The texels of an array: uint8 as they are, else light. `encoding`: as ImageTexture has it;
/// empty: none.
py::object take_texels(py::handle given, const std::string& encoding, bool is_associated) {
  const py::object plain = without_codes16(given);
  const py::object taken = take_blob_array(plain, "texels");
  const auto& texels = taken.cast<const Array&>();
  const bool from_integers = plain.ptr() != given.ptr();
  const bool is_light = !from_integers && encoding != "srgb";
  const auto axes = texels.shape().size();
  if (texels.type().size == 1 || is_light || (axes != 2 && axes != 3)) return taken;
  const DecodedTexture light =
      run_abandonably([texels, from_integers, is_associated,
                       encoding = encoding_of(encoding)](const std::atomic<bool>&) {
        DecodedTexture texture = texture_of(texels, is_associated);
        texture.meaning.from_integers = from_integers;
        decode_picture(texture, encoding);
        return texture;
      });
  return py::cast(
      Array(light.texels, light.texels->data(), texel_type(light.bits), texels.shape()));
}

/// The texels (h, w) or (h, w, c) followed by all smaller levels, in a row, and how many there are.
std::pair<Array, uint32_t> with_mip_levels(const Array& texels, bool is_srgb, bool is_associated) {
  const auto [all, levels] =
      run_abandonably([texels, is_srgb, is_associated](const std::atomic<bool>&) {
        DecodedTexture made = texture_of(texels, is_associated);
        const uint32_t count = add_mip_levels(made, is_srgb);
        return std::pair(made.texels, count);
      });
  const auto size = static_cast<py::ssize_t>(all->size()) / texels.type().size;
  return {Array(all, all->data(), texels.type(), {size}), levels};
}

}  // namespace

void bind_textures(py::module_& module) {
  module.def("read_texture", &read_texture, "The picture in a file as an array.");
  module.def("take_texels", &take_texels, "The texels of an array, as a texture has them.");
  module.def("srgb_to_linear", &srgb_to_linear, "A channel of sRGB from 0 to 1 as linear light.");
  module.def("with_mip_levels", &with_mip_levels, "Texels with all smaller levels behind them.");
}

}  // namespace tessera
