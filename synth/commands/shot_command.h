// `keypose synth shot`: films a clay character on a set, with exact truth beside it.
#pragma once

#include <filesystem>
#include <map>
#include <string>
#include <vector>

#include "core/values/progress.h"
#include "synth/commands/photos_command.h"
#include "synth/photographs/shot_set.h"
#include "synth/worlds/world.h"

namespace keypose::synth {

struct ShotCommand {
  std::filesystem::path output;
  std::map<int, std::string> shows = {{0, "rest"}, {4, "wave"}, {8, "bow"}};
  int between = 2;  ///< truth is rendered for so many pictures a filmed frame
  double fps = 12;
  double travel_m = 0.07;  ///< how far the character gets from the first frame to the last
  double turn_deg = 18;    ///< how far it turns meanwhile
  /// A camera that moves: it swings round the set, and comes nearer, slow out and slow in.
  double swing_deg = 0, dolly_m = 0;
  bool keys_only = false;    ///< film only the frames that show a pose
  bool clean_plate = false;  ///< of a moving camera one for each picture of the truth
  bool photographs = true;   ///< of the shown poses, on the turntable
  bool meshes = false;       ///< the true surface of every picture of the truth
  WorldOptions world;
  ShotSetOptions set;
  PhotosCommand photos;

  /// One sentence per fault; empty when valid.
  std::vector<std::string> Problems() const;
};

/// Reads texts such as "4=wave".
/// @throws UsageError  another form, or a frame twice
std::map<int, std::string> ReadShows(const std::vector<std::string>& texts);

/// Writes below `output`:
/// - film/0000.png and on, plate.png or plates/0000.png and on if asked, photos/POSE/ and
/// truth/POSE/
/// - truth/shot/shot.json: the camera, and the character's place in each filmed frame, in metres,
///   from the frame of the poses' truth
/// - truth/shot/mattes/0000.png: of the filmed frames
/// - truth/shot/frames/0001.png: pictures between the filmed ones, counted `between` to a frame;
///   truth/shot/between/ has their mattes
/// @return a sentence for the console
std::string RunShot(const ShotCommand& command, Progress* progress);

}  // namespace keypose::synth
