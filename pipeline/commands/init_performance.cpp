#include <fmt/format.h>

#include <algorithm>
#include <filesystem>

#include "core/io/pictures/film_kind.h"
#include "pipeline/commands/keypose_commands.h"
#include "pipeline/commands/new_project.h"
#include "pipeline/disk/project_paths.h"
#include "pipeline/disk/real_disk.h"
#include "pipeline/text/text.h"

namespace keypose::pipeline {
namespace {

namespace fs = std::filesystem;

std::pair<std::string, std::string> ParseShot(const std::string& text) {
  const auto equals = text.find('=');
  if (equals == std::string::npos || equals == 0 || equals + 1 == text.size())
    throw UsageError(
        fmt::format("--shot {}: write it as NAME=FOLDER, as in --shot walk=~/films/walk", text));
  const std::string name = Composed(text.substr(0, equals));
  if (!IsName(name))
    throw UsageError(fmt::format("--shot {}: a shot's name may have {}", text, kNameRule));
  const fs::path folder = fs::absolute(WithHome(text.substr(equals + 1))).lexically_normal();
  if (IsFilm(folder))
    throw InputError(fmt::format(
        "--shot {}: {} is a film; put it into a folder with those of the other cameras, and name "
        "the folder",
        text, folder.string()));
  if (!fs::is_directory(folder))
    throw InputError(fmt::format(
        "--shot {}: {} is not a folder; name the folder with one video or picture folder for each "
        "camera",
        text, folder.string()));
  return {name, folder.string()};
}

/// The file's absolute path.
/// @throws InputError  it is not there
fs::path Given(const char* flag, const std::string& text) {
  const fs::path path = fs::absolute(WithHome(text)).lexically_normal();
  if (!fs::exists(path))
    throw InputError(fmt::format("{} {}: there is no {}", flag, text, path.string()));
  return path;
}

/// Copies a file into the project.
/// @return its path there; empty when none is given
std::string Copied(RealDisk& disk, const char* flag, const std::string& text,
                   const fs::path& project) {
  if (text.empty()) return "";
  const fs::path from = Given(flag, text);
  if (fs::is_directory(from))
    throw InputError(
        fmt::format("{} {}: {} is a folder, but a file is needed", flag, text, from.string()));
  disk.Copy(from, project / from.filename());
  return from.filename().string();
}

void TellWhatIsNext(const InitOptions& options) {
  const std::string project = ShellWord(options.folder);
  if (options.scan_mesh.empty() || options.marks.empty())
    fmt::print(
        "next: keypose run -C {0}: tracks the body; for a scan that moves with it, give `scan` and "
        "`marks` in {0}/pipeline.yaml\n",
        project);
  else
    fmt::print("next: keypose run -C {}\n", project);
}

}  // namespace

ExitCode InitPerformance(const InitOptions& options) {
  const fs::path folder = fs::absolute(WithHome(options.folder)).lexically_normal();
  if (options.shots.empty())
    throw UsageError("init --kind performance needs at least one --shot NAME=FOLDER");
  if (!options.poses.empty() || !options.few.empty() || !options.scan.empty())
    throw UsageError("--pose, --few and --scan do not belong to --kind performance");
  if (!options.film.empty() || !options.shows.empty())
    throw UsageError("--film and --shows do not belong to --kind performance");
  NewPerformance performance;
  for (const std::string& text : options.shots) {
    performance.shots.push_back(ParseShot(text));
    const std::string& name = performance.shots.back().first;
    const auto same = [&](const auto& shot) { return shot.first == name; };
    if (std::count_if(performance.shots.begin(), performance.shots.end(), same) > 1)
      throw UsageError(fmt::format("--shot {}: there are two shots of that name", text));
  }
  if (!options.calibration.empty())
    performance.calibration = Given("--calibration", options.calibration).string();
  for (const auto& [flag, path] :
       {std::pair<const char*, std::string>{"--scan-mesh", options.scan_mesh},
        {"--texture", options.texture},
        {"--marks", options.marks}})
    if (!path.empty()) Given(flag, path);
  RequireNoProject(folder);
  RealDisk disk;
  performance.scan = Copied(disk, "--scan-mesh", options.scan_mesh, folder);
  performance.texture = Copied(disk, "--texture", options.texture, folder);
  performance.marks = Copied(disk, "--marks", options.marks, folder);
  performance.video3d = options.video3d;
  performance.surface = options.surface;
  disk.Write(folder / "pipeline.yaml", NewPerformanceText(folder, performance));
  for (const auto& [name, films] : performance.shots)
    fmt::print("{}: films stay in {}\n", name, films);
  TellWhatIsNext(options);
  return ExitCode::kOk;
}

}  // namespace keypose::pipeline
