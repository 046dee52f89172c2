#include "synth/commands/shot_command.h"

#include <fmt/format.h>

#include <Eigen/Geometry>
#include <algorithm>
#include <charconv>
#include <iterator>
#include <set>

#include "core/io/meshes/mesh_io.h"
#include "core/io/pictures/image_io.h"
#include "core/io/pictures/png_io.h"
#include "core/io/project/shot_io.h"
#include "core/io/text/files.h"
#include "core/values/angles.h"
#include "core/values/errors.h"
#include "synth/photographs/fresh_folder.h"
#include "synth/worlds/pose_between.h"

namespace keypose::synth {
namespace {

namespace fs = std::filesystem;

void MakeShotFolder(const fs::path& folder) {
  std::error_code error;
  fs::create_directories(folder, error);
  if (error)
    throw DiskError("synth: cannot create the folder " + folder.string() + ": " + error.message());
}

std::string PictureName(int number) { return fmt::format("{:04}.png", number); }

/// The story: pose and place of the character at any time, counted in filmed frames.
class Story {
 public:
  Story(const ShotCommand& command, const World& world) : command_(command), world_(world) {}
  int first() const { return command_.shows.begin()->first; }
  int last() const { return command_.shows.rbegin()->first; }

  Pose PoseAt(double frame) const {
    auto after = command_.shows.lower_bound(static_cast<int>(std::ceil(frame)));
    if (after == command_.shows.begin() || after->first == frame)
      return world_.PoseNamed(after->second);
    const auto before = std::prev(after);
    const double share = (frame - before->first) / (after->first - before->first);
    return PoseBetween(world_.PoseNamed(before->second), world_.PoseNamed(after->second), share);
  }
  bool camera_moves() const { return command_.swing_deg != 0 || command_.dolly_m != 0; }
  ShotSetOptions SetAt(double frame) const {
    ShotSetOptions set = command_.set;
    const double share = ShareAt(frame), eased = share * share * (3 - 2 * share) - 0.5;
    set.camera_azimuth_deg += eased * command_.swing_deg;
    set.distance_m -= eased * command_.dolly_m;
    return set;
  }
  Similarity3 PlaceAt(double frame) const {
    const double share = ShareAt(frame) - 0.5;
    const double turn = share * command_.turn_deg * kPi / 180;
    return {1,
            Eigen::AngleAxisd(turn, Eigen::Vector3d::UnitZ()).toRotationMatrix(),
            {share * command_.travel_m, 0.3 * share * command_.travel_m, 0}};
  }

 private:
  double ShareAt(double frame) const {
    return last() > first() ? (frame - first()) / (last() - first()) : 0.5;
  }

  const ShotCommand& command_;
  const World& world_;
};

class ShotFilming {
 public:
  ShotFilming(const ShotCommand& command, const World& world)
      : command_(command),
        world_(world),
        story_(command, world),
        set_(story_.SetAt(story_.first())) {
    const fs::path mattes = Truth() / "mattes";
    MakeFreshFolder(command.output / "film", mattes);
    for (const char* part : {"mattes", "frames", "between"})
      MakeFreshFolder(Truth() / part, Truth() / part);
    if (command.meshes) MakeShotFolder(Truth() / "meshes");
    if (HasPlates()) MakeFreshFolder(command.output / "plates", mattes);
    shot_.camera = set_.view().camera;
    shot_.fps = command.fps;
    shot_.still = !story_.camera_moves();
  }

  /// @return number of filmed frames
  int FilmAll(Progress* progress) {
    if (command_.clean_plate && !HasPlates())
      WritePng(command_.output / "plate.png", set_.Plate(0));
    const int pictures = (story_.last() - story_.first()) * command_.between;
    for (int n = 0; n <= pictures; ++n) {
      if (progress && progress->cancelled()) throw Cancelled();
      ReportProgress(progress, n / (pictures + 1.0), "filming");
      FilmOne(n);
    }
    WriteFile(Truth() / "shot.json", ShotText(shot_));
    return static_cast<int>(shot_.frames.size());
  }

 private:
  bool HasPlates() const { return command_.clean_plate && story_.camera_moves(); }
  fs::path Truth() const { return command_.output / "truth" / "shot"; }

