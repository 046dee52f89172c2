// The rules about which room may include which, checked against include lines.
#pragma once

#include <filesystem>
#include <map>
#include <string>
#include <vector>

namespace keypose::tests {

/// A room or sub-room with its own target, as declared in its CMakeLists.txt.
struct Room {
  std::string folder;                ///< from the project's root: "register/nricp"
  bool touches_files = false;        ///< declared with FILES
  std::vector<std::string> targets;  ///< targets of the rooms that it links
};

/// All rooms, by target name.
using Rooms = std::map<std::string, Room>;

/// Reads rooms.txt, which CMake writes into the build folder. Each line has the target, the folder,
/// "files" or "values", and the targets of linked rooms.
Rooms ParseRooms(const std::string& text);

/// A violation of a rule.
struct Breach {
  std::string place;   ///< "file:line", a room's folder, or a unit
  std::string reason;  ///< for the message
};

/// The violations in the include lines of one file.
///
/// @param file  path from the project's root, with '/', for example "register/nricp/nricp.cpp"
/// @param text  its contents
///
/// Rules. A stage room -> itself, the library rooms (views, deform), core, core/stage. Within a
/// room, a sub-room -> the targets that its CMakeLists.txt links; its tests also the indirectly
/// linked ones. Only programs (*_stage.cpp and main.cpp), tests, sub-rooms declared with FILES and
/// *_colmap.{h,cpp} -> core/io. core/io, core/stage -> core, by their links; core's tests -> all of
/// core. synth, pipeline -> core, core/io. studio -> core, core/io, pipeline, and its own
/// sub-rooms as linked. tests, bench -> anything. Headers
/// -> the project's own, Eigen and the standard library; those in folders `testing` also
/// GoogleTest. CGAL, PCL, Ceres, TetGen, OpenCV and Embree only in .cpp.
std::vector<Breach> IncludeBreaches(const Rooms& rooms, const std::string& file,
                                    const std::string& text);

/// Rooms that reach themselves through their links, links to rooms that do not exist, and links
/// from one stage room to another.
std::vector<Breach> LinkBreaches(const Rooms& rooms);

/// Units that reach themselves through include lines. A unit is foo.h, foo.cpp, foo.inc and
/// foo_impl.h.
/// @param texts  contents of all files, by path from the project's root
std::vector<Breach> UnitCycles(const std::map<std::string, std::string>& texts);

/// All .h, .cpp and .inc files of the project below `root`, sorted. Skips build folders and
/// node_modules.
std::vector<std::string> SourceFiles(const std::filesystem::path& root);

}  // namespace keypose::tests
