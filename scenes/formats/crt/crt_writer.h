#pragma once

#include "proto/tessera/v1/scene.pb.h"
#include "scenes/formats/crt/crt_program.h"
#include "scenes/import/origin_table.h"

namespace tessera {

/// The scene that a program asks for. Files are named as the script names them, without a leading
/// slash. Nodes and includes are given numbers of `origins`, in the script `name`, where the
/// program knows where they were made.
v1::Scene write_crt_scene(const CrtProgram& program, OriginTable& origins, const std::string& name);

/// "/images/sky.jpg" is meant from the script's folder: the original looks it up in its class path.
std::string crt_file_reference(const std::string& written);

}  // namespace tessera
