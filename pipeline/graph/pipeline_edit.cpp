#include "pipeline/graph/pipeline_edit.h"

#include <fcntl.h>
#include <fmt/format.h>
#include <sys/file.h>
#include <unistd.h>

#include "core/io/text/files.h"
#include "core/numbers/sha256.h"
#include "core/values/errors.h"

namespace keypose::pipeline {

namespace fs = std::filesystem;

namespace {

/// Held for the moment between looking at a file of the project and replacing it. Where a file
/// system has no locks, the check of the revision alone must do.
class WritersTurn {
 public:
  explicit WritersTurn(const fs::path& project)
      : fd_(open(project.c_str(), O_RDONLY | O_DIRECTORY | O_CLOEXEC)) {
    constexpr int kTries = 100;  // 2 s, of which a writer needs milliseconds
    for (int i = 0; fd_ >= 0 && i < kTries && flock(fd_, LOCK_EX | LOCK_NB) != 0; ++i)
      usleep(20000);
  }
  ~WritersTurn() {
    if (fd_ >= 0) close(fd_);
  }
  WritersTurn(const WritersTurn&) = delete;
  WritersTurn& operator=(const WritersTurn&) = delete;

 private:
  int fd_;
};

YamlPath PathOf(const PipelineFile& file, const std::string& pose, const YamlPath& below) {
  const bool shots = file.kind == ProjectKind::kPerformance;
  YamlPath path = {shots ? "shots" : "poses", pose};
  path.insert(path.end(), below.begin(), below.end());
  return path;
}

/// A pose in its short form, written as a map.
std::string AsMap(const PipelineFile& file, const std::string& pose) {
  const PoseRule* rule = file.FindPose(pose);
  const bool shots = file.kind == ProjectKind::kPerformance;
  const char* const word = shots ? kVideoWord : kPhotosWord;
  const Setting* given = rule->Given(word);
  const std::string folder = given ? given->text : (shots ? "shots/" : "photos/") + pose;
  return fmt::format("{{{}: {}}}", word, YamlScalar(folder));
}

}  // namespace

std::string RevisionOf(const fs::path& file) {
  std::error_code ignored;
  return fs::is_regular_file(file, ignored) ? Sha256Of(ReadFile(file)).substr(0, 16) : "";
}

std::string Edited(const std::function<std::string()>& edit) {
  try {
    return edit();
  } catch (const YamlEditError& error) {
    throw UsageError(fmt::format("pipeline.yaml cannot be changed from here: {}", error.what()));
  }
}

std::string WithPoseSetting(const PipelineFile& file, const std::string& text,
                            const std::string& pose, const YamlPath& below,
                            const std::string& value) {
  const YamlPath path = PathOf(file, pose, below);
  try {
    return WithValue(text, path, value);
  } catch (const YamlEditError&) {
    return WithValue(WithValue(text, PathOf(file, pose, {}), AsMap(file, pose)), path, value);
  }
}

std::string WithoutPoseSetting(const PipelineFile& file, const std::string& text,
                               const std::string& pose, const YamlPath& below) {
  return WithoutValue(text, PathOf(file, pose, below));
}

std::string WritePipelineFile(const fs::path& project, const std::string& text,
                              const std::string& revision) {
  const fs::path file = project / "pipeline.yaml";
  const WritersTurn turn(project);
  if (RevisionOf(file) != revision)
    throw ChangedMeanwhile("pipeline.yaml was changed elsewhere; it was read again");
  ParsePipelineFile(text, "pipeline.yaml");
  WriteFileAtomically(file, text);
  return RevisionOf(file);
}

}  // namespace keypose::pipeline
