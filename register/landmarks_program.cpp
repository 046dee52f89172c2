// keypose-landmarks: `keypose landmarks suggest` proposes pairs of landmarks for a person to confirm.
#include <cstring>
#include <string>
#include <vector>

#include "core/geometry.h"
#include "core/io/image_io.h"
#include "core/io/landmarks_io.h"
#include "core/io/mesh_io.h"
#include "core/stage/stage.h"
#include "register/landmark_picture.h"
#include "register/landmarks.h"
#include "register/suggest.h"

namespace keypose::registration {
namespace {

struct ProgramOptions {
  SuggestOptions suggest;
  std::string up = "z";
  int panel = 360;

  void Describe(OptionVisitor& visit) {
    visit("count", suggest.count, {"pairs to suggest at most, beside those given", "", 1, 1000, {}});
    visit("min_confidence", suggest.min_confidence, {"leave out suggestions that are less sure", "", 0, 1, {}});
    visit("proxy_vertices", suggest.proxy_vertices, {"size of the decimated meshes that are compared", "vertices", 100, 20000, {}});
    visit("samples", suggest.samples, {"points at which candidate maps are compared", "", 50, 5000, {}});
    visit("functions", suggest.functions, {"eigenfunctions that the last refinement uses", "", 20, 500, {}});
    visit("candidates", suggest.candidates, {"assignments of limbs that are tried", "", 1, 10000, {}});
    visit("up", up, {.help = "axis that points up in the picture", .unit = "", .choices = {"x", "y", "z"}});
    visit("panel", panel, {"width and height of each view in the picture", "px", 64, 4096, {}});
  }
  std::vector<std::string> Problems() const { return suggest.Problems(); }
};

StageSpec Spec() {
  StageSpec spec;
  spec.name = "landmarks suggest";
  spec.version = "1";
  spec.summary = "Suggests pairs of landmarks between two poses; a person confirms them.";
  spec.inputs = {{"source", "file", "template mesh", "", false, false},
                 {"target", "file", "clean mesh of the pose", "", false, false},
                 {"landmarks", "file", "pairs that are known already, or picks of source and target", "", true, true}};
  spec.outputs = {
      {"suggested", "file", "known and suggested pairs (.json), to confirm and give to register", "suggested.json", false, false},
      {"picture", "file", "both meshes with the numbered pairs (.png)", "suggested.png", true, false}};
  spec.memory_gib = 1;
  return spec;
}

PickedPair PickOf(const LandmarkPair& pair) {
  return {pair.name, pair.source.face, pair.target.face, pair.source.barycentric, pair.target.barycentric};
}

LandmarkPair PairOf(const SuggestedPair& suggested, const std::string& name) {
  const PickedPair& pick = suggested.pick;
  LandmarkPair pair;
  pair.name = name;
  pair.source = {name, pick.source_face, pick.source_barycentric, ""};
  pair.target = {name, pick.target_face, pick.target_barycentric, ""};
  pair.confirmed = false;
  pair.confidence = suggested.confidence;
  pair.origin = suggested.origin;
  return pair;
}

/// Known pairs that a person stands behind; an earlier run's unconfirmed suggestions are made anew.
std::vector<LandmarkPair> LoadConfirmed(StageContext& stage, const Mesh& source, const Mesh& target) {
  std::vector<LandmarkPair> known;
  if (!stage.Has("landmarks")) return known;
  int dropped = 0;
  for (LandmarkPair& pair : ReadLandmarkPairs(stage.Inputs("landmarks"), source, target)) {
    if (pair.confirmed)
      known.push_back(std::move(pair));
    else
      ++dropped;
  }
  if (dropped > 0) stage.Note(std::to_string(dropped) + " pairs that nobody confirmed were left out and are suggested anew");
  return known;
}

std::string FreeName(const std::vector<LandmarkPair>& pairs, std::size_t& number) {
  for (;;) {
    const std::string name = "suggested-" + std::to_string(++number);
    bool taken = false;
    for (const LandmarkPair& pair : pairs) taken = taken || pair.name == name;
    if (!taken) return name;
  }
}

void WritePicture(StageContext& stage, const ProgramOptions& options, const Mesh& source, const Mesh& target,
                  const std::vector<LandmarkPair>& pairs, const Suggestion& suggestion) {
  const std::filesystem::path path = stage.Output("picture");
  if (path.empty()) return;
  std::vector<DrawnPair> drawn;
  for (const LandmarkPair& pair : pairs)
    drawn.push_back({keypose::PositionOf(pair.source, source), keypose::PositionOf(pair.target, target), pair.confirmed});
  LandmarkPictureOptions picture;
  picture.panel = options.panel;
  picture.up = Eigen::Vector3d::Unit(options.up == "x" ? 0 : options.up == "y" ? 1 : 2);
  WriteImage(path, DrawLandmarks(source, target, drawn, suggestion.dense, picture));
}

void Report(StageContext& stage, const CheckedLandmarks& known, const Suggestion& suggestion) {
  stage.Report("known", static_cast<std::int64_t>(known.goals.size()));
  stage.Report("suggested", static_cast<std::int64_t>(suggestion.pairs.size()));
  stage.Report("distortion", suggestion.distortion);
  stage.Report("orientation_kept", suggestion.orientation);
  stage.Report("margin", suggestion.margin);
  stage.Report("mean_confidence", suggestion.confidence.size() > 0 ? suggestion.confidence.mean() : 0.0);
  stage.Report("explanation", suggestion.explanation);
  stage.Note(suggestion.explanation);
  for (const std::string& warning : known.warnings) stage.Note("warning: " + warning);
}

void Run(StageContext& stage, const ProgramOptions& options) {
  const Mesh source = ReadMesh(stage.Input("source")), target = ReadMesh(stage.Input("target"));
  RequireUsable(source, stage.Input("source").string());
  RequireUsable(target, stage.Input("target").string());
  std::vector<LandmarkPair> pairs = LoadConfirmed(stage, source, target);
  std::vector<PickedPair> picked;
  for (const LandmarkPair& pair : pairs) picked.push_back(PickOf(pair));
  const CheckedLandmarks known = CheckLandmarks(picked, source, target);
  const Suggestion suggestion = SuggestLandmarks(source, target, known.goals, options.suggest, stage.progress());
  std::size_t number = 0;
  for (const SuggestedPair& suggested : suggestion.pairs) pairs.push_back(PairOf(suggested, FreeName(pairs, number)));
  Report(stage, known, suggestion);
  WriteLandmarkPairs(stage.Output("suggested"), source, target, pairs);
  WritePicture(stage, options, source, target, pairs, suggestion);
}

}  // namespace
}  // namespace keypose::registration

int main(int argc, char** argv) {
  // `keypose landmarks suggest ...` arrives as `keypose-landmarks suggest ...`; suggesting is all that this program does so far.
  if (argc > 1 && std::strcmp(argv[1], "suggest") == 0) {
    argv[1] = argv[0];
    --argc;
    ++argv;
  }
  return keypose::RunStage<keypose::registration::ProgramOptions>(argc, argv, keypose::registration::Spec(), keypose::registration::Run);
}
