// Who may include whom: the house's plan, checked against include lines.
#pragma once

#include <filesystem>
#include <string>
#include <vector>

namespace keypose::tests {

/// One include line that breaks a rule.
struct Breach {
  std::string place;  ///< "file:line"
  std::string reason;
};

/// What is wrong with the include lines of one file.
///
/// @param file  path from the project's root, with '/', for example "register/nricp.cpp"
/// @param text  its contents
/// Rules: a stage room -> itself, core, core/stage; core/io only in *_stage.cpp, main.cpp, *_test.cpp and *_colmap.{h,cpp}. core/stage,
/// core/io -> core (and core/stage -> core/io/files.h, which knows no format). synth -> core, core/io. pipeline -> core, core/io. core ->
/// core. tests, bench -> anything. Headers -> the project's own, Eigen and the standard library. CGAL, PCL, Ceres, TetGen, OpenCV and
/// Embree only in .cpp.
std::vector<Breach> IncludeBreaches(const std::string& file, const std::string& text);

/// All of the project's .h and .cpp below `root`, sorted; build folders and node_modules are not entered.
std::vector<std::string> SourceFiles(const std::filesystem::path& root);

}  // namespace keypose::tests
