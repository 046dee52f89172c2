// keypose-synth: synthetic worlds with known truth: photographs, pairs for registration, simulated
// picks, scores, and damaged photographs for tests.
#include <CLI/CLI.hpp>
#include <cstdio>
#include <exception>
#include <string>

#include "core/io/text/files.h"
#include "core/values/errors.h"
#include "core/values/kept_memory.h"
#include "core/values/size_of.h"
#include "synth/commands/pair_command.h"
#include "synth/commands/performance_command.h"
#include "synth/commands/photos_command.h"
#include "synth/commands/score_command.h"
#include "synth/commands/shot_command.h"
#include "synth/photographs/damaged_photographs.h"
#include "synth/rooms/room_command.h"
#include "synth/rooms/room_score_command.h"
#include "synth/scores/motion_score.h"
#include "synth/scores/shot_score.h"
#include "synth/scores/surface_score.h"
#include "synth/scores/video_score.h"

namespace {

using namespace keypose;
using namespace keypose::synth;

class ConsoleProgress final : public Progress {
 public:
  void Update(double fraction, std::string_view what) override {
    std::fprintf(stderr, "synth: %3.0f %% %.*s\n", 100 * fraction, SizeOf(what), what.data());
  }
};

void AddMishaps(CLI::App& photos, Mishaps& m) {
  photos.add_option("--stray", m.strays, "photographs that show another character instead")
      ->capture_default_str();
  photos.add_option("--stray-seed", m.stray_seed, "seed of that character; 0: the next seed")
      ->capture_default_str();
  photos.add_option("--hand", m.hands, "photographs with a hand that covers part of the figure")
      ->capture_default_str();
  photos.add_option_function<std::string>(
      "--moved", [&m](const std::string& text) { ReadMove(text, &m); },
      "SHARE:MOVE: after that share of the photographs the figure is bumped; 0.5:5mm,7deg, or into "
      "another pose: 0.5:bow");
  photos
      .add_option("--lamp-fall", m.lamp_falls_after,
                  "after that share of the photographs the lamp lies on the other side; 1: never")
      ->capture_default_str();
}

void AddPhotos(CLI::App& app, PhotosCommand& c) {
  CLI::App* photos = app.add_subcommand(
      "photos", "render turntable photographs of a clay character, with exact truth beside them");
  photos->add_option("--output", c.output, "folder to write photos/ and truth/ into")->required();
  photos
      ->add_option(
          "--poses", c.poses,
          "rest, bent, wave, bow, squash, twist, hip (hand on hip), limbs (all limbs moved "
          "by 30 to 120 degrees); columns: rest, bent, twist, squash")
      ->delimiter(',')
      ->capture_default_str();
  photos
      ->add_option("--character", c.world.character,
                   "creature | columns (a torso on columns that one sees through)")
      ->capture_default_str();
  photos->add_option("--seed", c.world.seed, "character; 1 is the demo's")->capture_default_str();
  photos->add_option("--pose-seed", c.world.pose_seed, "of the pose limbs; 1 unless said");
  photos
      ->add_option_function<std::vector<std::string>>(
          "--few", [&c](const std::vector<std::string>& list) { c.few = ReadFew(list); },
          "POSE=N: only N photographs of that pose, from the rig of the first pose that is not "
          "listed here")
      ->delimiter(',');
  photos->add_option("--texture", c.world.texture, "rich | weak | none")->capture_default_str();
  photos->add_flag("--prints-move", c.world.prints_move,
                   "finger-prints move the surface, which needs a fine --spacing; otherwise they "
                   "only affect shading");
  photos->add_option("--print-height", c.world.print_height_m, "of finger-prints [m]")
      ->capture_default_str();
  photos
      ->add_option("--print-spacing", c.world.print_spacing_m,
                   "height of the ridges of finger-prints [m]")
      ->capture_default_str();
  photos
      ->add_option("--spacing", c.world.spacing_m,
                   "approximate spacing of the true surface's vertices [m]")
      ->capture_default_str();
  photos->add_option("--views", c.photographer.views, "photographs per pose, over all rings")
      ->capture_default_str();
  photos->add_option("--elevations", c.photographer.elevations_deg, "one ring per elevation [deg]")
      ->delimiter(',')
      ->capture_default_str();
  photos->add_option("--width", c.photographer.width, "[px]")->capture_default_str();
  photos
      ->add_option("--height", c.photographer.height,
                   "[px]; default: 3/4 of the width if only that is given")
      ->capture_default_str();
  photos
      ->add_option("--enlarge", c.photographer.enlarge,
                   "draw so many times smaller and enlarge: large photographs in little time")
      ->capture_default_str();
  photos->add_option("--focal", c.photographer.focal_35mm, "35 mm equivalent [mm]")
      ->capture_default_str();
  photos->add_option("--noise", c.photographer.noise, "sensor noise; 1: an ordinary camera")
      ->capture_default_str();
  photos->add_option("--blur", c.photographer.blur_px, "standard deviation of the lens blur [px]")
      ->capture_default_str();
  photos
      ->add_option("--vignetting", c.photographer.vignetting, "share of light lost in the corners")
      ->capture_default_str();
  photos->add_option("--backdrop", c.photographer.background, "studio | plain")
      ->capture_default_str();
  photos
      ->add_option("--table-shadow", c.photographer.table_shadow,
                   "darkness of the shadow on the table, 0 to 1")
      ->capture_default_str();
  photos->add_flag("!--no-shadows", c.photographer.shadows, "light that casts no shadow");
  photos->add_flag("--charuco", c.photographer.board.charuco,
                   "a ChArUco calibration board under the character");
  photos->add_option_function<std::string>(
      "--board", [&c](const std::string& text) { c.photographer.board.Say(text); },
      "that board as capture's --board says it, such as 8x11:22mm:DICT_4X4_50:legacy");
  photos->add_flag("--flip", c.flip,
                   "also the same number of photographs of the character on its back");
  photos->add_flag("--clean-plate", c.clean_plate, "also photograph the empty set");
  AddMishaps(*photos, c.photographer.mishaps);
  photos->add_option("--photographer-seed", c.photographer.seed, "seed of jitter and noise")
      ->capture_default_str();
  photos->callback([photos, &c] {
    if (photos->count("--width") && !photos->count("--height"))
      c.photographer.height = c.photographer.width * 3 / 4;
    ConsoleProgress progress;
    std::printf("%d photographs in %s\n", RunPhotos(c, &progress), (c.output / "photos").c_str());
  });
}

void AddRoom(CLI::App& app, RoomCommand& c) {
  CLI::App* room = app.add_subcommand(
      "room", "photograph a clay figure in a room, as people do at home, with exact truth");
  RoomOptions& r = c.room;
  room->add_option("output,--output", c.output, "folder to write photos/ and truth/ into")
      ->required();
  room->add_option("--seed", r.seed, "of the room, the figure and the camera's way")
      ->capture_default_str();
  room->add_option("--kind", r.kind,
                   "walk, mat, mat-hand, both, one-side; trunk and relief, whose figure does not "
                   "stand free; default: by the seed");
  room->add_option("--photographs", r.photographs, "default: 36, fewer of one side");
  room->add_option_function<std::string>(
      "--size", [&r](const std::string& text) { ReadSize(text, &r.width, &r.height); },
      "WIDTHxHEIGHT of a photograph held level [px]; default 1200x800");
  room->add_option("--second", r.second, "another thing: none, apart, touching");
  room->add_option("--hands", r.hands, "photographs with a person's hand");
  room->add_option("--exif", r.exif, "yes | no");
  room->add_option("--lenses", r.lenses, "1 | 2: close-ups with another focal length");
  room->add_option("--texture", r.texture, "rich | weak: contrast of the figure's paint");
  room->add_option("--detail", r.detail, "of all printed things; 1 is for 1 to 2 megapixels")
      ->capture_default_str();
  room->add_option("--noise", r.noise, "sensor noise; 1: an ordinary camera")
      ->capture_default_str();
  room->add_option("--spacing", r.spacing_m, "of the figure's vertices [m]")->capture_default_str();
  room->callback([&c] {
    ConsoleProgress progress;
    std::printf("%s\n", RunRoom(c, &progress).c_str());
  });
}

void AddRoomScore(CLI::App& app, RoomScoreCommand& c) {
  CLI::App* score = app.add_subcommand(
      "score-room", "compare what was made of a room's photographs with its truth; prints JSON");
  score->add_option("--truth", c.truth, "truth/figure that `synth room` wrote")->required();
  score->add_option("--model", c.model, "COLMAP model");
  score->add_option("--masks", c.masks, "folder of masks NAME.png");
  score->add_option("--mesh", c.mesh, "mesh in the model's frame");
  score->callback([&c] { std::fputs(RunRoomScore(c).c_str(), stdout); });
}

void AddPair(CLI::App& app, PairCommand& c) {
  CLI::App* pair = app.add_subcommand(
      "pair", "two scans of a strongly bent clay figure, and the exact position of every vertex");
  pair->add_option("DIR,--output", c.output, "folder to write into")->required();
  pair->add_option("--shape", c.pair.shape.shape, "tentacle | character")->capture_default_str();
  pair->add_option("--seed", c.pair.shape.seed,
                   "0: the standard tentacle; others vary proportions and bending planes")
      ->capture_default_str();
  pair->add_option("--bend", c.pair.shape.bend_deg, "bend of the limbs [deg], 0 to 280")
      ->capture_default_str();
  pair->add_option("--twist", c.pair.shape.twist_deg,
                   "twist of the limbs about their own axes [deg]")
      ->capture_default_str();
  pair->add_option("--squash", c.pair.shape.squash,
                   "factor on the height of the target; widths are divided by its square root")
      ->capture_default_str();
  pair->add_option("--landmarks", c.pair.shape.places,
                   "number of picks; tips and body first, then along the limbs")
      ->capture_default_str();
  pair->add_option("--vertices", c.pair.vertices, "approximate number in the source")
      ->capture_default_str();
  pair->add_option("--ratio", c.pair.ratio, "target faces per source face")->capture_default_str();
  pair->add_option("--noise", c.pair.noise,
                   "noise of the target vertices: standard deviation per axis / diagonal")
      ->capture_default_str();
  pair->add_option("--landmark-noise", c.pair.landmark_noise,
                   "noise of the picks on the target; below 0: four times --noise")
      ->capture_default_str();
  pair->add_option("--holes", c.pair.holes, "number of holes in the target, none on a landmark")
      ->capture_default_str();
  pair->add_option("--hole-area", c.pair.hole_area,
                   "share of the target's area of all holes together")
      ->capture_default_str();
  pair->add_option("--turn", c.pair.turn_deg,
                   "rotation of the whole target about a random axis [deg]")
      ->capture_default_str();
  pair->add_option("--scale", c.pair.scale, "scale of the whole target")->capture_default_str();
  pair->callback([&c] { std::printf("%s\n", RunPair(c).c_str()); });
}

void AddPick(CLI::App& app, PickCommand& c) {
  CLI::App* pick = app.add_subcommand(
      "pick", "simulate an artist's clicks: the true landmarks on a reconstructed mesh");
  pick->add_option("--truth", c.truth, "truth/POSE")->required();
  pick->add_option("--model", c.model, "the pose's COLMAP model")->required();
  pick->add_option("--mesh", c.mesh, "mesh in the model's frame")->required();
  pick->add_option("--output", c.output, "landmarks (.json)")->required();
  pick->add_option("--reach", c.reach,
                   "leave out landmarks farther from the mesh than this share of its diagonal")
      ->capture_default_str();
  pick->callback([&c] { std::printf("%s\n", RunPick(c).c_str()); });
}

struct ScoreFlags {
  ScoreCommand command;
  std::string json;
};

void AddScore(CLI::App& app, ScoreFlags& flags) {
  ScoreCommand& c = flags.command;
  CLI::App* score =
      app.add_subcommand("score", "compare a reconstruction with its truth; prints JSON");
  score->add_option("--truth", c.truth, "truth/POSE")->required();
  score->add_option("--model", c.model, "the pose's COLMAP model")->required();
  score->add_option("--mesh", c.mesh, "mesh in the model's frame")->required();
  score->add_option("--cloud", c.cloud, "dense cloud in the model's frame");
  score->add_option("--hull", c.hull,
                    "visual hull in the truth's frame, from `synth hull`, to compare with");
  CLI::Option* registered =
      score->add_option("--registered", c.registered, "the template, registered onto this pose");
  for (CLI::Option* option :
       {score->add_option("--template-truth", c.template_truth, "truth/POSE of the template"),
        score->add_option("--template-model", c.template_model, "the template's COLMAP model"),
        score->add_option("--template-mesh", c.template_mesh,
                          "the template, as the input of registration")}) {
    registered->needs(option);
    option->needs(registered);
  }
  CLI::Option* texture =
      score->add_option("--texture", c.texture, "the registered template's texture, of this pose")
          ->needs(registered);
  texture->needs(
      score->add_option("--template-texture", c.template_texture, "the template's own texture")
          ->needs(texture));
  score->add_option("--json", flags.json, "also write it here");
  score->callback([&flags] {
    const std::string json = RunScore(flags.command);
    std::fputs(json.c_str(), stdout);
    if (!flags.json.empty()) WriteFile(flags.json, json);
  });
}

void AddHull(CLI::App& app, HullCommand& c) {
  CLI::App* hull = app.add_subcommand("hull", "the visual hull of the true masks and cameras");
  hull->add_option("--truth", c.truth, "truth/POSE")->required();
  hull->add_option("--output", c.output, "mesh (.ply)")->required();
  hull->add_option("--spacing", c.spacing_m, "of its lattice [m]")->capture_default_str();
  hull->callback([&c] { std::printf("%s\n", RunHull(c).c_str()); });
}

struct DamageFlags {
  std::string photos, output, kind;
  std::vector<std::string> names;
};

void AddDamage(CLI::App& app, DamageFlags& c) {
  CLI::App* damage =
      app.add_subcommand("damage", "copy a folder of photographs and damage some of the copies");
  damage->add_option("--photos", c.photos, "folder to copy")->required();
  damage->add_option("--output", c.output, "folder for the copies")->required();
  damage
      ->add_option(
          "--kind", c.kind,
          "truncate, empty, no-image, blur, dark, drop, rotate, upside-down, resize, strip-exif, "
          "hand, tool, thumb")
      ->required();
  damage->add_option("--names", c.names, "names of the files to damage; default: all")
      ->delimiter(',');
  damage->callback([&c] { DamagePhotos(c.photos, c.output, DamageKindNamed(c.kind), c.names); });
}

void AddPerformance(CLI::App& app, PerformanceCommand& c) {
  CLI::App* performance = app.add_subcommand(
      "performance", "film a moving actor with several cameras, with exact truth beside it");
  performance->add_option("--output", c.output, "folder to write into")->required();
  performance->add_option("--bvh", c.bvh,
                          "the motion: a clip of the CMU database; default: our own");
  performance->add_option("--first", c.first_frame, "first frame of the clip")
      ->capture_default_str();
  performance->add_option("--every", c.every, "so many frames of the clip are one of the film")
      ->capture_default_str();
  performance->add_option("--frames", c.frames, "frames to film")->capture_default_str();
  performance->add_option("--cameras", c.cameras, "in a ring; one more is held out")
      ->capture_default_str();
  performance->add_option("--size", c.size_px, "side of the pictures [px]")->capture_default_str();
  performance->add_option("--noise", c.noise_px, "standard deviation of the masks' outlines [px]")
      ->capture_default_str();
  performance->add_flag("!--masks-only", c.pictures, "no colour pictures");
  performance->add_option(
      "--meshes", c.mesh_spacing_m,
      "the actor's true mesh in each frame too, with vertices so far apart [m]");
  performance->add_flag("!--no-start-pose", c.start_pose,
                        "do not begin with arms and legs apart, as actors do for their measures");
  performance->add_option("--seed", c.performer.seed, "proportions, girths, clothes, colours")
      ->capture_default_str();
  performance->add_option("--spacing", c.performer.spacing_m, "of the actor's vertices [m]")
      ->capture_default_str();
  performance->add_option("--cloth", c.performer.cloth_m, "height of the clothes' waves [m]")
      ->capture_default_str();
  performance
      ->add_option("--hide-arm-from", c.hidden_from,
                   "the left arm is missing in all masks from this frame")
      ->capture_default_str();
  performance->add_option("--hide-arm-to", c.hidden_to, "up to this frame")->capture_default_str();
  performance->callback([&c] {
    ConsoleProgress progress;
    std::printf("%s\n", RunPerformance(c, &progress).c_str());
  });
}

void AddShotCamera(CLI::App& shot, ShotSetOptions& set) {
  shot.add_option("--width", set.width, "of the film [px]; the height is 9/16 of it unless given")
      ->capture_default_str();
  shot.add_option("--height", set.height, "[px]");
  shot.add_option("--focal", set.focal_35mm, "35 mm equivalent [mm]")->capture_default_str();
  shot.add_option("--distance", set.distance_m, "of the camera [m]")->capture_default_str();
  shot.add_option("--camera-azimuth", set.camera_azimuth_deg, "[deg], -90: from the front")
      ->capture_default_str();
  shot.add_option("--camera-elevation", set.camera_elevation_deg, "[deg]")->capture_default_str();
  shot.add_option("--lamp-azimuth", set.lamp_azimuth_deg, "[deg]")->capture_default_str();
  shot.add_option("--lamp-elevation", set.lamp_elevation_deg, "[deg]")->capture_default_str();
  shot.add_option("--grain", set.grain, "sensor noise; 1: an ordinary camera")
      ->capture_default_str();
  shot.add_option("--grain-seed", set.seed, "of the sensor noise")->capture_default_str();
}

void AddShot(CLI::App& app, ShotCommand& c) {
  CLI::App* shot = app.add_subcommand(
      "shot", "film a clay character on a set, and photograph its key poses, with exact truth");
  shot->add_option("--output", c.output, "folder to write into")->required();
  shot->add_option_function<std::vector<std::string>>(
          "--shows", [&c](const std::vector<std::string>& list) { c.shows = ReadShows(list); },
          "FRAME=POSE: which frames show a key pose; default 0=rest,4=wave,8=bow")
      ->delimiter(',');
  shot->add_option("--fps", c.fps, "filmed frames a second")->capture_default_str();
  shot->add_option("--between", c.between, "pictures of the truth a filmed frame")
      ->capture_default_str();
  shot->add_option("--travel", c.travel_m, "way of the character over the shot [m]")
      ->capture_default_str();
  shot->add_option("--turn", c.turn_deg, "turn of the character over the shot [deg]")
      ->capture_default_str();
  shot->add_option("--swing", c.swing_deg, "turn of the camera round the set over the shot [deg]")
      ->capture_default_str();
  shot->add_option("--dolly", c.dolly_m, "way of the camera towards the set over the shot [m]")
      ->capture_default_str();
  shot->add_flag("--keys-only", c.keys_only, "film only the frames that show a key pose");
  shot->add_flag("--clean-plate", c.clean_plate, "also film the empty set");
  shot->add_flag("!--no-photographs", c.photographs, "film only");
  shot->add_flag("--meshes", c.meshes, "also write the true surface of every picture");
  shot->add_option("--seed", c.world.seed, "character; 1 is the demo's")->capture_default_str();
  shot->add_option("--texture", c.world.texture, "rich | weak | none")->capture_default_str();
  shot->add_option("--spacing", c.world.spacing_m, "of the true surface's vertices [m]")
      ->capture_default_str();
  AddShotCamera(*shot, c.set);
  PhotographerOptions& photographer = c.photos.photographer;
  shot->add_option("--views", photographer.views, "photographs per pose")->capture_default_str();
  shot->add_option("--photo-width", photographer.width, "[px]; the height is 3/4 of it")
      ->capture_default_str();
  shot->add_option_function<std::vector<std::string>>(
          "--few", [&c](const std::vector<std::string>& list) { c.photos.few = ReadFew(list); },
          "POSE=N: only N photographs of that pose")
      ->delimiter(',');
  shot->add_flag("--charuco", photographer.board.charuco,
                 "a ChArUco calibration board under the character on the turntable");
  shot->callback([shot, &c] {
    if (!shot->count("--height")) c.set.height = c.set.width * 9 / 16;
    c.photos.photographer.height = c.photos.photographer.width * 3 / 4;
    ConsoleProgress progress;
    std::printf("%s\n", RunShot(c, &progress).c_str());
  });
}

void AddVideoScore(CLI::App& app, VideoScoreCommand& c) {
  CLI::App* score = app.add_subcommand(
      "score-video",
      "compare a textured performance with the film of the camera that it never saw; prints JSON");
  score->add_option("--performance", c.performance, "folder that `synth performance` wrote")
      ->required();
  score->add_option("--frames", c.frames, "frames of the moving mesh")->required();
  score->add_option("--textures", c.textures, "textures of video3d")->required();
  score->add_option("--layout", c.layout, "mesh with texture coordinates, if frames have none");
  score->add_option("--every", c.every, "only every n-th frame")->capture_default_str();
  score->add_option("--picture", c.picture,
                    "also film, render, and difference side by side (.jpg)");
  score->callback([&c] { std::printf("%s", ToJson(ScoreVideo(c)).c_str()); });
}

void AddShotScore(CLI::App& app, ShotScoreCommand& c) {
  CLI::App* score = app.add_subcommand(
      "score-shot", "compare the pictures of a finished shot with the truth; prints JSON");
  score->add_option("--shot", c.shot, "folder that `synth shot` wrote")->required();
  score->add_option("--pictures", c.pictures, "pictures of `composite`")->required();
  score->add_option("--sheet", c.sheet, "also write made, true and difference side by side (.png)");
  score->callback([&c] { std::fputs(ToJson(ScoreShot(c)).c_str(), stdout); });
}

void AddMotionScore(CLI::App& app, MotionScoreCommand& c) {
  CLI::App* score = app.add_subcommand("score-motion",
                                       "compare a tracked performance with its truth; prints JSON");
  score->add_option("--performance", c.performance, "folder that `synth performance` wrote")
      ->required();
  score->add_option("--frames", c.frames, "frames of `track`")->required();
  score->add_option("--motion", c.motion, "motion of `track` (.bvh)")->required();
  score->add_option("--from", c.from, "first frame that counts")->capture_default_str();
  score->callback([&c] { std::fputs(ToJson(ScoreMotion(c)).c_str(), stdout); });
}

void AddSurfaceScore(CLI::App& app, SurfaceScoreCommand& c) {
  CLI::App* score = app.add_subcommand(
      "score-surface", "compare a moving mesh with the true surface of a performance; prints JSON");
  score->add_option("--performance", c.performance, "folder that `synth performance` wrote")
      ->required();
  score->add_option("--frames", c.frames, "frames of the moving mesh")->required();
  score->add_option("--every", c.every, "only every n-th frame is measured")->capture_default_str();
  score->callback([&c] { std::fputs(ToJson(ScoreMovingSurface(c)).c_str(), stdout); });
}

}  // namespace

