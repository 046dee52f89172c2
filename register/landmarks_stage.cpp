// keypose-landmarks: `keypose landmarks suggest` suggests pairs of landmarks for a person to
// confirm; `keypose landmarks bind` binds picks to their mesh.
#include <fmt/format.h>

#include <iterator>
#include <sstream>
#include <string>
#include <vector>

#include "core/io/meshes/mesh_io.h"
#include "core/io/pictures/image_io.h"
#include "core/io/project/landmarks_io.h"
#include "core/pictures/render.h"
#include "core/stage/stage.h"
#include "core/surfaces/mesh_checks.h"
#include "core/surfaces/ray_scene.h"
#include "core/values/errors.h"
#include "register/intrinsic/skin.h"
#include "register/intrinsic/suggest.h"
#include "register/landmarks/landmark_picture.h"
#include "register/landmarks/landmarks.h"
#include "register/landmarks_bind.h"
#include "register/landmarks_options.h"

namespace keypose::registration {
namespace {

StageSpec Spec() {
  StageSpec spec;
  spec.name = "landmarks suggest";
  spec.version = "4";
  spec.summary =
      "Suggests pairs of landmarks between two poses; a person confirms them. (To bind picks to "
      "their mesh: keypose landmarks bind --help.)";
  spec.title = "Landmarks";
  spec.inputs = {
      {"source", "file", "template mesh", "", false, false},
      {"target", "file", "clean mesh of the pose", "", false, false},
      {"source_texture", "file", "the source's texture, for a source with UVs", "", true, false},
      {"target_texture", "file", "the target's texture", "", true, false},
      {"landmarks", "file", "pairs that are already known, or picks of source and target", "", true,
       true}};
  spec.outputs = {
      {"suggested", "file", "known and suggested pairs (.json), to confirm and pass to register",
       "suggested.json", false, false},
      {"source_picks", "file", "the confirmed pairs' picks on the source (.json), for a project",
       "source.json", true, false},
      {"target_picks", "file", "the same on the target", "target.json", true, false},
      {"picture", "file", "both meshes with the numbered pairs (.png)", "suggested.png", true,
       false}};
  spec.memory_gib = 1;
  return spec;
}

PickedPair PickOf(const LandmarkPair& pair) {
  return {pair.name, pair.source.face, pair.target.face, pair.source.barycentric,
          pair.target.barycentric};
}

LandmarkPair PairOf(const SuggestedPair& suggested, const std::string& name) {
  const PickedPair& pick = suggested.pick;
  LandmarkPair pair;
  pair.name = name;
  pair.source = {name, pick.source_face, pick.source_barycentric};
  pair.target = {name, pick.target_face, pick.target_barycentric};
  pair.confirmed = false;
  pair.confidence = suggested.confidence;
  pair.origin = suggested.origin;
  return pair;
}

/// Known pairs that a person has confirmed. Unconfirmed suggestions of an earlier run are dropped,
/// and new ones are made.
std::vector<LandmarkPair> LoadConfirmed(StageContext& stage, const Mesh& source,
                                        const Mesh& target) {
  std::vector<LandmarkPair> known;
  if (!stage.Has("landmarks")) return known;
  int dropped = 0;
  CarryLog log;
  std::vector<LandmarkPair> read =
      ReadLandmarkPairs(stage.Inputs("landmarks"), source, target, &log);
  for (const std::string& note : log.notes) stage.Note(note);
  for (const std::string& warning : log.warnings) stage.Warn(warning);
  for (LandmarkPair& pair : read) {
    if (pair.confirmed)
      known.push_back(std::move(pair));
    else
      ++dropped;
  }
  if (dropped > 0)
    stage.Note(std::to_string(dropped) + " unconfirmed pairs were dropped; new ones are suggested");
  return known;
}

/// Marks pairs as confirmed.
/// @param accept  "all", or numbers from 1 and ranges, separated by commas; may be empty
void Accept(const std::string& accept, std::vector<LandmarkPair>& pairs) {
  if (accept == "all")
    for (LandmarkPair& pair : pairs) pair.confirmed = true;
  if (accept.empty() || accept == "all") return;
  std::istringstream parts(accept);
  for (std::string part; std::getline(parts, part, ',');) {
    std::istringstream in(part);
    std::size_t first = 0, last = 0;
    char dash = 0, rest = 0;
    bool good = static_cast<bool>(in >> first);
    last = first;
    if (good && in >> dash) good = dash == '-' && in >> last;
    if (!good || in >> rest || first < 1 || last < first || last > pairs.size())
      throw UsageError("--accept: '" + part + "' is not a number or range from 1 to " +
                       std::to_string(pairs.size()) + " (the numbers in the picture), nor all");
    for (std::size_t k = first; k <= last; ++k) pairs[k - 1].confirmed = true;
  }
}

void WritePicks(StageContext& stage, const std::string& port, const Mesh& mesh,
                const std::vector<LandmarkPair>& pairs, Landmark LandmarkPair::*side) {
  const std::filesystem::path path = stage.Output(port);
  if (path.empty()) return;
  std::vector<Landmark> picks;
  for (const LandmarkPair& pair : pairs)
    if (pair.confirmed) picks.push_back(pair.*side);
  if (picks.empty())
    throw UsageError("--" + port +
                     ": no pair is confirmed; confirm the correct ones with --accept");
  WriteLandmarks(path, mesh, picks);
}

std::string FreeName(const std::vector<LandmarkPair>& pairs, std::size_t& number) {
  for (;;) {
    const std::string name = "suggested-" + std::to_string(++number);
    bool taken = false;
    for (const LandmarkPair& pair : pairs) taken = taken || pair.name == name;
    if (!taken) return name;
  }
}

/// Folder and file name: in a project all meshes have the same file name, and the folder is the
/// pose.
std::string ShortName(const std::filesystem::path& path) {
  const std::filesystem::path full = std::filesystem::absolute(path).lexically_normal();
  return full.parent_path().filename().string() + "/" + full.filename().string();
}

std::vector<DrawnPair> DrawnPairs(const std::vector<LandmarkPair>& pairs, const Mesh& source,
                                  const Mesh& target) {
  std::vector<DrawnPair> drawn;
  for (const LandmarkPair& pair : pairs)
    drawn.push_back({keypose::PositionOf(pair.source, source),
                     keypose::PositionOf(pair.target, target), pair.confirmed});
  return drawn;
}

/// What is compared in place of an input: the input itself, or a skin around its pieces.
struct Compared {
  explicit Compared(const Mesh& input) : mesh(input) {
    if (auto skin = SkinOfPieces(input)) {
      mesh = std::move(*skin);
      skinned = true;
    }
  }
  /// The place of `mesh` that is nearest to one of the input, and the other way round.
  static void Carry(const Mesh& from, const Mesh& to, int* face, Eigen::Vector3d* barycentric) {
    Eigen::Vector3d place = Eigen::Vector3d::Zero();
    for (int k = 0; k < 3; ++k)
      place += (*barycentric)[k] * from.points.row(from.faces(*face, k)).transpose();
    const RayScene::Foot foot = RayScene(to.points, to.faces).ClosestPoint(place);
    *face = foot.face;
    *barycentric = foot.barycentric;
  }
  void ToInput(const Mesh& input, int* face, Eigen::Vector3d* barycentric) const {
    if (skinned) Carry(mesh, input, face, barycentric);
  }
  void FromInput(const Mesh& input, int* face, Eigen::Vector3d* barycentric) const {
    if (skinned) Carry(input, mesh, face, barycentric);
  }

