#include "reconstruct/sfm/posed_model.h"

#include <Eigen/LU>
#include <algorithm>
#include <cmath>
#include <map>
#include <nlohmann/json.hpp>
#include <set>

#include "core/angles.h"
#include "core/errors.h"
#include "core/io/image_set.h"
#include "core/io/poses_io.h"
#include "core/parallel.h"
#include "reconstruct/known/known_cameras.h"
#include "reconstruct/matching/guided_matching.h"
#include "reconstruct/sfm/evidence_check.h"
#include "reconstruct/turntable/leveling.h"
#include "views/hull/silhouettes.h"

namespace keypose::reconstruct {
using nlohmann::json;

namespace {

BundleOptions BundleOf(const SfmOptions& options, bool with_plate, bool calibrate) {
  BundleOptions bundle;
  bundle.refine_principal_point = options.refine_principal_point || calibrate;
  bundle.refine_distortion = options.refine_distortion;
  // for a plane seen at one tilt, any aspect ratio fits with another distance
  bundle.keep_aspect = with_plate;
  return bundle;
}

/// Whether cameras look down on the board at angles that differ by 15 degrees or more. A single
/// ring of views rotates the board about its normal only, which determines the focal length and no
/// other parameter (Zhang, TPAMI 2000, section 4).
bool SeenUnderSeveralTilts(const Scene& scene) {
  constexpr double kLeast_deg = 15;
  std::vector<double> tilts;
  for (const View& view : scene.views) {
    const Eigen::Vector3d forward =
        view.camera_from_world.rotation.conjugate() * Eigen::Vector3d::UnitZ();
    tilts.push_back(std::asin(std::clamp(-forward.z(), -1.0, 1.0)) / kDegree);
  }
  if (tilts.size() < 8) return false;
  std::sort(tilts.begin(), tilts.end());
  return tilts[tilts.size() * 9 / 10] - tilts[tilts.size() / 10] >= kLeast_deg;
}

Rigid3 RigidOf(const Similarity3& similarity) {
  return {Eigen::Quaterniond(similarity.rotation), similarity.translation};
}

void Append(std::vector<View>& views, const Scene& scene) {
  std::set<std::string> there;
  for (const View& view : views) there.insert(view.name);
  for (const View& view : scene.views)
    if (!there.contains(view.name)) views.push_back(view);
  std::sort(views.begin(), views.end(),
            [](const View& a, const View& b) { return a.name < b.name; });
}

/// Sets the first view's camera in all views: the sets were shot with one camera.
void ShareCamera(std::vector<View>& views, const Camera& camera) {
  for (View& view : views) view.camera = camera;
}

PosedModel Triangulated(StageContext& stage, const ImageSet& set, const SfmFiles& files,
                        const std::vector<Features>& features, const std::vector<View>& views,
                        const std::string& name, const SfmOptions& options) {
  ColmapModel triangulated = TriangulateKnown(stage, set, files, views, name, options);
  PosedModel model;
  model.observations = ObservationsOf(triangulated, set, features);
  model.scene = std::move(triangulated.scene);
  return model;
}

/// Boards of all groups in a scene, if enough views show them.
Bodies BodiesOf(const Scene& scene, const ImageSet& set, const SetBoards& boards,
                const std::vector<Rigid3>& world_from_board, const SfmOptions& options) {
  Bodies bodies;
  bodies.world_from_body = world_from_board;
  for (std::size_t g = 0; g < boards.groups.size(); ++g) {
    const auto observations = BoardObservations(scene, *set.board, boards.groups[g].sightings,
                                                static_cast<int>(g), options.min_board_corners);
    bodies.observations.insert(bodies.observations.end(), observations.begin(), observations.end());
  }
  return bodies;
}

/// Fundamental matrix of two views: x_second^T F x_first = 0, in pixels.
Eigen::Matrix3d Fundamental(const View& first, const View& second) {
  const Rigid3 second_from_first =
      Compose(second.camera_from_world, first.camera_from_world.Inverse());
  const Eigen::Vector3d t = second_from_first.translation;
  Eigen::Matrix3d cross;
  cross << 0, -t.z(), t.y(), t.z(), 0, -t.x(), -t.y(), t.x(), 0;
  return second.camera.K().inverse().transpose() * cross *
         second_from_first.rotation.toRotationMatrix() * first.camera.K().inverse();
}

/// Matches features of two placements along the epipolar lines of their joined cameras, and writes
/// the matches to the database. These matches connect the two models in the adjustment.
void MatchAcross(const ImageSet& set, const SfmFiles& files, const std::vector<Features>& features,
                 const std::vector<View>& first, const std::vector<View>& second,
                 const SfmOptions& options, Measurements& measurements) {
  constexpr double kWidest_deg = 50, kMaxError_px = 3;
  std::vector<std::pair<const View*, const View*>> pairs;
  for (const View& a : first)
    for (const View& b : second) {
      const Eigen::Vector3d x = a.camera_from_world.rotation.conjugate() * Eigen::Vector3d::UnitZ(),
                            y = b.camera_from_world.rotation.conjugate() * Eigen::Vector3d::UnitZ();
      if (a.name == b.name || x.dot(y) < std::cos(kWidest_deg * kDegree)) continue;
      if (set.Find(a.name) < set.Find(b.name))
        pairs.emplace_back(&a, &b);
      else
        pairs.emplace_back(&b, &a);
    }
  std::vector<PairMatches> found(pairs.size());
  MatchOptions matching;
  matching.max_ratio = options.max_ratio;
  ParallelFor(static_cast<std::int64_t>(pairs.size()), [&](std::int64_t k) {
    const auto& [a, b] = pairs[k];
    PairMatches& pair = found[k];
    pair.first = set.Find(a->name);
    pair.second = set.Find(b->name);
    const PairGeometry geometry{PairGeometry::kFundamental, Fundamental(*a, *b)};
    pair.features =
        MatchGuided(features[pair.first], features[pair.second], geometry, matching, kMaxError_px);
  });
  std::erase_if(found, [&](const PairMatches& pair) {
    return static_cast<int>(pair.features.size()) < options.min_inliers;
  });
  int count = 0;
  for (const PairMatches& pair : found) count += static_cast<int>(pair.features.size());
  ColmapDatabase(files.database).PutInliers(found);
  measurements.Add("matches_across", count);
}

void Measure(StageContext& stage, const std::string& name, const ModelAlignment& join,
             Measurements& measurements) {
  stage.Note("sfm: " + name + ": " + std::to_string(join.agreeing) + " of " +
             std::to_string(join.pairs) + " pairs of points agree" +
             (join.found ? "" : ", which are too few to join the models"));
  measurements.AddJson("join_" + name, json{{"pairs", join.pairs},
                                            {"agreeing", join.agreeing},
                                            {"rms", join.rms},
                                            {"miss_px", join.miss_px},
                                            {"rival_miss_px", join.rival_miss_px},
                                            {"found", join.found}}
                                           .dump());
}

}  // namespace

BundleOptions BundleFor(const PosedModel& model, const SfmOptions& options) {
  return BundleOf(options, !model.bodies.observations.empty(), model.calibrate);
}

int SetBoards::views() const {
  int count = 0;
  for (const Group& group : groups) count += static_cast<int>(group.poses.scene.views.size());
  return count;
}

SetBoards PlaceBoards(StageContext& stage, const ImageSet& set, const Camera& camera,
                      bool focal_known, const SfmOptions& options) {
  std::map<std::string, SetBoards::Group> by_name;
  for (const CapturedImage& image : set.images) {
    SetBoards::Group& group = by_name[image.group];
    group.name = image.group;
    group.images.push_back(image.name);
    if (!image.board_corners.empty()) group.sightings.push_back({image.name, image.board_corners});
  }
  SetBoards boards;
  if (const auto upright = by_name.find("upright"); upright != by_name.end()) {
    boards.groups.push_back(std::move(upright->second));
    by_name.erase(upright);
  }
  for (auto& [name, group] : by_name) boards.groups.push_back(std::move(group));
  if (!set.board || !options.board) return boards;
  BoardPosesOptions placing;
  placing.min_corners = options.min_board_corners;
  placing.bundle = BundleOf(options, true, false);
  Camera start = camera;
  bool known = focal_known;
  json rejected = json::array();
  double sum = 0, corners = 0;
  for (SetBoards::Group& group : boards.groups) {
    group.poses = PlaceByBoard(start, known, *set.board, group.sightings, placing);
    if (!boards.calibrate && SeenUnderSeveralTilts(group.poses.scene)) {
      boards.calibrate = true;
      placing.bundle = BundleOf(options, true, true);
      group.poses = PlaceByBoard(start, known, *set.board, group.sightings, placing);
    }
    for (const std::string& name : group.poses.rejected) rejected.push_back(name);
    if (group.poses.scene.views.size() >= 3)
      start = group.poses.scene.views[0].camera, known = true;
    const auto count = static_cast<double>(group.poses.bodies.observations.size());
    sum += group.poses.rms_px * group.poses.rms_px * count;
    corners += count;
  }
  stage.Report("board_views", boards.views());
  stage.Report("board_rms_px", corners > 0 ? std::sqrt(sum / corners) : 0.0);
  stage.ReportJson("board_rejected", rejected.dump());
  return boards;
}

PosedModel ModelFromPoses(StageContext& stage, const ImageSet& set, const SfmFiles& files,
                          const std::vector<Features>& features, const SfmOptions& options,
                          Measurements& measurements) {
  Camera photograph;
  photograph.width = set.images[0].width;
  photograph.height = set.images[0].height;
  std::vector<std::string> names;
  for (const CapturedImage& image : set.images) names.push_back(image.name);
  const std::vector<View> views =
      MatchKnownPoses(ReadPoses(stage.Input("poses")), names, photograph);
  measurements.Add("known_poses", static_cast<int>(views.size()));
  PosedModel model = Triangulated(stage, set, files, features, views, "poses", options);
  model.scale_source = "poses";
  model.fixed = !options.refine_poses;
  return model;
}

namespace {

/// One placement's model in its own board's frame.
struct Half {
  ColmapModel raw;  ///< as triangulated
  Scene adjusted;   ///< without its wrong points
};

Half HalfOf(StageContext& stage, const ImageSet& set, const SfmFiles& files,
            const MatchedFeatures& matched, const SetBoards& boards, std::size_t g,
            const SfmOptions& options) {
  const SetBoards::Group& group = boards.groups[g];
  Half half;
  half.raw = TriangulateKnown(stage, set, files, group.poses.scene.views,
                              "group" + std::to_string(g), options);
  Bodies bodies;
  bodies.world_from_body = {Rigid3{}};
  bodies.observations =
      BoardObservations(half.raw.scene, *set.board, group.sightings, 0, options.min_board_corners);
  half.adjusted = AdjustBundle(half.raw.scene, ObservationsOf(half.raw, set, matched.features),
                               BundleOf(options, true, boards.calibrate), stage.progress(), bodies)
                      .scene;
  // Photographs of other placements that COLMAP added because of false matches are placed with
  // their own group.
  std::erase_if(half.adjusted.views, [&](const View& view) {
    return std::find(group.images.begin(), group.images.end(), view.name) == group.images.end();
  });
  return half;
}

/// A mapper's model, adjusted and without its wrong points.
Scene AdjustedModel(StageContext& stage, const ImageSet& set, const MatchedFeatures& matched,
                    const ColmapModel& model, const SfmOptions& options) {
  BundleOptions bundle = BundleOf(options, false, false);
  bundle.keep_aspect = true;
  return AdjustBundle(model.scene, ObservationsOf(model, set, matched.features), bundle,
                      stage.progress())
      .scene;
}

/// The placement with most of a scene's photographs.
std::string PlacementOf(const ImageSet& set, const Scene& scene) {
  std::map<std::string, int> count;
  for (const View& view : scene.views) ++count[set.images[set.Find(view.name)].group];
  return std::max_element(count.begin(), count.end(),
                          [](const auto& a, const auto& b) { return a.second < b.second; })
      ->first;
}

/// Aligns non-metric models of two placements by outlines, shape and colour. When a figure is
/// turned over under fixed light, all its features change.
ModelAlignment JoinPlacements(StageContext& stage, const ImageSet& set, const std::string& name,
                              const Scene& first, const Scene& second, Measurements& measurements) {
  const std::vector<PreparedView> first_views = MaskViews(set, first),
                                  second_views = MaskViews(set, second);
  if (first_views.size() < 3 || second_views.size() < 3) return {};
  const Silhouettes first_masks(first_views, 1), second_masks(second_views, 1);
  const HalfOutlines outlines{first_masks, second_masks};
  const ModelAlignment join = AlignByOutlines(first, second, outlines, OutlineAlignmentOptions{});
  Measure(stage, name + "_by_outlines", join, measurements);
  return join;
}

/// Aligns by matches, else by shape and colour.
ModelAlignment JoinHalves(StageContext& stage, const std::string& name, const Half& first,
                          const Half& second, const MatchedFeatures& matched, bool& by_shape,
                          Measurements& measurements) {
  AlignmentOptions options;
  options.with_scale = false;
  ModelAlignment join =
      AlignModels(first.raw.scene, second.raw.scene,
                  MatchPoints(first.raw.tracks, second.raw.tracks, matched.matches), options);
  Measure(stage, name, join, measurements);
  if (join.found) return join;
  join = AlignByShape(first.adjusted, second.adjusted, ShapeAlignmentOptions{});
  by_shape |= join.found;
  Measure(stage, name + "_by_shape", join, measurements);
  return join;
}

}  // namespace

std::optional<PosedModel> ModelFromBoards(StageContext& stage, const ImageSet& set,
                                          const SfmFiles& files, const MatchedFeatures& matched,
                                          const SetBoards& boards, const SfmOptions& options,
                                          Measurements& measurements) {
  const auto enough = [&](const SetBoards::Group& group) {
    return group.poses.scene.views.size() >= 3 &&
           static_cast<double>(group.poses.scene.views.size()) >=
               options.min_placed * static_cast<double>(group.images.size());
  };
  if (boards.groups.empty() || !enough(boards.groups[0])) return std::nullopt;
  std::vector<View> views = boards.groups[0].poses.scene.views;
  std::vector<Rigid3> world_from_board(boards.groups.size());
  std::vector<char> joined(boards.groups.size(), 0);
  bool by_shape = false;
  if (boards.groups.size() > 1) {
    const Half first = HalfOf(stage, set, files, matched, boards, 0, options);
    views = first.adjusted.views;
    for (std::size_t g = 1; g < boards.groups.size(); ++g) {
      if (!enough(boards.groups[g])) continue;  // its photographs may still be placed one by one
      const Half other = HalfOf(stage, set, files, matched, boards, g, options);
      const ModelAlignment join =
          JoinHalves(stage, boards.groups[g].name, first, other, matched, by_shape, measurements);
      if (!join.found) continue;
      world_from_board[g] = RigidOf(join.first_from_second);
      joined[g] = 1;
      const Scene moved = Transformed(join.first_from_second, other.adjusted);
      // Models that share no features are only joined by shape. The few matches along epipolar
      // lines are then false, and would rotate the models against each other by half a degree.
      if (!by_shape)
        MatchAcross(set, files, matched.features, first.adjusted.views, moved.views, options,
                    measurements);
      Append(views, moved);
    }
  }
  ShareCamera(views, Camera(views[0].camera));
  PosedModel model = Triangulated(stage, set, files, matched.features, views, "boards", options);
  // The board of a group that was not joined has no known pose.
  SetBoards known = boards;
  for (std::size_t g = 1; g < known.groups.size(); ++g)
    if (!joined[g]) known.groups[g].sightings.clear();
  model.bodies = BodiesOf(model.scene, set, known, world_from_board, options);
  model.bodies.fixed = by_shape;
  model.scale_source = "plate";
  model.calibrate = boards.calibrate;
  return model;
}

namespace {

/// Views of the mapper's largest model and of all models joined with it.
std::vector<View> JoinedViews(StageContext& stage, const ImageSet& set, const SfmFiles& files,
                              const MatchedFeatures& matched,
                              const std::vector<ColmapModel>& models, const SfmOptions& options,
                              Measurements& measurements) {
  const ColmapModel& first = models[0];
  std::vector<View> views = first.scene.views;
  if (views.size() == set.images.size()) return views;
  std::set<std::string> placements{PlacementOf(set, first.scene)};
  for (std::size_t m = 1; m < models.size(); ++m) {
    const std::string name = "model" + std::to_string(m);
    const ColmapModel& other = models[m];
    ModelAlignment join =
        AlignModels(first.scene, other.scene,
                    MatchPoints(first.tracks, other.tracks, matched.matches), AlignmentOptions{});
    Measure(stage, name, join, measurements);
    const std::string placement = PlacementOf(set, other.scene);
    if (join.found) {
      const Scene moved = Transformed(join.first_from_second, other.scene);
      MatchAcross(set, files, matched.features, views, moved.views, options, measurements);
      Append(views, moved);
    } else if (!placements.contains(placement)) {
      const Scene first_half = AdjustedModel(stage, set, matched, first, options),
                  other_half = AdjustedModel(stage, set, matched, other, options);
      join = JoinPlacements(stage, set, name, first_half, other_half, measurements);
      if (!join.found) continue;
      // Both as adjusted, since the alignment is between these.
      if (views.size() == first.scene.views.size()) views = first_half.views;
      Append(views, Transformed(join.first_from_second, other_half));
    }
    if (join.found) placements.insert(placement);
  }
  return views;
}

}  // namespace

PosedModel ModelFromMapper(StageContext& stage, const ImageSet& set, const SfmFiles& files,
                           const MatchedFeatures& matched, const std::vector<ColmapModel>& models,
                           const SetBoards& boards, const SfmOptions& options,
                           Measurements& measurements) {
  PosedModel model;
  model.scale_source = "none";
  if (models.empty()) return model;
  const ColmapModel& first = models[0];
  std::vector<View> views = JoinedViews(stage, set, files, matched, models, options, measurements);
  if (views.size() > first.scene.views.size()) {
    ShareCamera(views, first.scene.views[0].camera);
    model = Triangulated(stage, set, files, matched.features, views, "joined", options);
    model.scale_source = "none";
  } else {
    model.scene = first.scene;
    model.observations = ObservationsOf(first, set, matched.features);
  }
  if (boards.groups.empty() || boards.groups[0].poses.scene.views.size() < 3) return model;
  try {
    model.scene =
        Transformed(BoardFromScene(boards.groups[0].poses.scene, model.scene), model.scene);
  } catch (const InputError& error) {
    stage.Note(error.what());
    return model;
  }
  SetBoards first_only = boards;
  first_only.groups.resize(1);
  model.bodies = BodiesOf(model.scene, set, first_only, {Rigid3{}}, options);
  model.scale_source = "plate";
  model.calibrate = boards.calibrate;
  return model;
}

}  // namespace keypose::reconstruct
