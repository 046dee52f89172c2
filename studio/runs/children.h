// Programs that the studio starts: found beside it, stopped with it.
#pragma once

#include <filesystem>
#include <string>
#include <vector>

namespace keypose::studio {

/// The folder of the studio's own program, where all others of Keypose are.
std::filesystem::path OwnFolder();

struct ChildResult {
  int exit_code = 0;
  std::string output;  ///< standard output and error, at most the last 64 kB
};

/// Runs a program to its end and returns what it said.
/// @param seconds  after this long it is stopped (exit code 124)
ChildResult RunChild(const std::vector<std::string>& arguments, const std::filesystem::path& folder,
                     double seconds);

/// Starts a program that goes on by itself; its standard output and error go to files.
/// @return its process id @throws DiskError  it cannot be started
int StartChild(const std::vector<std::string>& arguments, const std::filesystem::path& folder,
               const std::filesystem::path& output, const std::filesystem::path& error);

}  // namespace keypose::studio
