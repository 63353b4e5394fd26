#pragma once

#include <google/protobuf/repeated_ptr_field.h>

#include "proto/tessera/v1/scene.pb.h"
#include "renderer/math/transform.h"
#include "renderer/scene/check.h"

namespace tessera {

/// The product of the steps. May be singular, but its numbers are finite.
Affine read_transform(const Where& where, const v1::Transform& transform);

/// The transform at `time`: of `keys`, if there are any, else of `transform`. All keys
/// are checked: they must increase in time and have the same kinds of steps.
Affine read_transform(const Where& where, const v1::Transform& transform,
                      const google::protobuf::RepeatedPtrField<v1::TransformKey>& keys,
                      double time);

}  // namespace tessera