int main(int argc, char** argv) {
  keypose::KeepFreedMemory();
  CLI::App app("Synthetic worlds with known truth", "keypose-synth");
  app.require_subcommand(1);
  PhotosCommand photos;
  RoomCommand room;
  RoomScoreCommand room_score;
  PairCommand pair;
  PickCommand pick;
  ScoreFlags score;
  HullCommand hull;
  DamageFlags damage;
  PerformanceCommand performance;
  MotionScoreCommand motion_score;
  VideoScoreCommand video_score;
  SurfaceScoreCommand surface_score;
  ShotCommand shot;
  ShotScoreCommand shot_score;
  AddPhotos(app, photos);
  AddRoom(app, room);
  AddRoomScore(app, room_score);
  AddPair(app, pair);
  AddPick(app, pick);
  AddScore(app, score);
  AddHull(app, hull);
  AddDamage(app, damage);
  AddPerformance(app, performance);
  AddMotionScore(app, motion_score);
  AddVideoScore(app, video_score);
  AddSurfaceScore(app, surface_score);
  AddShot(app, shot);
  AddShotScore(app, shot_score);
  try {
    app.parse(argc, argv);
    return 0;
  } catch (const CLI::CallForHelp& help) {
    return app.exit(help);
  } catch (const CLI::ParseError& fault) {
    app.exit(fault);
    return static_cast<int>(ExitCode::kUsage);
  } catch (const Error& fault) {
    std::fprintf(stderr, "%s\n", fault.what());
    return static_cast<int>(fault.code());
  } catch (const std::exception& fault) {
    std::fprintf(stderr, "synth: a bug: %s\n", fault.what());
    return static_cast<int>(ExitCode::kBug);
  }
}
