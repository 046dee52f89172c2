#include "tests/include_rules.h"

#include <algorithm>
#include <functional>
#include <regex>
#include <set>
#include <sstream>

namespace keypose::tests {
namespace {

namespace fs = std::filesystem;

const std::set<std::string> kStageRooms{"capture",     "reconstruct", "cleanup", "texture",
                                        "register",    "fit",         "motion",  "armature",
                                        "interpolate", "composite",   "export",  "report"};
const std::set<std::string> kLibraryRooms{"views", "deform"};
const std::vector<std::string> kHeavy{"CGAL/", "pcl/", "ceres/", "tetgen", "opencv2/", "embree"};

bool StartsWithAny(const std::string& text, const std::vector<std::string>& starts) {
  return std::any_of(starts.begin(), starts.end(),
                     [&](const auto& start) { return text.starts_with(start); });
}

// "register/nricp/nricp.h" -> "register/nricp"
std::string FolderOf(const std::string& path) {
  const auto slash = path.rfind('/');
  return slash == std::string::npos ? "" : path.substr(0, slash);
}

// "core/io/text/files.h" -> "core/io", "register/nricp/nricp.h" -> "register"
std::string TopRoomOf(const std::string& path) {
  if (path.starts_with("core/io/")) return "core/io";
  if (path.starts_with("core/stage/")) return "core/stage";
  const auto slash = path.find('/');
  return slash == std::string::npos ? "" : path.substr(0, slash);
}

bool IsTest(const std::string& file) {
  static const std::regex pattern(".*(_test|_bench)\\.cpp|.*/testing/.*");
  return std::regex_match(file, pattern);
}

// A program: a file in a room's root folder that has the program's main, or that only the programs
// there share.
bool IsProgram(const std::string& file) {
  static const std::regex pattern(".*(_stage|/main|_main)\\.cpp");
  return std::regex_match(file, pattern);
}

const std::string* TargetOf(const Rooms& rooms, const std::string& folder) {
  for (const auto& [target, room] : rooms)
    if (room.folder == folder) return &target;
  return nullptr;
}

// A room's root folder without its own target contains its programs and the files that they share.
bool MayTouchFiles(const Rooms& rooms, const std::string& file) {
  static const std::regex adapter(".*_colmap\\.(cpp|h)");
  if (IsProgram(file) || IsTest(file) || std::regex_match(file, adapter)) return true;
  const std::string* target = TargetOf(rooms, FolderOf(file));
  return !target || rooms.at(*target).touches_files;
}

// All targets that a room links, directly or indirectly.
std::set<std::string> Below(const Rooms& rooms, const std::string& target) {
  std::set<std::string> below;
  const std::function<void(const std::string&)> visit = [&](const std::string& name) {
    const auto room = rooms.find(name);
    if (room == rooms.end()) return;
    for (const std::string& link : room->second.targets)
      if (below.insert(link).second) visit(link);
  };
  visit(target);
  return below;
}

// Between folders of stage and library rooms: linked targets may be included.
std::string ArrowReason(const Rooms& rooms, const std::string& file, const std::string& included) {
  const std::string from = FolderOf(file), to = FolderOf(included);
  if (to == from || to.ends_with("/testing")) return "";
  const std::string* source = TargetOf(rooms, from);
  const std::string* target = TargetOf(rooms, to);
  if (!source || IsProgram(file)) return "";
  const std::string plan = from + "/CMakeLists.txt";
  if (!target) return from + " may not include " + to + ", which is no room of its own";
  const auto& links = rooms.at(*source).targets;
  if (std::find(links.begin(), links.end(), *target) != links.end()) return "";
  if (IsTest(file) && Below(rooms, *source).count(*target)) return "";
  return from + " may not include " + to + ": " + plan + " does not link " + *target;
}

std::string FilesReason(const Rooms& rooms, const std::string& file) {
  if (MayTouchFiles(rooms, file)) return "";
  return "an algorithm does not touch files: core/io belongs in *_stage.cpp, main.cpp, tests and "
         "sub-rooms declared with FILES";
}

std::string ProjectReason(const Rooms& rooms, const std::string& file,
                          const std::string& included) {
  const std::string from = TopRoomOf(file), to = TopRoomOf(included);
  // These are compiled by a microcontroller's tools as well, which know no root.
  if (to.empty() && file.starts_with("armature/firmware/")) return "";
  if (to.empty()) return "\"" + included + "\" is not given from the project's root";
  if (from == "tests" || from == "bench") return "";
  const bool in_house = kStageRooms.count(from) || kLibraryRooms.count(from);
  // core's tests read and write what they test.
  if (IsTest(file) && from.starts_with("core") && to.starts_with("core")) return "";
  if (to == from) return ArrowReason(rooms, file, included);
  if (in_house) {
    if (to == "core" || to == "core/stage") return "";
    if (to == "core/io") return FilesReason(rooms, file);
    if (kLibraryRooms.count(to)) return ArrowReason(rooms, file, included);
    if (kStageRooms.count(to))
      return from + " may not include " + to +
             ": what two stage rooms need moves to core or a library room";
    return from + " may not include " + to;
  }
  const bool of_core = from.starts_with("core") && to.starts_with("core");
  if (of_core) return ArrowReason(rooms, file, included);
  if (to == "core") return "";
  const bool reads_files = from == "synth" || from == "pipeline" || from == "studio";
  if (to == "core/io" && reads_files) return "";
  if (to == "pipeline" && from == "studio") return "";
  // The page shows films, which need a decoder.
  if (kLibraryRooms.count(to) && from == "studio") return ArrowReason(rooms, file, included);
  return from + " may not include " + to;
}

std::string SystemReason(const std::string& file, const std::string& included) {
  if (!file.ends_with(".h") || IsTest(file)) return "";
  if (StartsWithAny(included, kHeavy)) return "<" + included + "> stays inside .cpp files";
  const bool standard =
      included.find('/') == std::string::npos && included.find('.') == std::string::npos;
  const std::string room = TopRoomOf(file);
  const bool narrow = (room == "core" || room == "core/io") && !IsTest(file);
  if (narrow && !standard && !included.starts_with("Eigen/"))
    return "headers of core include only Eigen and the standard library, not <" + included + ">";
  return "";
}

struct Include {
  int line = 0;
  bool ours = false;  // an include in quotes
  std::string path;
};

std::vector<Include> IncludesOf(const std::string& text) {
  static const std::regex pattern("^\\s*#\\s*include\\s*([<\"])([^>\"]+)[>\"].*");
  std::vector<Include> includes;
  std::istringstream lines(text);
  int number = 0;
  for (std::string line; std::getline(lines, line);) {
    ++number;
    std::smatch match;
    if (std::regex_match(line, match, pattern))
      includes.push_back({number, match[1] == "\"", match[2]});
  }
  return includes;
}

// "deform/poisson/poisson_impl.h" -> "deform/poisson/poisson"
std::string UnitOf(const std::string& path) {
  static const std::regex ending("(_impl)?\\.(h|cpp|inc)$");
  return std::regex_replace(path, ending, "");
}

using Arrows = std::map<std::string, std::set<std::string>>;

// Every node that reaches itself, with the cycle as text.
std::vector<Breach> Circles(const Arrows& arrows, const std::string& verb) {
  std::vector<Breach> breaches;
  for (const auto& [start, unused] : arrows) {
    std::map<std::string, std::string> came_from;
    std::vector<std::string> open{start};
    while (!open.empty() && !came_from.count(start)) {
      const std::string node = open.back();
      open.pop_back();
      const auto next = arrows.find(node);
      if (next == arrows.end()) continue;
      for (const std::string& to : next->second)
        if (came_from.emplace(to, node).second) open.push_back(to);
    }
    if (!came_from.count(start)) continue;
    std::string way = start;
    for (std::string node = came_from[start]; node != start; node = came_from[node])
      way = node + verb + way;
    breaches.push_back({start, "reaches itself: " + start + verb + way});
  }
  return breaches;
}

}  // namespace

Rooms ParseRooms(const std::string& text) {
  Rooms rooms;
  std::istringstream lines(text);
  for (std::string line; std::getline(lines, line);) {
    std::istringstream words(line);
    std::string target, kind;
    Room room;
    if (!(words >> target >> room.folder >> kind)) continue;
    room.touches_files = kind == "files";
    for (std::string link; words >> link;) room.targets.push_back(link);
    rooms[target] = room;
  }
  return rooms;
}

std::vector<Breach> IncludeBreaches(const Rooms& rooms, const std::string& file,
                                    const std::string& text) {
  std::vector<Breach> breaches;
  for (const Include& include : IncludesOf(text)) {
    const std::string reason =
        include.ours ? ProjectReason(rooms, file, include.path) : SystemReason(file, include.path);
    if (!reason.empty()) breaches.push_back({file + ":" + std::to_string(include.line), reason});
  }
  return breaches;
}

std::vector<Breach> LinkBreaches(const Rooms& rooms) {
  std::vector<Breach> breaches;
  Arrows arrows;
  for (const auto& [target, room] : rooms) {
    const std::string from = TopRoomOf(room.folder + "/");
    for (const std::string& link : room.targets) {
      arrows[target].insert(link);
      const auto other = rooms.find(link);
      if (other == rooms.end()) {
        breaches.push_back({room.folder, "links " + link + ", which is no room"});
        continue;
      }
      const std::string to = TopRoomOf(other->second.folder + "/");
      const bool studio_reads = from == "studio" && to == "pipeline";
      const bool of_core = to == "core" || (from == "core/stage" && to == "core/io");
      if (to != from && !of_core && !kLibraryRooms.count(to) && !studio_reads)
        breaches.push_back({room.folder, "links " + link + " of another stage room"});
    }
  }
  for (const Breach& circle : Circles(arrows, " -> ")) breaches.push_back(circle);
  return breaches;
}

std::vector<Breach> UnitCycles(const std::map<std::string, std::string>& texts) {
  Arrows arrows;
  for (const auto& [file, text] : texts)
    for (const Include& include : IncludesOf(text))
      if (include.ours && UnitOf(include.path) != UnitOf(file))
        arrows[UnitOf(file)].insert(UnitOf(include.path));
  return Circles(arrows, " -> ");
}

std::vector<std::string> SourceFiles(const fs::path& root) {
  static const std::set<std::string> endings{".h", ".cpp", ".inc"};
  std::vector<std::string> files;
  for (auto entry = fs::recursive_directory_iterator(root);
       entry != fs::recursive_directory_iterator(); ++entry) {
    const std::string name = entry->path().filename().string();
    if (entry->is_directory()) {
      if (name.starts_with("build") || name.starts_with(".") || name == "node_modules")
        entry.disable_recursion_pending();
      continue;
    }
    if (endings.count(entry->path().extension().string()))
      files.push_back(fs::relative(entry->path(), root).generic_string());
  }
  std::sort(files.begin(), files.end());
  return files;
}

}  // namespace keypose::tests
