#pragma once

#include "scenes/formats/crt/crt_value.h"

namespace tessera {

/// The operators but && and ||. Integers wrap at 32 bits and divide towards zero, as in Java; where
/// an integer meets a float it becomes one. Vectors and colours add, subtract, and are multiplied
/// and divided by numbers; + - ^ on entities make union, difference and intersection. Throw
/// CrtError at `where` for operands that do not go together, CrtLimitError for results that are too
/// large.
CrtValue apply_unary(CrtToken token, const CrtValue& operand, CrtSpan where);
CrtValue apply_binary(CrtToken token, const CrtValue& left, const CrtValue& right, CrtHeap& heap,
                      CrtSpan where);

/// Of two entities.
const CrtEntity* set_operation(v1::Csg::Operation operation, const CrtEntity& left,
                               const CrtEntity& right, CrtHeap& heap, CrtSpan where);

}  // namespace tessera
