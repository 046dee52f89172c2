#include <fmt/format.h>

#include <algorithm>
#include <cctype>
#include <cstdio>
#include <filesystem>

#include "pipeline/commands.h"
#include "pipeline/pipeline_file.h"
#include "pipeline/real_disk.h"

namespace keypose::pipeline {
namespace {

namespace fs = std::filesystem;

struct NewPose {
  std::string name;
  fs::path photos;
};

NewPose ParsePose(const std::string& text) {
  const auto equals = text.find('=');
  if (equals == std::string::npos || equals == 0 || equals + 1 == text.size()) {
    throw UsageError(fmt::format("--pose {}: write it as NAME=PHOTO_DIR, as in --pose rest=~/photos/rest", text));
  }
  NewPose pose{text.substr(0, equals), text.substr(equals + 1)};
  const bool fine = pose.name[0] != '-' && std::all_of(pose.name.begin(), pose.name.end(),
                                                       [](unsigned char c) { return std::isalnum(c) || c == '-' || c == '_'; });
  if (!fine) throw UsageError(fmt::format("--pose {}: a pose's name may have letters, digits, '-' and '_' only", text));
  if (!fs::is_directory(pose.photos))
    throw InputError(fmt::format("--pose {}: {} is not a folder; name the folder of this pose's photographs", text, pose.photos.string()));
  return pose;
}

/// The folder's name without what would need escapes in YAML.
std::string SafeName(const fs::path& folder) {
  std::string name = folder.has_filename() ? folder.filename().string() : folder.parent_path().filename().string();
  std::erase_if(name, [](unsigned char c) { return c < 32 || c == '"' || c == '\\'; });
  return name;
}

std::string PipelineText(const std::string& name, const std::vector<NewPose>& poses, const std::string& template_pose) {
  std::string text = "# What this project is made of. All that is not said here is as in the default pipeline; see docs/pipeline.md.\n";
  text += fmt::format("name: \"{}\"\nposes:\n", name);
  for (const NewPose& pose : poses) text += fmt::format("  {0}: photos/{0}\n", pose.name);
  text += fmt::format("template: {}\n", template_pose);
  if (poses.size() > 1) {
    text += "timeline: [";
    for (std::size_t i = 0; i < poses.size(); ++i) text += (i ? ", " : "") + poses[i].name;
    text += "]\n";
  }
  return text;
}

}  // namespace

ExitCode InitCommand(const InitOptions& options) {
  const fs::path folder = fs::absolute(options.folder).lexically_normal();
  if (options.poses.empty()) throw UsageError("init needs at least one --pose NAME=PHOTO_DIR");
  std::vector<NewPose> poses;
  for (const std::string& text : options.poses) {
    poses.push_back(ParsePose(text));
    for (std::size_t i = 0; i + 1 < poses.size(); ++i) {
      if (poses[i].name == poses.back().name) throw UsageError(fmt::format("--pose {}: there are two poses of that name", text));
    }
  }
  const std::string template_pose = options.template_pose.empty() ? poses[0].name : options.template_pose;
  if (std::none_of(poses.begin(), poses.end(), [&](const NewPose& pose) { return pose.name == template_pose; })) {
    throw UsageError(fmt::format("--template {}: there is no pose of that name", template_pose));
  }
  if (fs::exists(folder) && (!fs::is_directory(folder) || !fs::is_empty(folder))) {
    throw UsageError(
        fmt::format("{} exists already and is not an empty folder; choose another name, or edit its pipeline.yaml", folder.string()));
  }
  RealDisk disk;
  int count = 0;
  for (const NewPose& pose : poses) {
    for (const std::string& name : disk.FilesBelow(pose.photos)) {
      disk.Copy(pose.photos / name, folder / "photos" / pose.name / name);
      ++count;
    }
    disk.MakeFolder(folder / "photos" / pose.name);
  }
  // Last, so that a folder with a pipeline.yaml is a whole project.
  disk.Write(folder / "pipeline.yaml", PipelineText(SafeName(folder), poses, template_pose));
  fmt::print("{}: {} file{} copied; the photographs you named stay as they are\nnext: keypose run -C {}\n", folder.string(), count,
             count == 1 ? "" : "s", options.folder);
  return ExitCode::kOk;
}

}  // namespace keypose::pipeline
