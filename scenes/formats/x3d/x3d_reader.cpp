#include "scenes/formats/x3d/x3d_reader.h"
#include "base/error.h"
namespace tessera {
LoadedScene read_x3d(const std::string& path, const ReadOptions&) { throw scene_error({path},"x3d","later"); }
}
