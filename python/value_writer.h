#pragma once

#include <google/protobuf/message.h>
#include <pybind11/pybind11.h>

#include "proto/wire/blob_store.h"

namespace tessera {

/// The Python value of a message; blobs become arrays that share their memory. Throws scene_error
/// where a blob is missing or too short. Needs the GIL.
pybind11::object write_value(const google::protobuf::Message& message, const BlobStore& blobs);

}  // namespace tessera
