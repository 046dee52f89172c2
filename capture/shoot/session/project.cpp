#include "capture/shoot/session/project.h"

#include <fcntl.h>
#include <fmt/format.h>
#include <sys/file.h>
#include <unistd.h>
#include <yaml-cpp/yaml.h>

#include <algorithm>
#include <cerrno>
#include <cstdlib>
#include <cstring>
#include <vector>

#include "core/io/text/files.h"
#include "core/io/text/pose_yaml.h"
#include "core/io/text/yaml_edit.h"
#include "core/values/errors.h"

namespace keypose::capture::shoot {
namespace {

namespace fs = std::filesystem;

std::string NewPipelineText(const fs::path& project, const std::string& pose) {
  const fs::path clean = fs::absolute(project).lexically_normal();
  const fs::path folder = clean.has_filename() ? clean : clean.parent_path();
  std::string name = folder.filename().string();
  std::erase_if(name, [](unsigned char c) { return c < 32 || c == '"' || c == '\\'; });
  return fmt::format(
      "# The poses and settings of this project. What is not set here is as in the default "
      "pipeline; see docs/pipeline.md.\nname: \"{0}\"\nposes:\n  {1}: photos/{1}\ntemplate: {1}\n",
      WithoutOddBytes(name), YamlScalar(pose));
}

/// The folder of photographs that the file names for the pose; "" if it names none.
std::string FolderIn(const YAML::Node& root, const std::string& pose) {
  const YAML::Node rule = root["poses"][pose];
  if (rule.IsScalar()) return rule.Scalar();
  const YAML::Node photos = rule.IsMap() ? rule["photos"] : YAML::Node();
  return photos.IsDefined() && photos.IsScalar() ? photos.Scalar() : "";
}

fs::path WithHome(const std::string& path) {
  const char* home = std::getenv("HOME");
  return home && path.starts_with("~/") ? fs::path(home) / path.substr(2) : fs::path(path);
}

fs::path FolderOf(const fs::path& project, const std::string& text, const std::string& pose) {
  const std::string named = FolderIn(YAML::Load(text), pose);
  const std::string folder = named.empty() ? "photos/" + pose : named;
  return (project / WithHome(folder)).lexically_normal();
}

bool HasPhotographs(const fs::path& folder) {
  std::error_code missing;
  return fs::directory_iterator(folder, missing) != fs::directory_iterator();
}

/// The text of pipeline.yaml with the pose.
std::string TextWith(const std::string& text, const fs::path& project, const std::string& pose,
                     int photographs) {
  const std::vector<std::string> poses = PosesIn(text);
  const bool few = photographs < kFewestOfAScan && !poses.empty();
  if (std::find(poses.begin(), poses.end(), pose) == poses.end()) return WithPose(text, pose, few);
  const bool decided = !MethodIn(text, pose).empty() || TemplateIn(text) == pose ||
                       HasPhotographs(FolderOf(project, text, pose));
  return few && !decided ? WithMethod(text, pose, "fit") : text;
}

}  // namespace

bool IsPoseName(const std::string& name) {
  if (name.empty() || name.front() == '-' || !IsValidUtf8(name)) return false;
  for (const unsigned char c : name) {
    const bool letter = (c >= 'a' && c <= 'z') || (c >= 'A' && c <= 'Z') || c >= 0x80;
    if (!letter && !(c >= '0' && c <= '9') && c != '-' && c != '_') return false;
  }
  return true;
}

PosePlace AddPose(const fs::path& project, const std::string& pose, int photographs) {
  if (!IsPoseName(pose))
    throw UsageError(
        fmt::format("a pose's name may have letters, digits, '-' and '_' only; '{}' "
                    "has not",
                    WithoutOddBytes(pose)));
  const fs::path file = project / "pipeline.yaml";
  try {
    const std::string before = fs::exists(file) ? ReadFile(file) : "";
    const std::string text = before.empty() ? NewPipelineText(project, pose)
                                            : TextWith(before, project, pose, photographs);
    if (text != before) WriteFileAtomically(file, text);
    const bool bent = MethodIn(text, pose) == "fit";
    return {FolderOf(project, text, pose), bent ? TemplateIn(text) : ""};
  } catch (const YamlEditError& error) {
    throw UsageError(fmt::format("the pose '{}' cannot be added to {}: {}; add it by hand", pose,
                                 file.string(), error.what()));
  } catch (const YAML::Exception& error) {
    throw UsageError(fmt::format("{} is not YAML: {}; mend it first", file.string(), error.what()));
  }
}

bool HasOtherPose(const fs::path& project, const std::string& pose) {
  const fs::path file = project / "pipeline.yaml";
  try {
    const auto poses = fs::exists(file) ? PosesIn(ReadFile(file)) : std::vector<std::string>();
    return std::any_of(poses.begin(), poses.end(), [&](const auto& one) { return one != pose; });
  } catch (const YamlEditError&) {
    return false;  // AddPose says what is wrong
  }
}

ShootLock::ShootLock(const fs::path& state_folder) {
  std::error_code error;
  fs::create_directories(state_folder, error);
  const fs::path file = state_folder / "lock";
  fd_ = ::open(file.c_str(), O_RDWR | O_CREAT | O_CLOEXEC, 0644);
  if (fd_ < 0)
    throw DiskError(fmt::format("cannot write {}: {}", file.string(), std::strerror(errno)));
  if (::flock(fd_, LOCK_EX | LOCK_NB) == 0) return;
  ::close(fd_);
  fd_ = -1;
  throw LockedError(
      "another `keypose shoot` is at work in this project; end it there (or in the studio) first");
}

ShootLock::~ShootLock() {
  if (fd_ >= 0) ::close(fd_);
}

}  // namespace keypose::capture::shoot
