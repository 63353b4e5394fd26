#pragma once

#include "proto/tessera/v1/scene.pb.h"
#include "proto/wire/blob_store.h"

namespace tessera {

/// Builds the scene with each accelerator and renders a frame of 5 x 5 pixels with one sample each
/// by the whitted and by the path integrator. Aborts unless every value is finite and every
/// accelerator gives the same bits, or refuses the scene with an Error as the others do. A scene
/// without a camera is seen from one that frames all of it and carries a light. Scenes that would
/// take long are left alone: see kMostNodes and the like in the source. `with_embree`: Embree too,
/// where its module is beside the program; it takes longer to start than all others to build.
void render_fuzzed(v1::Scene scene, BlobStore blobs, bool with_embree = false);

}  // namespace tessera
