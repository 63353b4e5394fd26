#pragma once

#include <filesystem>
#include <string>

namespace tessera {

/// The program that worker processes run. It is the one that this process runs, unless
/// set_program() named another.
std::string program_path();

/// The folder of that program. Its image codec and its modules are in it too.
std::filesystem::path program_folder();

/// Names the program, for a process that runs another one, such as Python. Call it before threads
/// start.
void set_program(const std::filesystem::path& program);

}  // namespace tessera
