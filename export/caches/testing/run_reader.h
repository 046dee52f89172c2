// Runs other programs on the files that a test wrote.
#pragma once

#include <string>
#include <vector>

namespace keypose::exporting {

struct ReaderResult {
  int exit_code = -1;
  std::string output;  ///< standard output and error together
};

/// Runs a program of PATH with these words, for at most `seconds`.
ReaderResult RunReader(const std::vector<std::string>& words, int seconds = 240);

/// Whether PATH has this program.
bool HasReader(const std::string& program);

/// The number behind `name=` in a program's output.
/// @throws std::runtime_error  there is none; gives the output
double FigureOf(const std::string& output, const std::string& name);

}  // namespace keypose::exporting
