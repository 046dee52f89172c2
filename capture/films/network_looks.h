// What the network says of single frames, seen closely, and what that means for frames near them.
#pragma once

#include <functional>
#include <vector>

#include "core/values/image.h"

namespace keypose::capture {

/// The network's opinion on a picture, of the picture's size; see SalienceNetwork::Of.
using AskNetwork = std::function<Image8(const Image8& rgb)>;

/// One frame that the network was shown.
struct NetworkLook {
  int frame = 0;
  Image8 lab;       ///< the frame, of the film's usual exposure
  Image8 salience;  ///< of the same size; 127 where it was not shown
};

/// Opinions on some frames of a film. In the whole picture the network often takes a piece of the
/// set for the object; in a square about the actor it seldom does, and it tells a dark chair from
/// dark shorts by their shapes, which colours do not.
class NetworkLooks {
 public:
  /// Shows the network a square about the actor. An opinion that has little in common with the mask
  /// is of something else, and is forgotten.
  /// @param rgb, lab  the frame
  /// @param mask      the actor in it, 255 or 0
  /// @return whether the opinion is kept
  bool Add(int frame, const Image8& rgb, const Image8& lab, const Image8& mask,
           const AskNetwork& network);

  bool empty() const { return looks_.empty(); }

  /// Log odds of actor against set at each pixel of any frame, from the nearest looks before and
  /// after it: an opinion holds where the pixel has kept its colour, less the longer ago it is.
  /// @param radius  distance below which colours are the same; see ModeDistance
  ImageF Odds(int frame, const Image8& lab, double radius) const;

 private:
  std::vector<NetworkLook> looks_;  // ascending
};

}  // namespace keypose::capture
