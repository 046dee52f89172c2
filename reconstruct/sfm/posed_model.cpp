#include "reconstruct/sfm/posed_model.h"

#include <Eigen/LU>
#include <algorithm>
#include <cmath>
#include <iterator>
#include <map>
#include <nlohmann/json.hpp>
#include <set>

#include "core/io/pictures/image_set.h"
#include "core/io/project/poses_io.h"
#include "core/numbers/parallel.h"
#include "core/numbers/statistics.h"
#include "core/values/angles.h"
#include "core/values/errors.h"
#include "core/values/size_of.h"
#include "core/values/tuned.h"
#include "reconstruct/known/known_cameras.h"
#include "reconstruct/matching/guided_matching.h"
#include "reconstruct/sfm/evidence_check.h"
#include "reconstruct/turntable/leveling.h"
#include "views/hull/silhouettes.h"

namespace keypose::reconstruct {
using nlohmann::json;

namespace {

// No record of the data. Sensitivity: docs/results/sensitivity.md.
struct PosedModelTuning {
  // between the tilts of a board's views, from which the principal point is solved for
  KEYPOSE_TUNED(double, kTilts_deg, 15);
  // matches across placements: between the views' directions, and from the epipolar line
  KEYPOSE_TUNED(double, kWidest_deg, 50);
  KEYPOSE_TUNED(double, kMaxError_px, 3);
};

BundleOptions BundleOf(const SfmOptions& options, bool with_board, bool calibrate) {
  BundleOptions bundle;
  bundle.refine_principal_point = options.refine_principal_point || calibrate;
  bundle.refine_distortion = options.refine_distortion;
  // for a plane seen at one tilt, any aspect ratio fits with another distance
  bundle.keep_aspect = with_board;
  return bundle;
}

/// Whether cameras look down on the board at angles that differ by kTilts_deg or more. A single
/// ring of views rotates the board about its normal only, which determines the focal length and no
/// other parameter (Zhang, TPAMI 2000, section 4).
bool SeenUnderSeveralTilts(const Scene& scene) {
  std::vector<double> tilts;
  for (const View& view : scene.views) {
    const Eigen::Vector3d forward =
        view.camera_from_world.rotation.conjugate() * Eigen::Vector3d::UnitZ();
    tilts.push_back(std::asin(std::clamp(-forward.z(), -1.0, 1.0)) / kDegree);
  }
  if (tilts.size() < 8) return false;
  return QuantileAbove(tilts, 0.9) - QuantileAbove(tilts, 0.1) >= PosedModelTuning::kTilts_deg;
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

/// Gives all views of one lens the camera of the first of them, those in `first` before others.
void ShareCameras(const ModelInput& in, const std::vector<View>& first, std::vector<View>& views) {
  std::map<int, Camera> of_lens;
  const auto lens_of = [&](const View& view) {
    return in.matched.lens_of_image[static_cast<std::size_t>(in.set.Find(view.name))];
  };
  for (const View& view : first) of_lens.try_emplace(lens_of(view), view.camera);
  for (View& view : views)
    view.camera = of_lens.try_emplace(lens_of(view), view.camera).first->second;
}

PosedModel Triangulated(const ModelInput& in, const std::vector<View>& views,
                        const std::string& name) {
  ColmapModel triangulated = TriangulateKnown(in.stage, in.set, in.files, views, name, in.options);
  PosedModel model;
  model.observations = ObservationsOf(triangulated, in.set, in.matched.features);
  model.scene = std::move(triangulated.scene);
  return model;
}

/// Boards of all groups in a scene, if enough views show them.
Bodies BodiesOf(const ModelInput& in, const Scene& scene, const SetBoards& boards,
                const std::vector<Rigid3>& world_from_board) {
  Bodies bodies;
  bodies.world_from_body = world_from_board;
  for (std::size_t g = 0; g < boards.groups.size(); ++g) {
    const auto observations = BoardObservations(scene, *in.set.board, boards.groups[g].sightings,
                                                static_cast<int>(g), in.options.min_board_corners);
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
void MatchAcross(const ModelInput& in, const std::vector<View>& first,
                 const std::vector<View>& second) {
  std::vector<std::pair<const View*, const View*>> pairs;
  for (const View& a : first)
    for (const View& b : second) {
      const Eigen::Vector3d x = a.camera_from_world.rotation.conjugate() * Eigen::Vector3d::UnitZ(),
                            y = b.camera_from_world.rotation.conjugate() * Eigen::Vector3d::UnitZ();
      if (a.name == b.name || x.dot(y) < std::cos(PosedModelTuning::kWidest_deg * kDegree))
        continue;
      if (in.set.Find(a.name) < in.set.Find(b.name))
        pairs.emplace_back(&a, &b);
      else
        pairs.emplace_back(&b, &a);
    }
  std::vector<PairMatches> found(pairs.size());
  MatchOptions matching;
  matching.max_ratio = in.options.max_ratio;
  ParallelFor(std::ssize(pairs), [&](std::int64_t k) {
    const auto& [a, b] = pairs[k];
    PairMatches& pair = found[k];
    pair.first = in.set.Find(a->name);
    pair.second = in.set.Find(b->name);
    const PairGeometry geometry{PairGeometry::kFundamental, Fundamental(*a, *b)};
    pair.features = MatchGuided(in.matched.features[pair.first], in.matched.features[pair.second],
                                geometry, matching, PosedModelTuning::kMaxError_px);
  });
  std::erase_if(found, [&](const PairMatches& pair) {
    return SizeOf(pair.features) < in.options.min_inliers;
  });
  int count = 0;
  for (const PairMatches& pair : found) count += SizeOf(pair.features);
  ColmapDatabase(in.files.database).PutInliers(found);
  in.measurements.Add("matches_across", count);
}

void Measure(const ModelInput& in, const std::string& name, const ModelAlignment& join) {
  in.stage.Note("sfm: " + name + ": " + std::to_string(join.agreeing) + " of " +
                std::to_string(join.pairs) + " pairs of points agree" +
                (join.found ? "" : ", which are too few to join the models"));
  in.measurements.AddJson("join_" + name, json{{"pairs", join.pairs},
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
  for (const Group& group : groups) count += SizeOf(group.poses.scene.views);
  return count;
}

namespace {

/// Lenses of which three photographs or more are placed start from there in other placements.
void LearnLenses(const BoardPoses& poses, const std::vector<BoardSighting>& sightings,
                 std::vector<BoardLens>& lenses) {
  std::vector<std::vector<const View*>> views(lenses.size());
  for (const View& view : poses.scene.views)
    for (const BoardSighting& sighting : sightings)
      if (sighting.name == view.name) views[sighting.lens].push_back(&view);
  for (std::size_t l = 0; l < lenses.size(); ++l)
    if (views[l].size() >= 3) lenses[l] = {views[l][0]->camera, true};
}

/// The placements, "upright" first, with what their photographs show of the board.
std::vector<SetBoards::Group> PlacementsOf(const ImageSet& set, const MatchedFeatures& matched) {
  std::map<std::string, SetBoards::Group> by_name;
  for (std::size_t i = 0; i < set.images.size(); ++i) {
    const CapturedImage& image = set.images[i];
    SetBoards::Group& group = by_name[image.group];
    group.name = image.group;
    group.images.push_back(image.name);
    if (!image.board_corners.empty())
      group.sightings.push_back({image.name, image.board_corners, matched.lens_of_image[i]});
  }
  std::vector<SetBoards::Group> groups;
  if (const auto upright = by_name.find("upright"); upright != by_name.end()) {
    groups.push_back(std::move(upright->second));
    by_name.erase(upright);
  }
  for (auto& [name, group] : by_name) groups.push_back(std::move(group));
  return groups;
}

}  // namespace

SetBoards PlaceBoards(StageContext& stage, const ImageSet& set, const MatchedFeatures& matched,
                      const SfmOptions& options) {
  SetBoards boards;
  boards.groups = PlacementsOf(set, matched);
  if (!set.board || !options.board) return boards;
  BoardPosesOptions placing;
  placing.min_corners = options.min_board_corners;
  placing.bundle = BundleOf(options, true, false);
  std::vector<BoardLens> lenses;
  for (const Camera& lens : matched.lenses) lenses.push_back({lens, matched.focal_known});
  json rejected = json::array();
  double sum = 0, corners = 0;
  for (SetBoards::Group& group : boards.groups) {
    group.poses = PlaceByBoard(lenses, *set.board, group.sightings, placing);
    if (!boards.calibrate && SeenUnderSeveralTilts(group.poses.scene)) {
      boards.calibrate = true;
      placing.bundle = BundleOf(options, true, true);
      group.poses = PlaceByBoard(lenses, *set.board, group.sightings, placing);
    }
    for (const std::string& name : group.poses.rejected) rejected.push_back(name);
    LearnLenses(group.poses, group.sightings, lenses);
    const auto count = static_cast<double>(group.poses.bodies.observations.size());
    sum += group.poses.rms_px * group.poses.rms_px * count;
    corners += count;
  }
  stage.Report("board_views", boards.views());
  stage.Report("board_rms_px", corners > 0 ? std::sqrt(sum / corners) : 0.0);
  stage.ReportJson("board_rejected", rejected.dump());
  return boards;
}

std::vector<View> KnownViews(StageContext& stage, const ImageSet& set) {
  std::vector<std::string> names;
  std::vector<Camera> sizes;
  for (const CapturedImage& image : set.images) {
    names.push_back(image.name);
    sizes.emplace_back();
    sizes.back().width = image.width;
    sizes.back().height = image.height;
  }
  return MatchKnownPoses(ReadPoses(stage.Input("poses")), names, sizes);
}

PosedModel ModelFromPoses(const ModelInput& in) {
  const std::vector<View> views = KnownViews(in.stage, in.set);
  in.measurements.Add("known_poses", SizeOf(views));
  PosedModel model = Triangulated(in, views, "poses");
  model.scale_source = "poses";
  model.fixed = !in.options.refine_poses;
  return model;
}

namespace {

/// One placement's model in its own board's frame.
struct Half {
  ColmapModel raw;  ///< as triangulated
  Scene adjusted;   ///< without its wrong points
};

Half HalfOf(const ModelInput& in, const SetBoards& boards, std::size_t g) {
  const SetBoards::Group& group = boards.groups[g];
  Half half;
  half.raw = TriangulateKnown(in.stage, in.set, in.files, group.poses.scene.views,
                              "group" + std::to_string(g), in.options);
  Bodies bodies;
  bodies.world_from_body = {Rigid3{}};
  bodies.observations = BoardObservations(half.raw.scene, *in.set.board, group.sightings, 0,
                                          in.options.min_board_corners);
  half.adjusted =
      AdjustBundle(half.raw.scene, ObservationsOf(half.raw, in.set, in.matched.features),
                   BundleOf(in.options, true, boards.calibrate), in.stage.progress(), bodies)
          .scene;
  // Photographs of other placements that COLMAP added because of false matches are placed with
  // their own group.
  std::erase_if(half.adjusted.views, [&](const View& view) {
    return std::find(group.images.begin(), group.images.end(), view.name) == group.images.end();
  });
  return half;
}

/// A mapper's model, adjusted and without its wrong points.
Scene AdjustedModel(const ModelInput& in, const ColmapModel& model) {
  BundleOptions bundle = BundleOf(in.options, false, false);
  bundle.keep_aspect = true;
  return AdjustBundle(model.scene, ObservationsOf(model, in.set, in.matched.features), bundle,
                      in.stage.progress())
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
ModelAlignment JoinPlacements(const ModelInput& in, const std::string& name, const Scene& first,
                              const Scene& second) {
  const std::vector<PreparedView> first_views = MaskViews(in.set, first),
                                  second_views = MaskViews(in.set, second);
  if (first_views.size() < 3 || second_views.size() < 3) return {};
  const Silhouettes first_masks(first_views, 1), second_masks(second_views, 1);
  const HalfOutlines outlines{first_masks, second_masks};
  const ModelAlignment join = AlignByOutlines(first, second, outlines, OutlineAlignmentOptions{});
  Measure(in, name + "_by_outlines", join);
  return join;
}

/// Aligns by matches, else by shape and colour.
ModelAlignment JoinHalves(const ModelInput& in, const std::string& name, const Half& first,
                          const Half& second, bool& by_shape) {
  AlignmentOptions options;
  options.with_scale = false;
  ModelAlignment join =
      AlignModels(first.raw.scene, second.raw.scene,
                  MatchPoints(first.raw.tracks, second.raw.tracks, in.matched.matches), options);
  Measure(in, name, join);
  if (join.found) return join;
  join = AlignByShape(first.adjusted, second.adjusted, ShapeAlignmentOptions{});
  by_shape |= join.found;
  Measure(in, name + "_by_shape", join);
  return join;
}

}  // namespace

std::optional<PosedModel> ModelFromBoards(const ModelInput& in, const SetBoards& boards) {
  const auto enough = [&](const SetBoards::Group& group) {
    return group.poses.scene.views.size() >= 3 &&
           static_cast<double>(group.poses.scene.views.size()) >=
               in.options.min_placed * static_cast<double>(group.images.size());
  };
  if (boards.groups.empty() || !enough(boards.groups[0])) return std::nullopt;
  std::vector<View> views = boards.groups[0].poses.scene.views;
  std::vector<Rigid3> world_from_board(boards.groups.size());
  std::vector<char> joined(boards.groups.size(), 0);
  bool by_shape = false;
  if (boards.groups.size() > 1) {
    const Half first = HalfOf(in, boards, 0);
    views = first.adjusted.views;
    for (std::size_t g = 1; g < boards.groups.size(); ++g) {
      if (!enough(boards.groups[g])) continue;  // its photographs may still be placed one by one
      const Half other = HalfOf(in, boards, g);
      const ModelAlignment join = JoinHalves(in, boards.groups[g].name, first, other, by_shape);
      if (!join.found) continue;
      world_from_board[g] = RigidOf(join.first_from_second);
      joined[g] = 1;
      const Scene moved = Transformed(join.first_from_second, other.adjusted);
      // Models that share no features are only joined by shape. The few matches along epipolar
      // lines are then false, and would rotate the models against each other by half a degree.
      if (!by_shape) MatchAcross(in, first.adjusted.views, moved.views);
      Append(views, moved);
    }
  }
  ShareCameras(in, {}, views);
  PosedModel model = Triangulated(in, views, "boards");
  // The board of a group that was not joined has no known pose.
  SetBoards known = boards;
  for (std::size_t g = 1; g < known.groups.size(); ++g)
    if (!joined[g]) known.groups[g].sightings.clear();
  model.bodies = BodiesOf(in, model.scene, known, world_from_board);
  model.bodies.fixed = by_shape;
  model.scale_source = "board";
  model.calibrate = boards.calibrate;
  return model;
}

namespace {

/// Views of the mapper's largest model and of all models joined with it.
std::vector<View> JoinedViews(const ModelInput& in, const std::vector<ColmapModel>& models) {
  const ColmapModel& first = models[0];
  std::vector<View> views = first.scene.views;
  if (views.size() == in.set.images.size()) return views;
  std::set<std::string> placements{PlacementOf(in.set, first.scene)};
  for (std::size_t m = 1; m < models.size(); ++m) {
    const std::string name = "model" + std::to_string(m);
    const ColmapModel& other = models[m];
    ModelAlignment join = AlignModels(first.scene, other.scene,
                                      MatchPoints(first.tracks, other.tracks, in.matched.matches),
                                      AlignmentOptions{});
    Measure(in, name, join);
    const std::string placement = PlacementOf(in.set, other.scene);
    if (join.found) {
      const Scene moved = Transformed(join.first_from_second, other.scene);
      MatchAcross(in, views, moved.views);
      Append(views, moved);
    } else if (!placements.contains(placement)) {
      const Scene first_half = AdjustedModel(in, first), other_half = AdjustedModel(in, other);
      join = JoinPlacements(in, name, first_half, other_half);
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

PosedModel ModelFromMapper(const ModelInput& in, const std::vector<ColmapModel>& models,
                           const SetBoards& boards) {
  PosedModel model;
  model.scale_source = "none";
  if (models.empty()) return model;
  const ColmapModel& first = models[0];
  std::vector<View> views = JoinedViews(in, models);
  if (views.size() > first.scene.views.size()) {
    ShareCameras(in, first.scene.views, views);
    model = Triangulated(in, views, "joined");
    model.scale_source = "none";
  } else {
    model.scene = first.scene;
    model.observations = ObservationsOf(first, in.set, in.matched.features);
  }
  if (boards.groups.empty() || boards.groups[0].poses.scene.views.size() < 3) return model;
  try {
    model.scene =
        Transformed(BoardFromScene(boards.groups[0].poses.scene, model.scene), model.scene);
  } catch (const InputError& error) {
    in.stage.Note(error.what());
    return model;
  }
  SetBoards first_only = boards;
  first_only.groups.resize(1);
  model.bodies = BodiesOf(in, model.scene, first_only, {Rigid3{}});
  model.scale_source = "board";
  model.calibrate = boards.calibrate;
  return model;
}

}  // namespace keypose::reconstruct
