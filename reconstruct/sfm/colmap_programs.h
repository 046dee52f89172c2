// COLMAP's programs as steps of sfm, run so that their results do not depend on threads.
#pragma once

#include <filesystem>
#include <string>
#include <vector>

#include "core/io/pictures/image_set.h"
#include "core/stage/stage.h"
#include "reconstruct/bundle/bundle_adjustment.h"
#include "reconstruct/join/model_alignment.h"
#include "reconstruct/matching/colmap_database.h"
#include "reconstruct/sfm/sfm_options.h"

namespace keypose::reconstruct {

/// Files of one run, in the stage's scratch folder.
struct SfmFiles {
  std::filesystem::path scratch, images, database;
};

/// Which features of the photographs are extracted.
struct FeatureKind {
  /// also at twice the photographs' size, which gives four of five features and takes most of the
  /// time
  bool fine = false;
  /// of the whole photographs, reduced to `whole_px`, without adapting to slanted surfaces; fine
  /// ones are not reduced and adapt, which tells slanted mats. Else of the masks alone
  bool whole = false;
  /// of the masks, which hold what moves with the figure in a room, not the figure alone
  bool region = false;
  /// of masks, and of the same drawn to twice the height, which shows what lies on a table more as
  /// from above: it matches at any turn. Without adapting to slanted surfaces: on what repeats
  /// itself that finds wrong turns
  bool on_table = false;
};

/// Writes the SIFT features of all images into the database. The photographs are cropped to their
/// masks unless they are used whole; those without a mask always are.
/// @throws InputError  a mask of another size than its photograph
void ExtractFeatures(StageContext& stage, const ImageSet& set, const SfmFiles& files,
                     const SfmOptions& options, const FeatureKind& kind);

/// A model as COLMAP wrote it.
struct ColmapModel {
  Scene scene;
  std::vector<TrackElement> tracks;  ///< of scene.points, by point
};

/// Incremental mapping on one thread (sums over several threads depend on their number).
/// @return the model with most images first
std::vector<ColmapModel> MapImages(StageContext& stage, const SfmFiles& files,
                                   const SfmOptions& options);

/// Triangulates points in images with known cameras, by COLMAP's point_triangulator on one thread.
/// Images that `views` lacks are then registered to these points where possible
/// (image_registrator), and triangulated too. The given cameras do not move.
/// @param views  with names of the set; cameras may differ
ColmapModel TriangulateKnown(StageContext& stage, const ImageSet& set, const SfmFiles& files,
                             const std::vector<View>& views, const std::string& name,
                             const SfmOptions& options);

/// The features of the points of a model.
/// @param features  of all images of the set
std::vector<Observation> ObservationsOf(const ColmapModel& model, const ImageSet& set,
                                        const std::vector<Features>& features);

/// The output of `colmap model_analyzer`, as names and numbers.
std::vector<std::pair<std::string, double>> AnalyzeModel(StageContext& stage,
                                                         const std::filesystem::path& model);

}  // namespace keypose::reconstruct
