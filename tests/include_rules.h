// Who may include whom: the house's plan, checked against include lines.
#pragma once

#include <filesystem>
#include <map>
#include <string>
#include <vector>

namespace keypose::tests {

/// A room or sub-room with a target of its own, as its CMakeLists.txt declares it.
struct Room {
  std::string folder;                ///< from the project's root: "register/nricp"
  bool touches_files = false;        ///< declared with FILES
  std::vector<std::string> targets;  ///< rooms that it links, by their targets' names
};

/// All rooms, by their targets' names.
using Rooms = std::map<std::string, Room>;

/// Reads rooms.txt, which CMake writes into the build folder: target, folder, "files" or "values",
/// and the linked rooms' targets on each line.
Rooms ParseRooms(const std::string& text);

/// One thing that breaks a rule.
struct Breach {
  std::string place;   ///< "file:line", a room's folder, or a unit
  std::string reason;  ///< for a person
};

/// What is wrong with the include lines of one file.
///
/// @param file  path from the project's root, with '/', for example "register/nricp/nricp.cpp"
/// @param text  its contents
///
/// Rules. A stage room -> itself, the library rooms (views, deform), core, core/stage. Within a
/// room, a sub-room -> what its CMakeLists.txt links; its tests also what those link in turn. Only
/// programs
/// (*_stage.cpp and main.cpp), tests, sub-rooms declared with FILES and *_colmap.{h,cpp} ->
/// core/io. core/stage, core/io -> core (and core/stage -> core/io/files.h, which knows no format).
/// synth, pipeline -> core, core/io. tests, bench -> anything. Headers -> the project's own, Eigen
/// and the standard library. CGAL, PCL, Ceres, TetGen, OpenCV and Embree only in .cpp.
std::vector<Breach> IncludeBreaches(const Rooms& rooms, const std::string& file,
                                    const std::string& text);

/// Rooms that reach themselves through their links, links to rooms that are not there, and links of
/// a stage room to another's.
std::vector<Breach> LinkBreaches(const Rooms& rooms);

/// Units that reach themselves through include lines. A unit is foo.h, foo.cpp, foo.inc and
/// foo_impl.h.
/// @param texts  contents of all files, by path from the project's root
std::vector<Breach> UnitCycles(const std::map<std::string, std::string>& texts);

/// All of the project's .h, .cpp and .inc below `root`, sorted; build folders and node_modules are
/// not entered.
std::vector<std::string> SourceFiles(const std::filesystem::path& root);

}  // namespace keypose::tests
