#include "base/program_folder.h"

#include <string>

#include "base/version.h"
#include "python/bindings.h"

namespace tessera {

namespace py = pybind11;

void bind_program(py::module_& module) {
  module.attr("version") = kVersion;
  module.attr("build") = kBuild;
  module.attr("installed_folder") = TESSERA_PROGRAM_FOLDER;
  module.def(
      "set_program", [](const std::string& path) { set_program(path); }, py::arg("path"),
      "Names the program of worker processes, by its path as bytes.");
}

}  // namespace tessera
