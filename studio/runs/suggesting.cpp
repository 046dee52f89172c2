#include "studio/runs/suggesting.h"

#include <fmt/format.h>
#include <unistd.h>

#include <cstdlib>
#include <nlohmann/json.hpp>

#include "core/io/text/files.h"
#include "core/values/errors.h"
#include "pipeline/run/opened_project.h"
#include "studio/runs/children.h"

namespace keypose::studio {

namespace fs = std::filesystem;
using nlohmann::json;

namespace {

constexpr double kSuggestSeconds = 300;
constexpr int kMostSuggested = 100;

fs::path NewFile(const fs::path& folder) {
  fs::create_directories(folder);
  std::string name = (folder / "suggested_XXXXXX.json").string();
  const int file = mkstemps(name.data(), 5);
  if (file < 0) throw DiskError("cannot write a file in " + folder.string());
  close(file);
  return name;
}

std::string WhyNone(const fs::path& report) {
  const json told = json::parse(ReadFile(report), nullptr, false);
  if (!told.is_object() || !told.contains("measurements")) return "";
  if (told["measurements"].value("suggested", 1) > 0) return "";
  return told["measurements"].value("none_because", "");
}

}  // namespace

Suggested::Suggested(const fs::path& folder, const SuggestQuestion& question) {
  if (question.count < 1 || question.count > kMostSuggested)
    throw UsageError(fmt::format("suggest 1 to {} pairs", kMostSuggested));
  file_ = NewFile(folder / ".keypose/studio");
  report_ = fs::path(file_.string() + ".report");
  std::vector<std::string> words = {(pipeline::ProgramFolder() / "keypose-landmarks").string(),
                                    "suggest",
                                    "--suggested",
                                    file_.string(),
                                    "--report",
                                    report_.string(),
                                    "--count",
                                    std::to_string(question.count),
                                    "--source",
                                    question.source.string(),
                                    "--target",
                                    question.target.string()};
  for (const fs::path& known : question.known)
    words.insert(words.end(), {"--landmarks", known.string()});
  try {
    const ChildResult result = RunChild(words, folder, kSuggestSeconds);
    if (result.exit_code != 0) throw InputError(ErrorIn(result.output, result.exit_code));
    why_none_ = WhyNone(report_);
  } catch (...) {
    std::error_code ignored;
    fs::remove(file_, ignored);
    fs::remove(report_, ignored);
    throw;
  }
}

Suggested::~Suggested() {
  std::error_code ignored;
  fs::remove(file_, ignored);
  fs::remove(report_, ignored);
}

}  // namespace keypose::studio
