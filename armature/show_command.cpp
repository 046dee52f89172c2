// `keypose armature show`: what a page needs to show the character of a recorded take.
#include "armature/commands.h"
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
  spec.version = "1";
  spec.summary = "Writes what a page needs to show a character: its weights, its plates' cameras.";
  spec.inputs = {{"description", "file", "the armature's description file", "", false, false},
                 {"chains", "file", "the file of anchors and chains", "", false, false},
                 {"skeleton", "file", "the computer skeleton (.bvh); else like the armature itself",
                  "", true, false},
                 {"mesh", "file", "the character at rest; else ball and stick", "", true, false},
                 {"weights", "file", "the mesh's weights (.json, .mhw or .dmat); else by heat", "",
                  true, false},
                 {"plate", "path", "a plate, or a folder of them", "", true, false},
                 {"shot", "file", "the plates' camera (shot.json of locate)", "", true, false}};
  spec.outputs = {{"page", "folder", "view.json, weights.bin, rest.ply, as of live --page", "page",
                   false, false}};
  spec.memory_gib = 1;
  return spec;
}

void RunShow(StageContext& stage, const ShowOptions& options) {
  const PuppetPaths paths = {stage.Input("description"), stage.Input("chains"),
                             stage.Input("skeleton"), stage.Input("mesh"), stage.Input("weights")};
  const LoadedPuppet loaded = LoadPuppet(paths, options.puppet);
  const PuppetParts& parts = loaded.parts;
  for (const std::string& note : loaded.notes) stage.Note(note);
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
