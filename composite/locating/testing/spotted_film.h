// A spotted figure filmed from around, with exact cameras and mattes: for tests of whole shots.
#pragma once

#include <vector>

#include "composite/locating/search/located_shot.h"

namespace keypose::composite {

/// Frames of 480 x 480 pixels from 20 degrees above. The lens is given.
struct SpottedFilm {
  Mesh mesh;
  Image8 texture;
  std::vector<View> truth;
  ShotInput input;  ///< refers to `mesh`, without the texture

  SpottedFilm(const Mesh& filmed, const Image8& painted, const std::vector<double>& azimuths_deg);
  SpottedFilm(const SpottedFilm&) = delete;

 private:
  void Add(const View& view);
};

}  // namespace keypose::composite
