#include <fmt/format.h>

#include <algorithm>
#include <charconv>
#include <cmath>
#include <cstdio>
#include <filesystem>
#include <map>
#include <set>
#include <utility>

#include "core/io/pictures/film_kind.h"
#include "core/io/pictures/image_kind.h"
#include "core/io/pictures/movie_header.h"
#include "core/io/pictures/painted_masks.h"
#include "core/io/pictures/photograph_files.h"
#include "core/io/project/shot_io.h"
#include "core/io/text/files.h"
#include "core/values/size_of.h"
#include "pipeline/commands/keypose_commands.h"
#include "pipeline/commands/new_project.h"
#include "pipeline/disk/project_paths.h"
#include "pipeline/disk/real_disk.h"
#include "pipeline/graph/pipeline_file.h"
#include "pipeline/text/text.h"

namespace keypose::pipeline {
namespace {

namespace fs = std::filesystem;

bool IsMask(const fs::path& file) {
  return file.has_parent_path() && file.parent_path().filename() == "masks";
}

struct NewPose {
  std::string name;
  fs::path photos;
  /// files to copy: photographs, and what belongs to them; relative to `photos`
  std::vector<fs::path> files;
  std::vector<fs::path> raw;      ///< RAW files that are not needed
  std::vector<fs::path> ignored;  ///< files that are no photographs

