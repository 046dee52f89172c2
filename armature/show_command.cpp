// `keypose armature show`: what a page needs to show the character of a recorded take.
#include "armature/armature_commands.h"
#include "armature/live/page_stream.h"
#include "armature/live/puppet_files.h"
#include "core/stage/stage.h"

namespace keypose::armature {
namespace {

struct ShowOptions {
  PuppetChoices puppet;
  void Describe(OptionVisitor& visit) { puppet.Describe(visit); }
};

StageSpec ShowSpec() {
  StageSpec spec;
  spec.name = "armature show";
  spec.version = "2";
  spec.summary = "Writes what a page needs to show a character: its weights, its plates' cameras.";
  spec.inputs = PuppetPorts();
  spec.inputs.push_back({"plate", "path", "a plate, or a folder of them", "", true, false});
  spec.inputs.push_back(
      {"shot", "file", "the plates' camera (shot.json of locate)", "", true, false});
  spec.outputs = {{"page", "folder", "view.json, weights.bin, rest.ply, as of live --page", "page",
                   false, false}};
  spec.memory_gib = 1;
  return spec;
}

void RunShow(StageContext& stage, const ShowOptions& options) {
  const LoadedPuppet loaded = LoadPuppet(PuppetPathsIn(stage), options.puppet);
  const PuppetParts& parts = loaded.parts;
  for (const std::string& note : loaded.notes) stage.Note(note);
  for (const std::string& warning : loaded.warnings) stage.Warn(warning);
  const PlateFiles plates(stage.Input("plate"), stage.Input("shot"), parts.mesh.points);
  const PageStream written(parts, plates, stage.Has("mesh"), stage.Output("page"));
  stage.Report("bones", parts.skeleton.size());
  stage.Report("vertices", parts.mesh.vertex_count());
}

}  // namespace

int ShowCommand(int argc, char** argv) {
  return RunStage<ShowOptions>(argc, argv, ShowSpec(), RunShow);
}

}  // namespace keypose::armature
