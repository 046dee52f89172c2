// Folders of numbered frames, which stages of animation exchange: frame_0000.ply and on, and
// distortion.json.
#pragma once

#include <filesystem>
#include <string>
#include <vector>

namespace keypose {

/// The frames of a folder, in order of their numbers, which must be 0, 1, 2, ...
/// @param stage  its name, for messages
/// @throws InputError  not a folder, no frames, a number that is missing or twice
std::vector<std::filesystem::path> NumberedFrames(const std::filesystem::path& folder,
                                                  const std::string& stage);

/// "frame_0007.ply"
std::string FrameFileName(int frame);

/// Frames per second as the folder's distortion.json has them; 0 where it has none.
double FrameRateOf(const std::filesystem::path& folder);

/// What a folder's distortion.json says of its frames' times; lists are empty where it does not.
struct FrameTimes {
  double fps = 0;               ///< 0: not known
  std::vector<int> key_frames;  ///< the frame of each key
  std::vector<double> t;        ///< per frame: key number plus share of the way to the next
};
/// @throws InputError  distortion.json is not JSON with a list `frames`
FrameTimes ReadFrameTimes(const std::filesystem::path& folder, int frame_count);

/// What is known of each frame of a motion that was not interpolated between keys.
struct FrameMeasures {
  double area = 1, volume = 1;  ///< relative to the shape at rest
};
/// The distortion.json of such a motion: each frame is a moment of one span, and the straight
/// lines' values, which need keys, repeat the frame's own.
std::string FrameNotesText(const std::vector<FrameMeasures>& frames, double fps,
                           const std::string& method);

}  // namespace keypose