  /// RAW and JPEG of one shot count once; masks, clean plates and notes not at all.
  int PhotographCount() const {
    std::set<fs::path> shots;
    for (const fs::path& file : files)
      if (IsShotName(file)) shots.insert(file.parent_path() / file.stem());
    return SizeOf(shots);
  }
};

/// How pictures are taken out of a film of one turn of the turntable.
std::string WaysOutOf(const fs::path& film, const std::string& pose) {
  constexpr double kPictures = 48;  // of a turn: enough for a scan, and some may be blurred
  double a_second = 2;
  try {
    const MovieHeader header = ReadMovieHeader(film);
    if (header.fps > 0 && header.frames > 0)
      a_second = std::min(header.fps, kPictures * header.fps / header.frames);
  } catch (const Error&) {  // of another container, or without times: as above
  }
  return fmt::format(
      "is a film, and a pose is made of photographs, which are sharper. If the film is all there "
      "is, take about {} pictures of one turn out of it, as in\n  mkdir {} && ffmpeg -i {} -vf "
      "fps={:.3g} -q:v 1 {}/%04d.jpg\nand name that folder: --pose {}={}",
      kPictures, ShellWord(pose), ShellWord(film.string()), a_second, ShellWord(pose), pose,
      ShellWord(pose));
}

NewPose ParsePose(const std::string& text) {
  const auto equals = text.find('=');
  if (equals == std::string::npos || equals == 0 || equals + 1 == text.size()) {
    throw UsageError(fmt::format(
        "--pose {}: write it as NAME=PHOTO_DIR, as in --pose rest=~/photos/rest", text));
  }
  NewPose pose{Composed(text.substr(0, equals)), WithHome(text.substr(equals + 1)), {}, {}, {}};
  if (!IsName(pose.name))
    throw UsageError(fmt::format("--pose {}: a pose's name may have {}", text, kNameRule));
  pose.photos = OnDisk(RealDisk(), "", pose.photos);
  if (IsFilm(pose.photos))
    throw InputError(fmt::format("--pose {}: {} {}", text, pose.photos.string(),
                                 WaysOutOf(pose.photos, pose.name)));
  if (!fs::is_directory(pose.photos))
    throw InputError(
        fmt::format("--pose {}: {} is not a folder; name the folder of this pose's photographs",
                    text, pose.photos.string()));
  return pose;
}

/// Whether a person or a system put it there for itself, or `keypose shoot` for its merged
/// photographs.
bool IsLeftOut(const fs::path& file) {
  return std::any_of(file.begin(), file.end(), [](const fs::path& part) {
    return IsLitterName(part) || part == kFocusStacks;
  });
}

/// Puts each file of the pose's folder where it belongs.
void SortFiles(const RealDisk& disk, NewPose* pose) {
  for (const fs::path file : disk.FilesBelow(pose->photos)) {
    if (IsLeftOut(file)) continue;
    if (!IsUtf8(file.string()))
      throw InputError(
          fmt::format("--pose {}: the name of the file {} is not UTF-8 text; rename it", pose->name,
                      (pose->photos / file).string()));
    const bool wanted = IsPhotographName(file) || file.filename() == kShootNotes ||
                        (IsMask(file) && file.filename() == kPaintedNotes);
    const bool raw = IsRawName(file) && !IsMask(file);
    auto& unwanted = raw ? pose->raw : pose->ignored;
    (wanted ? pose->files : unwanted).push_back(file);
  }
}

/// Decides which files to copy. RAW files are photographs where there are no others: `capture`
/// develops them.
/// @throws InputError  there is no photograph; says what is there instead, and what to do
void Sort(const RealDisk& disk, NewPose* pose) {
  SortFiles(disk, pose);
  if (std::any_of(pose->files.begin(), pose->files.end(), IsShotName)) return;
  pose->files.insert(pose->files.end(), pose->raw.begin(), pose->raw.end());
  if (!std::exchange(pose->raw, {}).empty()) return;
  const std::string start = fmt::format("--pose {}: {} ", pose->name, pose->photos.string());
  if (pose->ignored.empty())
    throw InputError(start + "has no photographs; name the folder that they are in");
  const std::string cure = CureFor(pose->ignored);
  throw InputError(
      fmt::format("{}has no photographs that can be read ({}, RAW files such as .cr2 "
                  "and .nef); there are {}; {}",
                  start, kReadablePhotographs, KindsOf(pose->ignored),
                  cure.empty() ? "name the folder that has the photographs" : cure));
}

/// @throws InputError  names all photographs of the pose that no stage can read: they are mended in
/// one go
void RequirePictures(const NewPose& pose) {
  constexpr std::size_t kMostNamed = 5;
  std::vector<std::string> faults;
  for (const fs::path& file : pose.files) {
    if (!IsPhotographName(file)) continue;
    if (const std::string fault = PhotographFault(ReadFile(pose.photos / file)); !fault.empty())
      faults.push_back(fmt::format("{} {}", PrintableName(file), fault));
  }
  if (faults.empty()) return;
  const std::size_t named = std::min(faults.size(), kMostNamed);
  std::string text = fmt::format("{}", fmt::join(faults.begin(), faults.begin() + named, "; "));
  if (faults.size() > named) text += fmt::format("; and {} more", faults.size() - named);
  throw InputError(
      fmt::format("--pose {}: in {}, {}. Nothing was copied: mend {} or move {} out of the folder",
                  pose.name, pose.photos.string(), text, faults.size() == 1 ? "it" : "them",
                  faults.size() == 1 ? "it" : "them"));
}

void RequireFoldersOfTheirOwn(const std::vector<NewPose>& poses) {
  std::vector<PhotoFolder> folders;
  for (const NewPose& pose : poses) folders.push_back({pose.name, fs::canonical(pose.photos)});
  if (const std::string fault = SharedPhotographs(folders); !fault.empty())
    throw UsageError("--pose: " + fault);
}

void RequirePoses(const std::vector<NewPose>& poses, const std::vector<std::string>& names,
                  const char* flag) {
  for (const std::string& name : names)
    if (std::none_of(poses.begin(), poses.end(),
                     [&](const NewPose& pose) { return pose.name == Composed(name); }))
      throw UsageError(fmt::format("{} {}: there is no pose of that name", flag, name));
}

/// The poses that the template is fitted to.
/// @throws UsageError  the template is asked to be one of them, or a pose is asked to be both
std::set<std::string> FewPhotographPoses(const std::vector<NewPose>& poses,
                                         const std::string& template_pose,
                                         const InitOptions& options) {
  const auto names = [](const std::vector<std::string>& list) {
    std::set<std::string> set;
    for (const std::string& name : list) set.insert(Composed(name));
    return set;
  };
  std::set<std::string> few = names(options.few);
  const std::set<std::string> scan = names(options.scan);
  if (few.contains(template_pose))
    throw UsageError(fmt::format(
        "--few {0}: '{0}' is the template, the mesh that other poses are fitted with, so it needs "
        "photographs all round; name another pose with --template",
        template_pose));
  for (const std::string& name : few)
    if (scan.contains(name))
      throw UsageError(fmt::format("--few {0} and --scan {0}: a pose is found in one way", name));
  for (const NewPose& pose : poses)
    if (pose.name != template_pose && !scan.contains(pose.name) &&
        pose.PhotographCount() < kLeastScanPhotographs)
      few.insert(pose.name);
  return few;
}

std::vector<NewPose> ParsePoses(const InitOptions& options) {
  if (options.poses.empty()) throw UsageError("init needs at least one --pose NAME=PHOTO_DIR");
  if (!options.texture.empty() || options.same_faces)
    throw UsageError(
        "--texture and --same-faces are for poses from meshes, as in --pose rest=rest.obj");
  std::vector<NewPose> poses;
  for (const std::string& text : options.poses) {
    poses.push_back(ParsePose(text));
    for (std::size_t i = 0; i + 1 < poses.size(); ++i) {
      if (poses[i].name == poses.back().name)
        throw UsageError(fmt::format("--pose {}: there are two poses of that name", text));
    }
  }
  return poses;
}

/// The path as it shall stand in pipeline.yaml. What was filmed stays where it is.
std::string GivenPath(const char* flag, const std::string& text) {
  if (text.empty()) return "";
  const fs::path path = fs::absolute(WithHome(text)).lexically_normal();
  if (!fs::exists(path))
    throw InputError(fmt::format("{} {}: there is no {}", flag, text, path.string()));
  return path.string();
}

std::vector<std::pair<int, std::string>> ParseShows(const InitOptions& options,
                                                    const std::vector<NewPose>& poses) {
  std::map<int, std::string> shows;
  for (const std::string& text : options.shows) {
    const auto equals = text.find('=');
    int frame = -1;
    const char* end = text.data() + std::min(equals, text.size());
    const bool number = std::from_chars(text.data(), end, frame).ptr == end && frame >= 0;
    if (equals == std::string::npos || equals == 0 || !number)
      throw UsageError(fmt::format(
          "--shows {}: write it as FRAME=POSE, as in --shows 0=rest,4=wave; frames count from the "
          "film's first picture, which is 0",
          text));
    const std::string pose = Composed(text.substr(equals + 1));
    RequirePoses(poses, {pose}, "--shows");
    if (!shows.emplace(frame, pose).second)
      throw UsageError(fmt::format("--shows {}: frame {} is there twice", text, frame));
  }
  return {shows.begin(), shows.end()};
}

struct FilmFacts {
  double fps = 12;
  int last = 0;  ///< its last frame
  bool without_gaps = true;
  std::string first = "its first picture";  ///< words for it
};

/// @throws InputError  neither a folder of numbered pictures nor a whole video
FilmFacts LookAtFilm(const InitOptions& options, const std::string& film) {
  if (IsMovie(film)) {
    const MovieHeader header = ReadMovieHeader(film);
    // Three digits, as people write rates.
    return {std::round(header.fps * 1000) / 1000, header.last_frame,
            header.last_frame + 1 == header.frames};
  }
  if (IsFilm(film))
    throw InputError(fmt::format(
        "--film {}: {} is no MP4 or QuickTime file, whose header `init` reads; put the film into "
        "one as it is, or name a folder of its pictures:\n  ffmpeg -i {} -c copy film.mp4",
        options.film, film, ShellWord(film)));
  if (!fs::is_directory(film))
    throw InputError(
        fmt::format("--film {}: {} is neither a folder of numbered pictures nor a "
                    "video (.mp4, .mov)",
                    options.film, film));
  const std::vector<FilmPicture> pictures = FilmPictures(film, FilmKinds::kPicturesOrLight);
  return {12, pictures.back().frame, pictures.back().frame + 1 == SizeOf(pictures),
          PrintableName(pictures.front().path.filename())};
}

/// Pictures a second of the finished shot: 24 where that is a multiple of the film's and leaves
/// room for in-betweens, else twice those of the film.
double AnimationRate(double film_fps, bool without_gaps) {
  const double ratio = 24 / film_fps;
  const bool whole = ratio > 0.5 && std::abs(ratio - std::round(ratio)) < 1e-6;
  return whole && (ratio > 1.5 || !without_gaps) ? 24 : 2 * film_fps;
}

/// @throws UsageError  one of --film and --shows without the other, or fewer than two frames
NewShot ParseShot(const InitOptions& options, const std::vector<NewPose>& poses) {
  NewShot shot;
  const bool of_film = !options.shows.empty() || !options.plate.empty() ||
                       !options.mattes.empty() || !options.holdout.empty();
  if (options.film.empty()) {
    if (of_film)
      throw UsageError("--shows, --plate, --mattes and --holdout need --film FOLDER or VIDEO");
    return shot;
  }
  shot.film = GivenPath("--film", options.film);
  const FilmFacts film = LookAtFilm(options, shot.film);
  shot.shows = ParseShows(options, poses);
  if (shot.shows.size() < 2)
    throw UsageError(
        "--film needs --shows with two frames or more, as in --shows 0=rest,4=wave: which frames "
        "show which pose");
  if (!(options.film_fps >= 0 && options.film_fps <= 120))
    throw UsageError("--film-fps must be above 0 and at most 120");
  shot.fps = options.film_fps > 0 ? options.film_fps : film.fps;
  shot.animation_fps = AnimationRate(shot.fps, film.without_gaps);
  shot.plate = GivenPath("--plate", options.plate);
  shot.mattes = GivenPath("--mattes", options.mattes);
  shot.holdout = GivenPath("--holdout", options.holdout);
  if (shot.shows.back().first > film.last)
    throw InputError(
        fmt::format("--shows {}={}: the film's last frame is {}; frames count from {}, which is 0",
                    shot.shows.back().first, shot.shows.back().second, film.last, film.first));
  return shot;
}

void CopyPhotographs(RealDisk& disk, const NewPose& pose, const fs::path& to) {
  for (const fs::path& file : pose.files) disk.Copy(pose.photos / file, to / file);
  fmt::print("{}: {} file{} copied to {}\n", pose.name, pose.files.size(),
             pose.files.size() == 1 ? "" : "s", to.string());
  if (!pose.raw.empty())
    fmt::print("  not copied, because there are other photographs: RAW files, {}\n",
               KindsOf(pose.raw));
  if (!pose.ignored.empty())
    fmt::print("  not copied, because these are no photographs that can be read: {}\n",
               KindsOf(pose.ignored));
  if (std::any_of(pose.ignored.begin(), pose.ignored.end(), IsReadableMeshName))
    fmt::print("  {}\n", kHowToNameMeshes);
}

/// What `capture` will refuse is said at once; more photographs may follow.
void WarnOfTooFew(const NewPose& pose) {
  constexpr int kLeast = 8;  // capture's min_images
  const int count = pose.PhotographCount();
  if (count < kLeast)
    fmt::print(
        stderr,
        "warning: --pose {}: {} photograph{}; the pose that gives the others their net needs "
        "{}, and 24 or more all round are better\n",
        pose.name, count, count == 1 ? "" : "s", kLeast);
}

void TellThatItIsFitted(const NewPose& pose, const std::string& template_pose) {
  const int count = pose.PhotographCount();
  fmt::print(
      "  {} photograph{}: '{}' will be bent into {}, instead of a scan of '{}' from {} or more "
      "(`method: fit` in pipeline.yaml)\n",
      count, count == 1 ? "" : "s", template_pose, count == 1 ? "it" : "them", pose.name,
      kLeastScanPhotographs);
}

}  // namespace

void RequireNoProject(const fs::path& folder) {
  if (!fs::exists(folder) || (fs::is_directory(folder) && fs::is_empty(folder))) return;
  throw UsageError(
      fmt::format("{} exists already and is not an empty folder; choose another name, or edit "
                  "its pipeline.yaml",
                  folder.string()));
}

void RequireNoPerformance(const InitOptions& options) {
  if (!options.shots.empty() || !options.scan_mesh.empty() || !options.marks.empty() ||
      !options.calibration.empty() || options.video3d || options.surface)
    throw UsageError(
        "--shot, --scan-mesh, --marks, --calibration, --surface and --video3d need --kind "
        "performance");
}

ExitCode InitCommand(const InitOptions& options) {
  const fs::path folder = fs::absolute(WithHome(options.folder)).lexically_normal();
  std::vector<NewPose> poses = ParsePoses(options);
  const std::string template_pose =
      options.template_pose.empty() ? poses[0].name : Composed(options.template_pose);
  RequirePoses(poses, {template_pose}, "--template");
  RequirePoses(poses, options.few, "--few");
  RequirePoses(poses, options.scan, "--scan");
  const NewShot shot = ParseShot(options, poses);
  RequireNoProject(folder);
  RequireFoldersOfTheirOwn(poses);
  RealDisk disk;
  for (NewPose& pose : poses) Sort(disk, &pose);
  for (const NewPose& pose : poses) RequirePictures(pose);
  const std::set<std::string> few = FewPhotographPoses(poses, template_pose, options);
  std::vector<std::string> names;
  for (const NewPose& pose : poses) {
    CopyPhotographs(disk, pose, folder / "photos" / pose.name);
    if (few.contains(pose.name))
      TellThatItIsFitted(pose, template_pose);
    else
      WarnOfTooFew(pose);
    names.push_back(pose.name);
  }
  // Written last, so that a folder with a pipeline.yaml is a complete project.
  disk.Write(folder / "pipeline.yaml", NewPipelineText(folder, names, template_pose, few, shot));
  if (!shot.film.empty()) fmt::print("the film stays in {}\n", shot.film);
  fmt::print("your original photographs were not changed\nnext: keypose run -C {}\n",
             ShellWord(options.folder));
  return ExitCode::kOk;
}

}  // namespace keypose::pipeline
