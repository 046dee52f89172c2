// `keypose armature edit`: a recorded take changed as a dope sheet says, as a new take.
#include <fmt/format.h>

#include "armature/armature_commands.h"
#include "armature/description/description_file.h"
#include "armature/recording/curve_edits.h"
#include "armature/recording/flipbook.h"
#include "core/io/meshes/bvh_io.h"
#include "core/io/text/files.h"
#include "core/stage/stage.h"
#include "core/values/size_of.h"

namespace keypose::armature {
namespace {

struct EditOptions {
  void Describe(OptionVisitor&) {}
};

StageSpec EditSpec() {
  StageSpec spec;
  spec.name = "armature edit";
  spec.version = "3";
  spec.summary = "Changes a recorded take frame by frame, and writes it as a new one.";
  spec.inputs = {
      {"description", "file", "the armature's description file", "", false, false},
      {"curves", "file", "recorded curves (curves.json of a session)", "", false, false},
      {"edits", "file", "what to change: lines such as `hold neck 3-6`", "", false, false}};
  spec.outputs = {{"take", "folder",
                   "curves.json, curves.csv, curves.bvh, flipbook.json, flipbook.svg, edits.txt",
                   "take", false, false}};
  spec.memory_gib = 1;
  return spec;
}

void RunEdit(StageContext& stage, const EditOptions&) {
  const auto description = stage.Input("description"), path = stage.Input("curves"),
             edits_path = stage.Input("edits");
  const DescriptionFile file =
      DescriptionFile::Parse(ReadFile(description), PrintableName(description));
  const Armature& armature = file.armature();
  const JointCurves before = ParseCurvesJson(ReadFile(path), PrintableName(path), armature);
  if (const std::string words = LeftOutWords(before); !words.empty()) stage.Warn(words);
  const std::string text = ReadFile(edits_path);
  const std::vector<CurveEdit> edits = ParseCurveEdits(text, PrintableName(edits_path), armature);
  const JointCurves curves = EditedCurves(armature, before, edits);
  const auto take = stage.Output("take");
  WriteFile(take / "curves.json", CurvesJson(armature, curves));
  WriteFile(take / "curves.csv", CurvesCsv(armature, curves));
  WriteFile(take / "curves.bvh", BvhText(CurvesClip(armature, curves)));
  WriteFile(take / "flipbook.json", FlipbookJson(armature, curves));
  WriteFile(take / "flipbook.svg", FlipbookSvg(armature, curves));
  WriteFile(take / "edits.txt", text);
  stage.Note(fmt::format("{} edits; {} recorded frames on {} became {} on {}", edits.size(),
                         before.frame_count(), before.step, curves.frame_count(), curves.step));
  stage.Report("edits", SizeOf(edits));
  stage.Report("frames", curves.frame_count());
  stage.Report("step", curves.step);
}

}  // namespace

int EditCommand(int argc, char** argv) {
  return RunStage<EditOptions>(argc, argv, EditSpec(), RunEdit);
}

}  // namespace keypose::armature
