// What is shown at the end of a run: warnings, verdicts, and the paths of the results.
#pragma once

#include <filesystem>
#include <nlohmann/json_fwd.hpp>
#include <string>
#include <vector>

namespace keypose::pipeline {

/// One warning of a stage, with all steps that gave it.
struct RunWarning {
  std::vector<std::string> steps;  ///< ids, in the graph's order
  std::vector<std::string> poses;  ///< of these steps; empty if one is not of a single pose
  std::string text;
};

struct RunVerdict {
  std::string about, grade, why;  ///< grade: "good", "look" or "wrong"
  std::string step;               ///< the step that gave the verdict
};

struct RunFound {
  std::string label;           ///< "the animation"
  std::filesystem::path path;  ///< absolute
  std::string step;            ///< the step that made it
};

struct Ending {
  std::vector<RunWarning> warnings;
  std::vector<RunVerdict> verdicts;  ///< in the order of the poses, then of the steps
  std::vector<RunFound> results;
  bool empty() const { return warnings.empty() && verdicts.empty() && results.empty(); }
};

/// Lines for the user, grouped by pose.
/// @param columns  width of the terminal; 0: lines are not wrapped
std::string WarningsText(const Ending& ending, std::size_t columns);
/// On a terminal a line each, unless `whole`.
std::string VerdictsText(const Ending& ending, std::size_t columns, bool whole = false);
std::string ResultsText(const Ending& ending);
/// "2 warnings"
std::string WarningCount(const Ending& ending);

nlohmann::json ToJson(const RunWarning& warning);
nlohmann::json ToJson(const RunVerdict& verdict);
nlohmann::json ToJson(const RunFound& result);

}  // namespace keypose::pipeline
