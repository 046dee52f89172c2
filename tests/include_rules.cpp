#include "tests/include_rules.h"

#include <algorithm>
#include <regex>
#include <set>
#include <sstream>

namespace keypose::tests {
namespace {

namespace fs = std::filesystem;

const std::set<std::string> kStageRooms{"capture",     "reconstruct", "cleanup", "texture", "register",
                                        "interpolate", "export",      "report",  "studio"};
const std::vector<std::string> kHeavy{"CGAL/", "pcl/", "ceres/", "tetgen", "opencv2/", "embree"};

bool StartsWithAny(const std::string& text, const std::vector<std::string>& starts) {
  return std::any_of(starts.begin(), starts.end(), [&](const auto& start) { return text.starts_with(start); });
}

// "core/io/files.h" -> "core/io", "register/nricp.h" -> "register", "pipeline/testing/x.h" -> "pipeline"
std::string RoomOf(const std::string& path) {
  if (path.starts_with("core/io/")) return "core/io";
  if (path.starts_with("core/stage/")) return "core/stage";
  const auto slash = path.find('/');
  return slash == std::string::npos ? "" : path.substr(0, slash);
}

// Files are the business of a stage's own program, of tests, and of the adapters to COLMAP, which speaks in files.
bool MayTouchFiles(const std::string& file) {
  static const std::regex pattern(".*((_stage|_test|_bench|/main)\\.cpp|_colmap\\.(cpp|h))");
  return std::regex_match(file, pattern);
}

std::string ProjectReason(const std::string& file, const std::string& included) {
  const std::string from = RoomOf(file), to = RoomOf(included);
  if (to.empty()) return "\"" + included + "\" is not given from the project's root";
  if (to == from || from == "tests" || from == "bench") return "";
  const bool is_test = file.ends_with("_test.cpp");
  if (is_test && from.starts_with("core") && to.starts_with("core")) return "";
  std::set<std::string> may;
  if (kStageRooms.count(from)) {
    may = {"core", "core/io", "core/stage"};
    if (to == "core/io" && !MayTouchFiles(file))
      return "an algorithm does not touch files: core/io belongs in *_stage.cpp, main.cpp and tests";
  } else if (from == "synth" || from == "pipeline") {
    may = {"core", "core/io"};
  } else if (from == "core/io" || from == "core/stage") {
    may = {"core"};
  }
  // files.h knows no format: whole files in and out, which the stage's own report needs too.
  if (from == "core/stage" && included == "core/io/files.h") return "";
  if (may.count(to)) return "";
  if (kStageRooms.count(from) && kStageRooms.count(to))
    return "stage rooms never include each other: what " + from + " and " + to + " need moves to core";
  return from + " may not include " + to;
}

std::string SystemReason(const std::string& file, const std::string& included) {
  if (!file.ends_with(".h")) return "";
  if (StartsWithAny(included, kHeavy)) return "<" + included + "> stays inside .cpp files";
  const bool standard = included.find('/') == std::string::npos && included.find('.') == std::string::npos;
  if ((RoomOf(file) == "core" || RoomOf(file) == "core/io") && !standard && !included.starts_with("Eigen/"))
    return "headers of core include only Eigen and the standard library, not <" + included + ">";
  return "";
}

}  // namespace

std::vector<Breach> IncludeBreaches(const std::string& file, const std::string& text) {
  static const std::regex pattern("^\\s*#\\s*include\\s*([<\"])([^>\"]+)[>\"].*");
  std::vector<Breach> breaches;
  std::istringstream lines(text);
  int number = 0;
  for (std::string line; std::getline(lines, line);) {
    ++number;
    std::smatch match;
    if (!std::regex_match(line, match, pattern)) continue;
    const std::string reason = match[1] == "\"" ? ProjectReason(file, match[2]) : SystemReason(file, match[2]);
    if (!reason.empty()) breaches.push_back({file + ":" + std::to_string(number), reason});
  }
  return breaches;
}

std::vector<std::string> SourceFiles(const fs::path& root) {
  std::vector<std::string> files;
  for (auto entry = fs::recursive_directory_iterator(root); entry != fs::recursive_directory_iterator(); ++entry) {
    const std::string name = entry->path().filename().string();
    if (entry->is_directory()) {
      if (name.starts_with("build") || name.starts_with(".") || name == "node_modules") entry.disable_recursion_pending();
      continue;
    }
    if (entry->path().extension() == ".h" || entry->path().extension() == ".cpp")
      files.push_back(fs::relative(entry->path(), root).generic_string());
  }
  std::sort(files.begin(), files.end());
  return files;
}

}  // namespace keypose::tests
