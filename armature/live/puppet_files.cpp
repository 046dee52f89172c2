#include "armature/live/puppet_files.h"

#include <algorithm>
#include <cstdlib>

#include "armature/description/chain_file.h"
#include "armature/description/description_file.h"
#include "armature/skinning/bone_heat.h"
#include "armature/skinning/stick_mesh.h"
#include "armature/skinning/weights_text.h"
#include "core/io/meshes/bvh_io.h"
#include "core/io/meshes/mesh_io.h"
#include "core/io/pictures/image_io.h"
#include "core/io/project/shot_io.h"
#include "core/io/text/files.h"
#include "core/pictures/render.h"
#include "core/surfaces/geometry.h"
#include "core/surfaces/mesh_checks.h"
#include "core/values/errors.h"
#include "core/values/size_of.h"

namespace keypose::armature {

namespace fs = std::filesystem;

std::vector<Port> PuppetPorts() {
  return {{"description", "file", "the armature's description file", "", false, false},
          {"chains", "file", "the file of anchors and chains", "", false, false},
          {"skeleton", "file", "the computer skeleton (.bvh); else like the armature itself", "",
           true, false},
          {"mesh", "file", "the character at rest; else ball and stick", "", true, false},
          {"weights", "file", "the mesh's weights (.json, .mhw or .dmat); else by heat", "", true,
           false}};
}

PuppetPaths PuppetPathsIn(const StageContext& stage) {
  const auto given = [&](const char* port) {
    return stage.Has(port) ? stage.Input(port) : fs::path();
  };
  return {given("description"), given("chains"), given("skeleton"), given("mesh"),
          given("weights")};
}

void PuppetChoices::Describe(OptionVisitor& visit) {
  visit("method", method,
        {.help = "how chains are matched: with both anchors exact, or from the near anchor on as "
                 "in the paper",
         .choices = {"both_ends", "greedy"}});
  visit("unreachable", unreachable,
        {.help = "which anchor a chain keeps that is too short for both",
         .choices = {"near", "far", "split"}});
  visit("calm", calm,
        {"how much a match resists changes against the one before; 0: not at all", "", 0, 10});
  visit("armature_up", armature_up,
        {.help = "which way is up in the description", .choices = {"y", "z"}});
  visit(
      "skeleton_up", skeleton_up,
      {.help = "which way is up in the skeleton's file; the mesh has z up", .choices = {"y", "z"}});
}

namespace {

PuppetOptions OptionsOf(const PuppetChoices& choices) {
  PuppetOptions options;
  options.greedy = choices.method == "greedy";
  options.match.calm_weight = choices.calm;
  options.match.unreachable = Unreachable::kSplit;
  if (choices.unreachable == "near") options.match.unreachable = Unreachable::kKeepNear;
  if (choices.unreachable == "far") options.match.unreachable = Unreachable::kKeepFar;
  return options;
}

/// The skeleton, and where the armature stands in its world.
void LoadSkeleton(const fs::path& path, const PuppetChoices& choices, PuppetParts& parts) {
  const bool y_up = choices.armature_up == "y";
  if (!path.empty()) {
    parts.skeleton = SkeletonOfClip(ReadBvh(path), choices.skeleton_up == "y");
    parts.world_from_armature = PlacementOf(parts.armature, parts.plan, parts.skeleton, y_up);
    return;
  }
  if (y_up) parts.world_from_armature.rotation << 1, 0, 0, 0, 0, -1, 0, 1, 0;
  // The chains' own places take the part of the joints that the file names.
  for (Chain& chain : parts.plan.chains) chain.computer.clear();
  const std::vector<double> zero(parts.armature.joints.size(), 0);
  std::vector<Rigid3> frames = ForwardKinematics(parts.armature, zero);
  for (Rigid3& frame : frames) frame.translation = parts.world_from_armature * frame.translation;
  parts.skeleton = SkeletonOfArmature(parts.armature, parts.plan, frames);
}

/// Bones lie inside of what they move, or near it.
void CheckPlaces(const PointsX3& joints, LoadedPuppet& puppet) {
  const PointsX3& points = puppet.parts.mesh.points;
  const Eigen::RowVector3d low = points.colwise().minCoeff(), high = points.colwise().maxCoeff();
  const double margin = 0.1 * (high - low).norm();
  int inside = 0;
  for (int j = 0; j < joints.rows(); ++j)
    inside += ((joints.row(j) - low).array() > -margin).all() &&
              ((high - joints.row(j)).array() > -margin).all();
  if (2 * inside < joints.rows())
    puppet.misplaced =
        std::to_string(joints.rows() - inside) + " of the skeleton's " +
        std::to_string(joints.rows()) +
        " joints lie outside of the mesh; both must be in one place, with one way up: of a "
        "skeleton whose file has y up say so (--skeleton_up y)";
}

void WarnOfPlace(LoadedPuppet& puppet) {
  PointsX3 joints(puppet.parts.skeleton.size(), 3);
  for (int j = 0; j < joints.rows(); ++j) joints.row(j) = puppet.parts.skeleton.joints[j].rest;
  const double ratio =
      BoundingDiagonal(puppet.parts.mesh.points) / std::max(BoundingDiagonal(joints), 1e-300);
  if (ratio > 3 || ratio < 1.0 / 3)
    puppet.misplaced =
        "the mesh is " + std::to_string(ratio) +
        " times as large as the skeleton; both must be in one unit, and in one place";
  else
    CheckPlaces(joints, puppet);
  if (!puppet.misplaced.empty()) puppet.warnings.push_back(puppet.misplaced);
}

void LoadWeights(const PuppetPaths& paths, LoadedPuppet& puppet) {
  PuppetParts& parts = puppet.parts;
  if (!paths.weights.empty()) {
    std::vector<std::string> names;
    for (const SkeletonJoint& joint : parts.skeleton.joints) names.push_back(joint.name);
    parts.weights = ParseWeights(ReadFile(paths.weights), PrintableName(paths.weights.filename()),
                                 names, LeadingBones(parts.skeleton), parts.mesh.vertex_count());
    return;
  }
  const BoneHeat heat = HeatWeights(parts.mesh, SkinBonesOf(parts.skeleton));
  puppet.notes.push_back("weights by heat: " + std::to_string(heat.seeing) + " of " +
                         std::to_string(parts.mesh.vertex_count()) +
                         " vertices see their nearest bone");
  if (heat.blind_parts > 0)
    puppet.warnings.push_back(
        std::to_string(heat.blind_parts) +
        " separate parts of the mesh have no bone inside; they follow their nearest bones");
  parts.weights = heat.weights;
}

}  // namespace

LoadedPuppet LoadPuppet(const PuppetPaths& paths, const PuppetChoices& choices) {
  LoadedPuppet puppet;
  PuppetParts& parts = puppet.parts;
  parts.armature =
      DescriptionFile::Parse(ReadFile(paths.description), PrintableName(paths.description))
          .armature();
  parts.plan = ParseChains(ReadFile(paths.chains), PrintableName(paths.chains), parts.armature);
  parts.options = OptionsOf(choices);
  LoadSkeleton(paths.skeleton, choices, parts);
  if (paths.mesh.empty()) {
    if (!paths.weights.empty())
      throw UsageError("armature: weights are those of a mesh; give --mesh too");
    StickFigure figure = MakeStickFigure(SkinBonesOf(parts.skeleton));
    parts.mesh = std::move(figure.mesh);
    parts.weights = std::move(figure.weights);
    return puppet;
  }
  parts.mesh = ReadMesh(paths.mesh);
  RequireUsable(parts.mesh, "armature: " + PrintableName(paths.mesh.filename()));
  WarnOfPlace(puppet);
  LoadWeights(paths, puppet);
  return puppet;
}

namespace {

constexpr int kPlainWidth = 960, kPlainHeight = 540, kMostViews = 100000;

/// A view of the whole puppet, with room for its motion.
PlateView PlainView(const PointsX3& rest, int width, int height) {
  PlateView plain;
  PointsX3 around(2, 3);
  const Eigen::RowVector3d low = rest.colwise().minCoeff(), high = rest.colwise().maxCoeff();
  const Eigen::RowVector3d room = 0.15 * (high - low);
  around << low - room, high + room;
  plain.view = FitView(around, 60, 12, width, height);
  return plain;
}

/// The located frame that is nearest to a frame of the film; of two the earlier.
const ShotFrame& LocatedNear(const FilmedShot& shot, int frame) {
  return *std::min_element(shot.frames.begin(), shot.frames.end(),
                           [&](const ShotFrame& a, const ShotFrame& b) {
                             return std::abs(a.frame - frame) < std::abs(b.frame - frame);
                           });
}

/// The frames of the film for which there are views: one does for a shot that was located once.
std::vector<int> ViewedFrames(const FilmedShot& shot, const std::vector<FilmPicture>& plates) {
  if (shot.frames.size() == 1) return {0};
  std::vector<int> numbers;
  if (plates.size() > 1)
    for (const FilmPicture& plate : plates) numbers.push_back(plate.frame);
  const int last = std::min(shot.frames.back().frame, kMostViews);
  for (int n = numbers.empty() ? 0 : numbers.back() + 1; n <= last; ++n) numbers.push_back(n);
  return numbers;
}

std::vector<PlateView> ShotViews(const FilmedShot& shot, const std::vector<FilmPicture>& plates) {
  std::vector<PlateView> views;
  for (const int number : ViewedFrames(shot, plates)) {
    const ShotFrame& frame = LocatedNear(shot, number);
    PlateView view;
    view.view.camera = shot.camera;
    view.view.camera_from_world = frame.camera_from_world;
    view.world_from_character = frame.world_from_character;
    views.push_back(view);
  }
  return views;
}

}  // namespace

PlateFiles::PlateFiles(const fs::path& plate, const fs::path& shot, const PointsX3& rest) {
  std::vector<FilmPicture> pictures;
  if (!plate.empty()) pictures = FilmPictures(plate);
  for (const FilmPicture& picture : pictures) plates_.push_back(picture.path);
  if (!shot.empty()) {
    views_ = ShotViews(ReadShot(shot), pictures);
  } else {
    const ImageInfo info = plates_.empty() ? ImageInfo{} : ReadImageInfo(plates_.front());
    views_.push_back(PlainView(rest, plates_.empty() ? kPlainWidth : info.width,
                               plates_.empty() ? kPlainHeight : info.height));
  }
  count_ = std::max({1, SizeOf(plates_), SizeOf(views_)});
  for (const fs::path& path : plates_) {
    const ImageInfo info = ReadImageInfo(path);
    const Camera& camera = views_.front().view.camera;
    if (info.width != camera.width || info.height != camera.height)
      throw InputError("armature: " + PrintableName(path.filename()) + " has " +
                       std::to_string(info.width) + " x " + std::to_string(info.height) +
                       " pixels, but the camera " + std::to_string(camera.width) + " x " +
                       std::to_string(camera.height) +
                       "; all plates of a shot must have the size that its camera was found with");
  }
}

PlateView PlateFiles::Read(int index) const {
  PlateView view = views_[std::clamp(index, 0, SizeOf(views_) - 1)];
  if (!plates_.empty())
    view.plate = ReadImage(plates_[std::clamp(index, 0, SizeOf(plates_) - 1)], 3);
  return view;
}

}  // namespace keypose::armature
