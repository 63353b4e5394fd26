#include <google/protobuf/descriptor.pb.h>

#include <cstdio>
#include <fstream>

#include "python/generate/python_class.h"

namespace {

constexpr const char* kHead =
    R"("""The messages of a scene as classes. Generated from scene.proto: do not edit."""
from __future__ import annotations

from typing import (TYPE_CHECKING, Dict, Iterable, List, Literal, Mapping, NoReturn, Optional, Tuple,
                    Union)

from ._arguments import several
from ._callers import here
from ._types import Accelerator, ArrayLike, ColorLike, Integrator, VectorLike
from ._value import Value, refuse_keywords
from ._value_types import ColorInputLike, FloatInputLike, NodeLike, TextureLike

if TYPE_CHECKING:
    from . import _placing, _transforms, _view

)";

}  // namespace

/// generate_messages DESCRIPTORS OUTPUT: writes the Python classes of the messages in the first
/// file of DESCRIPTORS, which `protoc --include_source_info --descriptor_set_out` wrote.
int main(int count, char** arguments) {
  if (count != 3) return 2;
  std::ifstream input(arguments[1], std::ios::binary);
  google::protobuf::FileDescriptorSet files;
  if (!files.ParseFromIstream(&input) || files.file_size() != 1) {
    std::fprintf(stderr, "%s: no descriptor of one file\n", arguments[1]);
    return 1;
  }
  google::protobuf::DescriptorPool pool;
  const google::protobuf::FileDescriptor* file = pool.BuildFile(files.file(0));
  if (!file) return 1;
  for (int i = 0; i < file->message_type_count(); ++i) {
    std::string fault = tessera::unknown_field(*file->message_type(i));
    if (fault.empty()) fault = tessera::untold_field(*file->message_type(i));
    if (fault.empty()) continue;
    std::fprintf(stderr, "%s\n", fault.c_str());
    return 1;
  }
  std::string text = kHead + tessera::enumerations(*file);
  const std::vector<tessera::PythonClass> classes = tessera::python_classes(*file);
  for (const tessera::PythonClass& made : classes) text += tessera::to_python(made);
  text += "\n\n__all__ = [\n";
  for (const tessera::PythonClass& made : classes) text += "    \"" + made.name + "\",\n";
  text += "]\n";
  std::ofstream output(arguments[2], std::ios::binary);
  output << text;
  return output.flush() ? 0 : 1;
}
