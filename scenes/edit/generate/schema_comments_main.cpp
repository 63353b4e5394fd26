#include <google/protobuf/descriptor.h>
#include <google/protobuf/descriptor.pb.h>

#include <cstdio>
#include <fstream>
#include <map>
#include <string>

namespace {

namespace pb = google::protobuf;

/// The comments before and behind it, as one paragraph.
template <class D>
std::string comment_of(const D& described) {
  pb::SourceLocation place;
  if (!described.GetSourceLocation(&place)) return "";
  std::string words;
  for (const std::string& part : {place.leading_comments, place.trailing_comments}) {
    if (part.find("-----") != std::string::npos) continue;  // the heading of a section
    for (const char c : part + " ") {
      const bool is_blank = c == ' ' || c == '\n' || c == '\t';
      if (!is_blank) {
        words += c;
      } else if (!words.empty() && words.back() != ' ') {
        words += ' ';
      }
    }
  }
  if (!words.empty() && words.back() == ' ') words.pop_back();
  return words;
}

using Comments = std::map<std::string, std::string>;

void add(const pb::EnumDescriptor& type, Comments& comments) {
  for (int i = 0; i < type.value_count(); ++i)
    comments[type.full_name() + "." + type.value(i)->name()] = comment_of(*type.value(i));
}

void add(const pb::Descriptor& type, Comments& comments) {
  comments[type.full_name()] = comment_of(type);
  for (int i = 0; i < type.field_count(); ++i)
    comments[type.field(i)->full_name()] = comment_of(*type.field(i));
  for (int i = 0; i < type.nested_type_count(); ++i) add(*type.nested_type(i), comments);
  for (int i = 0; i < type.enum_type_count(); ++i) add(*type.enum_type(i), comments);
}

}  // namespace

/// schema_comments DESCRIPTORS OUTPUT: writes the comments of the messages in DESCRIPTORS, which
/// `protoc --include_source_info --descriptor_set_out` wrote, as the lines of a C++ table.
int main(int count, char** arguments) {
  if (count != 3) return 2;
  std::ifstream input(arguments[1], std::ios::binary);
  pb::FileDescriptorSet files;
  if (!files.ParseFromIstream(&input) || files.file_size() != 1) {
    std::fprintf(stderr, "%s: no descriptor of one file\n", arguments[1]);
    return 1;
  }
  pb::DescriptorPool pool;
  const pb::FileDescriptor* file = pool.BuildFile(files.file(0));
  if (!file) return 1;
  Comments comments;
  for (int i = 0; i < file->message_type_count(); ++i) add(*file->message_type(i), comments);
  std::ofstream output(arguments[2], std::ios::binary);
  for (const auto& [name, words] : comments)
    if (!words.empty()) output << "{\"" << name << "\", R\"~(" << words << ")~\"},\n";
  return output.flush() ? 0 : 1;
}
