// What a person must know when a run ends: warnings, verdicts, and where the results are.
#pragma once

#include <filesystem>
#include <nlohmann/json_fwd.hpp>
#include <string>
#include <vector>

namespace keypose::pipeline {

/// What one stage warned of, on all steps that said the same.
struct RunWarning {
  std::vector<std::string> steps;  ///< ids, in the graph's order
  std::vector<std::string> poses;  ///< of these steps; none where a step is not of one pose
  std::string text;
};

struct RunVerdict {
  std::string about, grade, why;  ///< grade: "good", "look" or "wrong"
  std::string step;               ///< that judged
};

struct RunFound {
  std::string label;           ///< "the animation"
  std::filesystem::path path;  ///< absolute
  std::string step;            ///< that made it
};

struct Ending {
  std::vector<RunWarning> warnings;
  std::vector<RunVerdict> verdicts;  ///< in the order of the poses, then of the steps
  std::vector<RunFound> results;
  bool empty() const { return warnings.empty() && verdicts.empty() && results.empty(); }
};

/// As lines for a person, grouped by pose.
/// @param columns  of the terminal; 0: lines are not broken
std::string WarningsText(const Ending& ending, std::size_t columns);
std::string VerdictsText(const Ending& ending, std::size_t columns);
std::string ResultsText(const Ending& ending);
/// "2 warnings"
std::string WarningCount(const Ending& ending);

nlohmann::json ToJson(const RunWarning& warning);
nlohmann::json ToJson(const RunVerdict& verdict);
nlohmann::json ToJson(const RunFound& result);

}  // namespace keypose::pipeline
