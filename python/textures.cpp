#include <pybind11/stl.h>

#include <string>
#include <tuple>
#include <utility>

#include "base/error.h"
#include "front/texture_decoder.h"
#include "python/array.h"
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
std::tuple<Array, bool, std::string> read_texture(const std::string& path,
                                                  const std::string& encoding) {
  const auto [decoded, warning] =
      run_abandonably([path, encoding = encoding_of(encoding)](const std::atomic<bool>&) {
        DecodedTexture read = decode_texture(path, false);
        std::string told = mend_numbers(read);
        decode_picture(read, encoding);
        return std::pair(std::move(read), std::move(told));
      });
  return {array_of(decoded), decoded.meaning.is_associated,
          warning.empty() ? "" : path + ": " + warning};
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

/// Light of floats that are codes in sRGB; uint8 are returned as they are.
Array light_of_texels(const Array& texels, bool is_associated) {
  const auto axes = texels.shape().size();
  if (texels.type().size == 1 || (axes != 2 && axes != 3)) return texels;
  const DecodedTexture light = run_abandonably([texels, is_associated](const std::atomic<bool>&) {
    DecodedTexture texture = texture_of(texels, is_associated);
    decode_picture(texture, SampleEncoding::srgb);
    return texture;
  });
  return Array(light.texels, light.texels->data(), texel_type(light.bits), texels.shape());
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
  module.def("light_of_texels", &light_of_texels, "Light of floats that are codes in sRGB.");
  module.def("srgb_to_linear", &srgb_to_linear, "A channel of sRGB from 0 to 1 as linear light.");
  module.def("with_mip_levels", &with_mip_levels, "Texels with all smaller levels behind them.");
}

}  // namespace tessera
