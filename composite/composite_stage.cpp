// keypose-composite: in-betweens rendered into a filmed shot.
#include <fmt/format.h>

#include <algorithm>
#include <nlohmann/json.hpp>

#include "composite/composite_input.h"
#include "composite/composite_options.h"
#include "composite/composite_output.h"
#include "core/io/text/files.h"
#include "core/stage/stage.h"
#include "core/values/errors.h"
#include "core/values/file_names.h"
#include "core/values/size_of.h"
#include "views/decode/read_sound.h"

namespace {

using keypose::StageContext;
using namespace keypose::composite;
using nlohmann::ordered_json;

const keypose::StageSpec kSpec{
    .name = "composite",
    .version = "9",
    .summary = "Renders in-betweens into a filmed shot.",
    .title = "Into the shot",
    .inputs = {{.name = "frames",
                .kind = "folder",
                .help = "the animation's frames (frame_0000.ply, ..., distortion.json)"},
               {.name = "textures",
                .kind = "file",
                .help = "texture of each key, in the keys' order; or one for all; else the "
                        "character has one colour",
                .optional = true,
                .repeatable = true},
               {.name = "shot", .kind = "file", .help = "camera and places (.json), of `locate`"},
               {.name = "plate",
                .kind = "path",
                .help = "the set without the character (a picture), or the film, from which it is "
                        "made; of a moving camera numbered plates or a video of the empty set"},
               {.name = "filmed",
                .kind = "path",
                .help = "filmed frames (a folder of numbered pictures, or a video), which stay as "
                        "they are; else all pictures are rendered",
                .optional = true},
               {.name = "holdout",
                .kind = "file",
                .help = "picture that is white where props stand before the character",
                .optional = true},
               {.name = "set",
                .kind = "file",
                .help = "mesh of props and furniture in the shot's world, which hide the character "
                        "and catch its shadow (.obj, .ply, ...)",
                .optional = true},
               {.name = "ocio_config",
                .kind = "file",
                .help = "OpenColorIO configuration (.ocio) of OpenEXR or DPX plates",
                .optional = true},
               {.name = "sound",
                .kind = "file",
                .help = "of shot.mp4: WAV, FLAC, MP3, Opus or another that ffmpeg decodes, or the "
                        "film with its own",
                .optional = true}},
    .outputs = {{.name = "pictures",
                 .kind = "folder",
                 .help = "the finished shot, numbered; layers with alpha, film, report",
                 .file = "pictures"}},
    .memory_gib = 3,
    .common = {"follow", "shutter", "format"}};

ordered_json JoinNode(const KeyJoin& join) {
  const JoinFigures& f = join.figures;
  return {{"picture", join.picture},
          {"pose", join.pose},
          {"psnr_db", f.psnr_db},
          {"edge_px", f.edge_px},
          {"edge_share", f.edge_share},
          {"colour_levels", f.colour_levels},
          {"box", {f.box[0], f.box[1], f.box[2], f.box[3]}}};
}

ordered_json PictureNodes(const CompositeInput& input) {
  ordered_json nodes = ordered_json::array();
  for (int n = 0; n < keypose::SizeOf(input.plan.pictures); ++n) {
    const PlannedPicture& picture = input.plan.pictures[n];
    const char* kinds[] = {"filmed", "between", "held"};
    ordered_json node = {{"picture", input.first_number + n},
                         {"kind", kinds[static_cast<int>(picture.kind)]}};
    if (picture.filmed >= 0 && picture.kind != PictureKind::kBetween)
      node["film"] = input.film[picture.filmed].path.filename().string();
    if (picture.animation >= 0) node["frame"] = picture.animation;
    nodes.push_back(node);
  }
  return nodes;
}

void ReportLessons(StageContext& stage, const FilmLessons& lessons) {
  stage.Report("plate_hidden", lessons.plate.hidden);
  stage.Report("plate_given", lessons.plate.given);
  stage.Report("plate_inpainted", lessons.plate.inpainted);
  stage.Report("grain_levels", lessons.grain ? lessons.grain->MeanSigma() : 0.0);
  stage.Report("blur_px", lessons.blur_px);
  if (!lessons.shifts.empty()) stage.Report("followed_px", lessons.beside_px);
  stage.Report("shadow_sky", lessons.shadow.strength.sky);
  stage.Report("shadow_lamp", lessons.shadow.strength.lamp);
  stage.Report("shadow_explained", lessons.shadow.explained);
  for (const std::string& note : lessons.notes) stage.Note("composite: " + note);
  if (lessons.plate.inpainted > 0)
    stage.Warn(fmt::format(
        "composite: {} pixels of the set are hidden by the character in all filmed frames and were "
        "painted in from around them; give a clean plate if one sees it",
        lessons.plate.inpainted));
}

/// Of a moving camera.
void ReportPlates(StageContext& stage, const CompositeInput& input) {
  if (!input.moving_plates) return;
  const MovingPlates& plates = *input.moving_plates;
  stage.Report("plates_made", plates.made);
  stage.Report("plates_doubtful", plates.doubtful);
  if (plates.made > 0)
    stage.Warn(fmt::format(
        "composite: {} plates between filmed frames were made from their neighbours, which "
        "differed in up to {:.1f} % of the pixels; look at plates/, and shoot plates at {:g} "
        "pictures a second where the move allows",
        plates.made, 100 * plates.doubtful, input.times.fps));
  int without = 0;
  for (const keypose::FilmPicture& picture : input.film) {
    const int shown = picture.frame * input.plan.per_frame - input.plan.start;
    const bool located =
        std::any_of(input.shot.frames.begin(), input.shot.frames.end(),
                    [&](const keypose::ShotFrame& f) { return f.frame == picture.frame; });
    without += shown >= 0 && shown < keypose::SizeOf(input.frames) && !located;
  }
  if (without > 0)
    stage.Warn(fmt::format(
        "composite: the camera of {} filmed frames was not located but taken from a smooth way "
        "between the others; a move that is not smooth there shows as sliding",
        without));
}

void Judge(StageContext& stage, const std::vector<KeyJoin>& joins) {
  if (joins.empty()) return;
  const auto worst = std::min_element(
      joins.begin(), joins.end(),
      [](const KeyJoin& a, const KeyJoin& b) { return a.figures.psnr_db < b.figures.psnr_db; });
  double edge = 0;
  for (const KeyJoin& join : joins) edge = std::max(edge, join.figures.edge_px);
  stage.Report("worst_join_psnr_db", worst->figures.psnr_db);
  stage.Report("worst_join_edge_px", edge);
  const std::string figures = fmt::format(
      "at its keys the render is {:.1f} dB from the filmed frames at worst (picture "
      "{:04}), and its outlines are {:.2f} px off",
      worst->figures.psnr_db, worst->picture, edge);
  const bool good = worst->figures.psnr_db >= 28 && edge <= 1,
             usable = worst->figures.psnr_db >= 22 && edge <= 2.5;
  if (good) return stage.Verdict("shot", "good", figures);
  stage.Verdict("shot", usable ? "look" : "wrong",
                figures + "; look at compare/, and locate the shot again where it is off");
}

/// Of rendered pictures.
std::string EndingOf(const std::string& format, const CompositeInput& input) {
  const std::string& filmed = input.kind.ending;
  if (input.scene) return ".exr";
  if (format == "film") return filmed;
  if (format == "tiff") return filmed == ".png" ? ".tif" : filmed;
  return "." + format;
}

void RequireFormat(const std::string& format, const CompositeInput& input) {
  if (!input.scene || format == "film" || format == "exr") return;
  throw keypose::UsageError(fmt::format(
      "composite: pictures over OpenEXR and DPX plates are OpenEXR, and {} cannot hold their "
      "light; leave `format` out, and convert what is written",
      format));
}

/// Programs that read numbered pictures take one ending.
void NoteEndings(StageContext& stage, const CompositeInput& input, const std::string& rendered) {
  if (!input.film_stays) return;
  const std::string filmed = keypose::LowerExtension(input.film.front().path);
  if (filmed != rendered)
    stage.Note(fmt::format(
        "composite: filmed frames stay {} and rendered ones are {}; for one ending, make the film "
        "{} before (without loss), or take shot.mp4",
        filmed, rendered, input.scene ? "OpenEXR" : "PNG or TIFF"));
}

keypose::Sound SoundOfShot(StageContext& stage, const CompositeOptions& options,
                           const CompositeInput& input) {
  if (!stage.Has("sound") || !options.video) return {};
  const double seconds = static_cast<double>(input.plan.pictures.size()) / input.times.fps;
  keypose::HeardSound heard =
      keypose::ReadSoundAt(stage.Input("sound"), options.sound_at, seconds, stage.progress());
  if (!heard.warning.empty()) stage.Warn(heard.warning);
  return std::move(heard.sound);
}

void Run(StageContext& stage, const CompositeOptions& options) {
  const CompositeInput input = ReadCompositeInput(stage, options.fps, options.plate_colorspace);
  RequireFormat(options.format, input);
  ShotGeometry geometry(input.shot, input.plan, input.frames, input.times);
  const Film film = FilmOf(input, geometry);
  const FilmLessons lessons =
      LearnFromFilm(geometry, input.looks, film, {options.samples, options.follow, options.light},
                    stage.progress());
  geometry.SetShifts(lessons.shifts);
  ReportLessons(stage, lessons);
  OutputOptions output;
  output.compose = {options.samples, options.shutter, options.shadow, options.grain};
  output.ending = EndingOf(options.format, input);
  output.video = options.video;
  NoteEndings(stage, input, output.ending);
  output.sound = SoundOfShot(stage, options, input);
  output.compare = options.compare;
  output.blender = options.blender;
  const std::filesystem::path folder = stage.Output("pictures");
  const Written written =
      WriteShot(folder, input, geometry, film, lessons, output, stage.progress());
  ordered_json joins = ordered_json::array();
  for (const KeyJoin& join : written.joins) joins.push_back(JoinNode(join));
  stage.Report("filmed", input.plan.filmed);
  stage.Report("between", input.plan.between);
  stage.Report("held", input.plan.held);
  stage.Report("filmed_unchanged", written.filmed_unchanged);
  stage.Report("bits", input.kind.bits);
  if (input.sequence && input.sequence->left_out() > 0)
    stage.Note(fmt::format("composite: {} plates lie outside of the animation, and are left out",
                           input.sequence->left_out()));
  ReportPlates(stage, input);
  stage.ReportJson("joins", joins.dump());
  const ordered_json root = {{"schema", 1},
                             {"fps", input.times.fps},
                             {"width", input.shot.camera.width},
                             {"height", input.shot.camera.height},
                             {"joins", joins},
                             {"pictures", PictureNodes(input)}};
  keypose::WriteFile(folder / "composite.json", root.dump(1) + "\n");
  Judge(stage, written.joins);
}

}  // namespace

int main(int argc, char** argv) {
  return keypose::RunStage<CompositeOptions>(argc, argv, kSpec, Run);
}
