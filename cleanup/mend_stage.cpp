// keypose-mend: does to a mesh what a person painted on it with the brush that mends.
#include <string>
#include <vector>

#include "core/io/meshes/mesh_io.h"
#include "core/io/project/mending_io.h"
#include "core/stage/stage.h"
#include "core/surfaces/geometry.h"
#include "core/surfaces/mesh_checks.h"
#include "core/surfaces/self_intersections.h"
#include "core/values/errors.h"
#include "core/values/options.h"
#include "deform/mending/mend.h"

namespace {

using keypose::Mesh;
using keypose::StageContext;
using keypose::StageSpec;

struct MendOptions {
  double strength = 1;

  void Describe(keypose::OptionVisitor& visit) {
    visit("strength", strength,
          {"share of each stroke that is done; 0 leaves the mesh as it was, to compare", "", 0, 1});
  }
};

void WarnOfIdleStrokes(StageContext& stage, const std::vector<keypose::MendStroke>& strokes,
                       const keypose::Mended& mended) {
  std::string idle;
  for (std::size_t i = 0; i < strokes.size(); ++i)
    if (mended.done[i].vertices == 0)
      idle += (idle.empty() ? "" : ", ") + std::to_string(i + 1) + " (" +
              keypose::NameOf(strokes[i].tool) + ")";
  if (!idle.empty())
    stage.Warn(
        "mend: the brush of these strokes is smaller than the mesh's triangles, so they did "
        "nothing: " +
        idle + "; paint them with a larger brush");
}

/// Pairs of faces that cut each other.
std::int64_t Crossings(const Mesh& mesh, double diagonal) {
  return keypose::FindSelfIntersections(mesh.points / diagonal, mesh.faces,
                                        keypose::TouchingFaces::kLeftOut)
      .pairs;
}

void ReportResult(StageContext& stage, const Mesh& before, const Mesh& after,
                  const keypose::Mended& mended) {
  const double diagonal = keypose::BoundingDiagonal(before.points);
  const double furthest = (after.points - before.points).rowwise().norm().maxCoeff();
  stage.Report("strokes", static_cast<std::int64_t>(mended.done.size()));
  stage.Report("moved_max_over_diag", furthest / diagonal);
  stage.Report("volume_before", keypose::SignedVolume(before.points, before.faces));
  stage.Report("volume", keypose::SignedVolume(after.points, after.faces));
  const std::int64_t crossings = Crossings(after, diagonal);
  stage.Report("self_intersections", crossings);
  if (crossings > Crossings(before, diagonal))
    stage.Warn("mend: the mended surface cuts through itself in " + std::to_string(crossings) +
               " places; take out the stroke that pulled it so far, or smooth there");
}

void Run(StageContext& stage, const MendOptions& options) {
  keypose::RequireMeshName(stage.Output("mended"));
  const Mesh before = keypose::ReadMesh(stage.Input("mesh"));
  keypose::RequireUsable(before, stage.Input("mesh").string());
  keypose::CarryLog log;
  const auto file = stage.Input("strokes");
  keypose::MendStrokes read = keypose::ReadMendStrokes(file, before, &log);
  keypose::RequireOnMesh(read, file);
  for (const std::string& note : log.notes) stage.Note(note);
  for (const std::string& warning : log.warnings) stage.Warn(warning);
  for (keypose::MendStroke& stroke : read.strokes) stroke.strength *= options.strength;
  const keypose::Mended mended = [&] {
    try {
      return keypose::Mend(before, read.strokes, stage.progress());
    } catch (const keypose::InputError& error) {
      throw keypose::InputError(file.string() + ": " + error.what() +
                                "; take it out in the studio (Poses, Mend) or in the file");
    }
  }();
  Mesh after = before;
  after.points = mended.points;
  if (after.normals.rows() > 0) after.normals = keypose::VertexNormals(after.points, after.faces);
  WarnOfIdleStrokes(stage, read.strokes, mended);
  ReportResult(stage, before, after, mended);
  keypose::WriteMesh(stage.Output("mended"), after);
}

const StageSpec kSpec = {
    .name = "mend",
    .version = "1",
    .summary = "Smooths, pulls and fills places of a mesh as a person painted them; faces stay.",
    .title = "Mended mesh",
    .measurements = {{"strokes", "strokes"},
                     {"moved_max_over_diag", "farthest that a vertex was moved", "diagonal"},
                     {"self_intersections", "self-intersections", "", -keypose::kAnyNumber, 0}},
    .inputs = {{.name = "mesh", .kind = "file", .help = "triangles", .file = ""},
               {.name = "strokes",
                .kind = "file",
                .help = "what was painted (.json), as the studio writes it or by hand",
                .file = ""}},
    .outputs = {{.name = "mended",
                 .kind = "file",
                 .help = "the mesh with its vertices moved",
                 .file = "mended.ply"}},
    .tools = {},
    .cores = 1,
    .memory_gib = 1,
    .common = {}};

}  // namespace

int main(int argc, char** argv) { return keypose::RunStage<MendOptions>(argc, argv, kSpec, Run); }
