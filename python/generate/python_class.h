#pragma once

#include <google/protobuf/descriptor.h>

#include <string>
#include <vector>

namespace tessera {

/// A field of a Python class: one of a message, or one that only Python has.
struct PythonField {
  std::string name;
  std::string type;  ///< the annotation, without Optional
  std::string doc;
  bool is_list = false;
  bool is_map = false;
};

/// A class of the generated file.
struct PythonClass {
  std::string name;
  std::string base;
  std::string doc;
  std::string message;              ///< the full name of the message that it becomes
  std::string kind;                 ///< the field of that message's `oneof kind`, if one
  std::vector<PythonField> own;     ///< positional arguments of the constructor
  std::vector<PythonField> common;  ///< keywords: of the base class
};

/// Whether the kinds of this message are subclasses of its class: it has `oneof kind` beside other
/// fields, such as Shape, Light, Material and Texture.
bool is_union(const google::protobuf::Descriptor& message);

/// The first field of a message, or of one inside it, that python/value_reader.h and value_writer.h
/// do not know, with what it is; empty: there is none.
std::string unknown_field(const google::protobuf::Descriptor& message);

/// The first field whose comment does not tell what `help` is to: what it is and, where it is not
/// 0, False or empty, its default; with what is missing; empty: there is none.
std::string untold_field(const google::protobuf::Descriptor& message);

/// The classes of all messages of a file, bases before what derives from them.
std::vector<PythonClass> python_classes(const google::protobuf::FileDescriptor& file);

/// The types of all enumerations of a file, as lines of source text: `FogKind = Literal[...]`.
std::string enumerations(const google::protobuf::FileDescriptor& file);

/// The source text of a class.
std::string to_python(const PythonClass& made);

}  // namespace tessera
