#include "base/program_folder.h"

#include <string>

#include "base/process.h"
#include "base/version.h"
#include "front/render_options.h"
#include "job/job.h"
#include "python/bindings.h"

namespace tessera {

namespace py = pybind11;

void bind_program(py::module_& module) {
  module.attr("version") = kVersion;
  module.attr("build") = kBuild;
  module.attr("installed_folder") = TESSERA_PROGRAM_FOLDER;
  module.attr("most_threads") = kMaxThreads;
  module.attr("most_priority") = kMostPriority;
  module.def("core_count", &core_count, "How many threads can run at once here.");
  module.def(
      "set_program", [](const std::string& path) { set_program(path); }, py::arg("path"),
      "Names the program of worker processes, by its path as bytes.");
}

}  // namespace tessera