  void FilmOne(int n) {
    const double frame = story_.first() + n / static_cast<double>(command_.between);
    if (story_.camera_moves()) set_ = ShotSet(story_.SetAt(frame));
    if (HasPlates())
      WritePng(command_.output / "plates" / PictureName(n),
               set_.Plate(static_cast<std::uint64_t>(n)));
    const bool whole = n % command_.between == 0;
    const int number = story_.first() + n / command_.between;
    const bool keyed = whole && command_.shows.count(number);
    const bool filmed = whole && (keyed || !command_.keys_only);
    const PointsX3 points = story_.PoseAt(frame)(world_.rest.points);
    const Similarity3 place = story_.PlaceAt(frame);
    const ShotPicture picture = set_.Film(world_, points, place, static_cast<std::uint64_t>(n) + 1);
    if (!filmed) WritePng(Truth() / "between" / PictureName(n), picture.matte);
    if (command_.meshes) {
      Mesh surface;
      surface.points = Transformed(place, points);
      surface.faces = world_.rest.faces;
      WriteMesh(Truth() / "meshes" / fmt::format("frame_{:04}.ply", n), surface);
    }
    if (!filmed) return WritePng(Truth() / "frames" / PictureName(n), picture.picture);
    WritePng(command_.output / "film" / PictureName(number), picture.picture);
    WritePng(Truth() / "mattes" / PictureName(number), picture.matte);
    ShotFrame entry;
    entry.frame = number - story_.first();
    entry.picture = PictureName(number);
    if (keyed) entry.pose = command_.shows.at(number);
    entry.camera_from_world = set_.view().camera_from_world;
    entry.world_from_character = place;
    entry.method = "given";
    shot_.frames.push_back(entry);
  }

  const ShotCommand& command_;
  const World& world_;
  Story story_;
  ShotSet set_;
  FilmedShot shot_;
};

int TakePhotographs(const ShotCommand& command, Progress* progress) {
  PhotosCommand photos = command.photos;
  photos.output = command.output;
  photos.world = command.world;
  std::set<std::string> seen;
  photos.poses.clear();
  for (const auto& [frame, pose] : command.shows)
    if (seen.insert(pose).second) photos.poses.push_back(pose);
  return RunPhotos(photos, progress);
}

}  // namespace

std::vector<std::string> ShotCommand::Problems() const {
  std::vector<std::string> problems = set.Problems();
  if (shows.empty()) problems.push_back("--shows needs one frame at least, such as 0=rest");
  if (!shows.empty() && shows.begin()->first < 0) problems.push_back("--shows has a frame below 0");
  if (!shows.empty() && shows.rbegin()->first > 9999)
    problems.push_back("--shows has a frame beyond 9999");
  if (between < 1 || between > 8) problems.push_back("--between must be from 1 to 8");
  if (!(fps > 0 && fps <= 120)) problems.push_back("--fps must be above 0, and at most 120");
  return problems;
}

std::map<int, std::string> ReadShows(const std::vector<std::string>& texts) {
  std::map<int, std::string> shows;
  for (const std::string& text : texts) {
    const std::size_t equals = text.find('=');
    int frame = 0;
    const bool good =
        equals != std::string::npos && equals > 0 && equals + 1 < text.size() &&
        std::from_chars(text.data(), text.data() + equals, frame).ptr == text.data() + equals;
    if (!good)
      throw UsageError("synth: --shows is '" + text + "'; it needs FRAME=POSE, such as 4=wave");
    if (!shows.emplace(frame, text.substr(equals + 1)).second)
      throw UsageError(fmt::format("synth: --shows has frame {} twice", frame));
  }
  return shows;
}

std::string RunShot(const ShotCommand& command, Progress* progress) {
  const std::vector<std::string> problems = command.Problems();
  if (!problems.empty()) throw UsageError("synth: " + problems.front());
  const World world = MakeWorld(command.world);
  for (const auto& [frame, pose] : command.shows) world.PoseNamed(pose);
  const int filmed = ShotFilming(command, world).FilmAll(progress);
  const int photographs = command.photographs ? TakePhotographs(command, progress) : 0;
  return fmt::format("{} filmed frames in {}, {} photographs", filmed,
                     (command.output / "film").string(), photographs);
}

}  // namespace keypose::synth
