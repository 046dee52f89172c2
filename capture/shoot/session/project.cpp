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

std::vector<std::string> PosesOf(const YAML::Node& root) {
  std::vector<std::string> poses;
  const YAML::Node map = root["poses"];
  if (map && map.IsMap())
    for (const auto& entry : map) poses.push_back(entry.first.Scalar());
  return poses;
}

/// The folder of photographs that the file names for the pose; "" if it names none.
std::string FolderIn(const YAML::Node& root, const std::string& pose) {
  const YAML::Node rule = root["poses"][pose];
  if (rule.IsScalar()) return rule.Scalar();
  const YAML::Node photos = rule.IsMap() ? rule["photos"] : YAML::Node();
  return photos.IsDefined() && photos.IsScalar() ? photos.Scalar() : "";
}

/// Whether the timeline says only in which order the poses come: all of them, or nothing.
bool OnlyListsPoses(const YAML::Node& root, const std::vector<std::string>& poses) {
  const YAML::Node timeline = root["timeline"];
  if (!timeline.IsDefined() || timeline.IsNull()) return true;
  if (!timeline.IsSequence() || timeline.size() != poses.size()) return false;
  for (std::size_t i = 0; i < poses.size(); ++i)
    if (!timeline[i].IsScalar() || timeline[i].Scalar() != poses[i]) return false;
  return true;
}

std::string WithPose(const std::string& text, const YAML::Node& root, const std::string& pose) {
  std::vector<std::string> poses = PosesOf(root);
  const bool extend = OnlyListsPoses(root, poses);
  std::string edited = WithValue(text, {"poses", pose}, YamlScalar("photos/" + pose));
  poses.push_back(pose);
  if (poses.size() == 1 && !root["template"].IsDefined())
    edited = WithValue(edited, {"template"}, YamlScalar(pose));
  if (!extend || poses.size() < 2) return edited;
  std::string list;
  for (const std::string& name : poses) list += (list.empty() ? "" : ", ") + YamlScalar(name);
  return WithValue(edited, {"timeline"}, "[" + list + "]");
}

fs::path WithHome(const std::string& path) {
  const char* home = std::getenv("HOME");
  return home && path.starts_with("~/") ? fs::path(home) / path.substr(2) : fs::path(path);
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

fs::path AddPose(const fs::path& project, const std::string& pose) {
  if (!IsPoseName(pose))
    throw UsageError(
        fmt::format("a pose's name may have letters, digits, '-' and '_' only; '{}' "
                    "has not",
                    WithoutOddBytes(pose)));
  const fs::path file = project / "pipeline.yaml";
  std::string folder = "photos/" + pose;
  try {
    if (!fs::exists(file)) {
      WriteFileAtomically(file, NewPipelineText(project, pose));
    } else {
      const std::string text = ReadFile(file);
      const YAML::Node root = YAML::Load(text);
      const std::vector<std::string> poses = PosesOf(root);
      if (std::find(poses.begin(), poses.end(), pose) == poses.end())
        WriteFileAtomically(file, WithPose(text, root, pose));
      else if (const std::string named = FolderIn(root, pose); !named.empty())
        folder = named;
    }
  } catch (const YamlEditError& error) {
    throw UsageError(fmt::format("the pose '{}' cannot be added to {}: {}; add it by hand", pose,
                                 file.string(), error.what()));
  } catch (const YAML::Exception& error) {
    throw UsageError(fmt::format("{} is not YAML: {}; mend it first", file.string(), error.what()));
  }
  return (project / WithHome(folder)).lexically_normal();
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
