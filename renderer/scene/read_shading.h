#pragma once

#include <span>
#include <string>

#include "proto/tessera/v1/scene.pb.h"
#include "renderer/math/transform.h"
#include "renderer/scene/check.h"
#include "renderer/scene/texture_table.h"
#include "renderer/shading/background.h"
#include "renderer/shading/light.h"
#include "renderer/shading/material.h"
#include "renderer/shading/material_inputs.h"

namespace tessera {

// From messages to what shading uses. Each checks every number that it reads against the ranges in
// scene.proto and throws a scene error that begins with `where`.

/// All but `back` and the number of `inputs`, which the caller resolves.
Material read_material(const Where& where, const v1::Material& material, TextureTable& textures,
                       MaterialInputs& inputs);

/// `world_from_light` must be invertible.
Light read_light(const Where& where, const v1::Light& light, const Affine& world_from_light);

Background read_background(const v1::Background& background, TextureTable& textures);

Fog read_fog(const v1::Fog& fog);

}  // namespace tessera
