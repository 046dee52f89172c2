#include "export/export_options.h"

#include <algorithm>

#include "core/values/name_list.h"

namespace keypose::exporting {
namespace {

std::string Joined(const std::vector<std::string>& words) {
  std::string text;
  for (const std::string& word : words) text += (text.empty() ? "" : ", ") + word;
  return text;
}

}  // namespace

void ExportOptions::Describe(OptionVisitor& visit) {
  visit("formats", formats,
        {"formats to write, separated by commas: " + Joined(FormatNames()), ""});
  visit("fps", fps,
        {"frames per second; 0: those of the frames' folder, else 24", "1/s", 0, kMostRate, {}});
  visit("hold", playback.hold,
        {"extra frames for which the first and the last frame are held", "frames", 0, 10000, {}});
  visit("loop", playback.loop,
        {.help = "pingpong plays forwards and then back",
         .unit = "",
         .choices = {"none", "pingpong"}});
  visit("up", up,
        {.help = "axis that points up in the frames; each format gets its own",
         .unit = "",
         .choices = {"z", "y"}});
  visit("unit", unit,
        {.help = "unit of the frames; what is exported is in metres",
         .unit = "",
         .choices = {"m", "cm", "mm"}});
  visit("front", front,
        {"side of the figure that other programs and the film get as its front, counter-clockwise "
         "seen from above; 0: the side of the first photograph (-y)",
         "deg",
         0,
         360,
         {}});
  visit("poses", poses,
        {"names of the keys' poses in order, separated by commas, one per texture in `textures`",
         ""});
  visit("pose_textures", format.pose_textures,
        {.help = "format of a GLB's textures after the first, for viewers that can blend "
                 "textures; none: leave them out; auto: none in glb, jpeg in the others",
         .unit = "",
         .choices = {"auto", "jpeg", "png", "none"}});
  visit("glb_error", format.light.error,
        {"largest error of glb, relative to the figure's diagonal; as few targets as keep it",
         "",
         1e-9,
         1,
         {}});
  visit("glb_texture", format.light.texture,
        {"largest width and height of a texture in glb", "px", 16, 16384, {}});
  visit("max_targets", format.few.max_targets, {"most morph targets of glb-few", "", 1, 255, {}});
  visit("error_bound", format.few.error_bound,
        {"largest error of glb-few, relative to the figure's diagonal; as few targets as keep it, "
         "within max_targets",
         "",
         1e-9,
         1,
         {}});
  DescribeFilm(visit);
}

void ExportOptions::DescribeFilm(OptionVisitor& visit) {
  visit("video_width", format.film.width, {"of the film; even", "px", 64, 7680, {}});
  visit("video_height", format.film.height, {"of the film; even", "px", 64, 4320, {}});
  visit("video_azimuth", format.film.azimuth_deg,
        {"azimuth of the film's camera, counter-clockwise seen from above; 0: the front; -1: the "
         "direction in the front half that shows most motion",
         "deg",
         -1,
         360,
         {}});
  visit("video_elevation", format.film.elevation_deg,
        {"height of the film's camera above the horizon", "deg", 0, 80, {}});
  visit("video_fov", format.film.fov_deg,
        {"vertical field of view of the film's camera: 28 is a 48 mm lens, 53 one of 24 mm, 14 one "
         "of 98 mm; the figure stays as large",
         "deg",
         2,
         90,
         {}});
  visit("video_light", format.film.light,
        {"how much two lamps beside the film's camera model the figure, over the light of the "
         "photographs; 0: not at all",
         "",
         0,
         1,
         {}});
  visit("video_shadow", format.film.shadow, {"whether the figure casts a shadow on its table", ""});
  visit("video_background", format.background,
        {"behind the film's figure: paper, white, grey, black, green or #RRGGBB", ""});
  visit("sound_at", sound_at,
        {"when the sound begins in the film; below 0: so much of its beginning is left out",
         "s",
         -3600,
         3600,
         {}});
  visit("video_turntable", format.turntable,
        {"what character_turntable.mp4 shows: a frame's number or a key's name; empty: the first "
         "key",
         ""});
  visit("video_pictures", format.pictures,
        {"also write every picture of the film as PNG with alpha", ""});
}

std::vector<std::string> ExportOptions::Problems() const {
  std::vector<std::string> problems;
  const std::vector<std::string> known = FormatNames();
  const std::vector<std::string> wanted = NamesIn(formats);
  for (const std::string& name : wanted)
    if (std::find(known.begin(), known.end(), name) == known.end())
      problems.push_back("formats names '" + name + "', but the formats are " + Joined(known));
  if (wanted.empty()) problems.push_back("formats is empty; the formats are " + Joined(known));
  if (fps > 0 && fps < kLeastRate) problems.push_back("fps must be 0 or at least 0.1");
  if (!FilmColor(format.background))
    problems.push_back("video_background is '" + format.background +
                       "', but must be paper, white, grey, black, green or #RRGGBB");
  if (format.film.width % 2 != 0 || format.film.height % 2 != 0)
    problems.push_back("video_width and video_height are " + std::to_string(format.film.width) +
                       " and " + std::to_string(format.film.height) +
                       ", but must be even: the film's colours have half its resolution");
  return problems;
}

}  // namespace keypose::exporting