  Mesh mesh;
  bool skinned = false;
};

/// The known pairs on what is compared.
std::vector<LandmarkGoal> OnCompared(const CheckedLandmarks& known, std::vector<PickedPair> picked,
                                     const Mesh& source, const Mesh& target, const Compared& one,
                                     const Compared& other) {
  if (!one.skinned && !other.skinned) return known.goals;
  for (PickedPair& pair : picked) {
    one.FromInput(source, &pair.source_face, &pair.source_barycentric);
    other.FromInput(target, &pair.target_face, &pair.target_barycentric);
  }
  return CheckLandmarks(picked, one.mesh, other.mesh).goals;
}

void WritePicture(StageContext& stage, const LandmarksOptions& options, const Mesh& source,
                  const Mesh& target, const std::vector<DrawnPair>& drawn,
                  const Suggestion& suggestion) {
  const std::filesystem::path path = stage.Output("picture");
  if (path.empty()) return;
  LandmarkPictureOptions picture;
  picture.panel = options.panel;
  picture.source_name = "source: " + ShortName(stage.Input("source"));
  picture.target_name = "target: " + ShortName(stage.Input("target"));
  picture.up = Eigen::Vector3d::Unit(options.up[0] - 'x');
  WriteImage(path, DrawLandmarks(source, target, drawn, suggestion.dense, picture));
}

/// Why nothing is suggested, and what a person can do; empty where something is.
std::string WhyNone(const CheckedLandmarks& known, const Suggestion& suggestion,
                    const LandmarksOptions& options) {
  if (!suggestion.pairs.empty() || options.suggest.count == 0) return "";
  const double best = suggestion.confidence.size() > 0 ? suggestion.confidence.maxCoeff() : 0.0;
  const bool few = known.goals.size() < 3;
  return fmt::format(
      "no pair is suggested: the surest has the confidence {:.2f}, and {:.2f} is asked for "
      "(min_confidence). Distances along the surface differ by {:.0f} % between the two meshes, "
      "and "
      "3 to 8 % are usual: they have other limbs or proportions, or one of them is incomplete. {}",
      best, options.suggest.min_confidence, 100 * suggestion.distortion,
      few ? "Pick three pairs yourself (the head, a hand, a foot), and suggest again with them; if "
            "that finds none either, pick all pairs, 20 or more for `transfer`"
          : "Pick the other pairs yourself, 20 or more for `transfer`");
}

void Report(StageContext& stage, const CheckedLandmarks& known, const Suggestion& suggestion,
            const LandmarksOptions& options) {
  stage.Report("known", std::ssize(known.goals));
  stage.Report("suggested", std::ssize(suggestion.pairs));
  stage.Report("distortion", suggestion.distortion);
  stage.Report("orientation_kept", suggestion.orientation);
  stage.Report("margin", suggestion.margin);
  stage.Report("mean_confidence",
               suggestion.confidence.size() > 0 ? suggestion.confidence.mean() : 0.0);
  stage.Report("explanation", suggestion.explanation);
  stage.Note(suggestion.explanation);
  for (const std::string& warning : known.warnings) stage.Warn(warning);
  const std::string none = WhyNone(known, suggestion, options);
  stage.Report("none_because", none);
  if (!none.empty()) stage.Warn(none);
}

/// Reads a mesh. If its texture is given, the vertices get the texture's colours.
Mesh LoadMesh(StageContext& stage, const std::string& port) {
  Mesh mesh = ReadMesh(stage.Input(port));
  RequireUsable(mesh, stage.Input(port).string());
  const std::string texture_port = port + "_texture";
  if (!stage.Has(texture_port)) return mesh;
  if (!mesh.has_uvs())
    throw InputError("landmarks: " + stage.Input(port).string() +
                     " has no UVs, so its texture cannot be used; omit the texture");
  const Image8 texture = ReadImage(stage.Input(texture_port), 3);
  mesh.colors = ColorsX3::Constant(mesh.vertex_count(), 3, 128);
  for (Eigen::Index f = 0; f < mesh.faces.rows(); ++f)
    for (int k = 0; k < 3; ++k) {
      const Eigen::Vector3d color =
          SampleTexture(texture, mesh.uvs.row(mesh.uv_faces(f, k)).transpose());
      mesh.colors.row(mesh.faces(f, k)) =
          color.cwiseMax(0).cwiseMin(255).cast<std::uint8_t>().transpose();
    }
  return mesh;
}

void Run(StageContext& stage, const LandmarksOptions& options) {
  const Mesh source = LoadMesh(stage, "source"), target = LoadMesh(stage, "target");
  std::vector<LandmarkPair> pairs = LoadConfirmed(stage, source, target);
  std::vector<PickedPair> picked;
  for (const LandmarkPair& pair : pairs) picked.push_back(PickOf(pair));
  const CheckedLandmarks known = CheckLandmarks(picked, source, target);
  const Compared one(source), other(target);
  if (one.skinned || other.skinned)
    stage.Note("the mesh is made of several pieces: one surface around them is compared");
  Suggestion suggestion =
      SuggestLandmarks(one.mesh, other.mesh, OnCompared(known, picked, source, target, one, other),
                       options.suggest, stage.progress());
  for (SuggestedPair& suggested : suggestion.pairs) {
    one.ToInput(source, &suggested.pick.source_face, &suggested.pick.source_barycentric);
    other.ToInput(target, &suggested.pick.target_face, &suggested.pick.target_barycentric);
  }
  std::size_t number = 0;
  for (const SuggestedPair& suggested : suggestion.pairs)
    pairs.push_back(PairOf(suggested, FreeName(pairs, number)));
  Accept(options.accept, pairs);
  Report(stage, known, suggestion, options);
  WritePicks(stage, "source_picks", source, pairs, &LandmarkPair::source);
  WritePicks(stage, "target_picks", target, pairs, &LandmarkPair::target);
  WriteLandmarkPairs(stage.Output("suggested"), source, target, pairs);
  WritePicture(stage, options, one.mesh, other.mesh, DrawnPairs(pairs, source, target), suggestion);
}

}  // namespace
}  // namespace keypose::registration

int main(int argc, char** argv) {
  // `keypose landmarks suggest ...` arrives as `keypose-landmarks suggest ...`.
  const std::string word = argc > 1 ? argv[1] : "";
  if (word == "suggest" || word == "bind") {
    argv[1] = argv[0];
    --argc;
    ++argv;
  }
  if (word == "bind") return keypose::registration::BindMain(argc, argv);
  return keypose::RunStage<keypose::registration::LandmarksOptions>(
      argc, argv, keypose::registration::Spec(), keypose::registration::Run);
}
